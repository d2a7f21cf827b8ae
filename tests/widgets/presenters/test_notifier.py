"""Messages in the real window: plain text, one progress per job, one report per error."""

from __future__ import annotations

import ast
import pickle
import re
import time
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QToolButton

import tactile_widgets
from tactile_widgets.context.notification_bar import OFFER_SECONDS, READ_SECONDS
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import cancel, press_map, record_run, run


@pytest.fixture
def window(window_again):
    """Window without messages."""
    return window_again


@pytest.fixture
def crash_files(tmp_path, monkeypatch):
    """Files with the details of unexpected errors."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return lambda: list((tmp_path / "state").rglob("*crash*"))


def test_message_is_shown_as_plain_text(window):
    text = "arm.urdf: its root must be <robot>, not <b>model</b>"
    window.live.failed.emit(text)
    assert window.notification_bar.text == text
    assert window.notification_bar.findChild(QLabel, "message-text").textFormat() == Qt.TextFormat.PlainText


def test_information_disappears_by_itself_and_a_failure_with_the_next_document(window, monkeypatch, prepared):
    bar = window.notification_bar
    now = time.monotonic()
    window.notifier.say("Saved a.mcap")
    window.notifier.fault("a.toml cannot be read", of="open file")
    monkeypatch.setattr(bar, "_clock", lambda: now + READ_SECONDS - 0.5)
    bar._read.timeout.emit()
    assert [message.text for message in bar.messages] == ["Saved a.mcap", "a.toml cannot be read"]
    monkeypatch.setattr(bar, "_clock", lambda: now + READ_SECONDS + 0.5)
    bar._read.timeout.emit()
    assert [message.text for message in bar.messages] == ["a.toml cannot be read"]
    window.live.show_prepared(prepared)
    assert bar.text == ""
    assert [note.text for note in window.column["messages"].list.notes][1:3] == [
        "a.toml cannot be read",
        "Saved a.mcap",
    ]


@pytest.fixture
def later(window, monkeypatch):
    """Function that lets seconds pass for the messages."""
    now = [time.monotonic()]
    monkeypatch.setattr(window.notification_bar, "_clock", lambda: now[0])

    def wait(seconds):
        now[0] += seconds
        window.notification_bar._read.timeout.emit()

    return wait


def texts(window):
    return [message.text for message in window.notification_bar.messages]


def test_information_with_an_action_leaves_after_half_a_minute(window, later):
    actions = [QAction("Replay", window), QAction("Show in folder", window)]
    window.notifier.say("Saved a.mcap", remedies=actions)
    window.notifier.say("Saved a.csv")
    later(READ_SECONDS + 0.5)
    assert texts(window) == ["Saved a.mcap"]
    later(OFFER_SECONDS - READ_SECONDS - 1.0)
    assert texts(window) == ["Saved a.mcap"]
    later(1.0)
    assert texts(window) == []


def test_information_whose_actions_are_not_possible_leaves_as_others_do(window, later):
    actions = [QAction("Replay", window), QAction("Show in folder", window)]
    window.notifier.say("Saved a.mcap", remedies=actions)
    actions[0].setEnabled(False)
    later(READ_SECONDS + 0.5)
    assert texts(window) == ["Saved a.mcap"]
    actions[1].setEnabled(False)
    assert window.notification_bar._read.isActive()
    later(0.5)
    assert texts(window) == []


def test_failures_offers_and_pending_messages_do_not_leave_by_time(window, later):
    action = QAction("Simulate fingers", window)
    pending = [True]
    window.notifier.say("a.npz cannot be read", fault=True, remedies=[action])
    window.notifier.offer("Restore the edits?", remedies=[action], dismiss="Later")
    window.notifier.say("No finger is simulated", remedies=[action], pending=lambda: pending[0])
    later(100 * OFFER_SECONDS)
    assert texts(window) == ["a.npz cannot be read", "Restore the edits?", "No finger is simulated"]
    pending[0] = False
    later(0.5)
    assert texts(window) == ["a.npz cannot be read", "Restore the edits?"]
    window.notifier.withdraw()


def test_time_under_the_pointer_does_not_count(window, later):
    bar = window.notification_bar
    window.notifier.say("Saved a.mcap", remedies=[QAction("Replay", window)])
    later(OFFER_SECONDS - 1.0)
    QTest.mouseMove(bar.findChild(QLabel, "message-text"))
    later(2 * OFFER_SECONDS)
    assert texts(window) == ["Saved a.mcap"]
    QTest.mouseMove(window.map_view.viewport(), QPoint(20, 20))
    later(0.5)
    assert texts(window) == ["Saved a.mcap"]
    later(0.5)
    assert texts(window) == []


def places(window):
    """Return the upper edge of each visible message on the screen, by text."""
    QApplication.processEvents()
    labels = window.notification_bar.findChildren(QLabel)
    return {label.text(): label.mapToGlobal(QPoint(0, 0)).y() for label in labels if label.isVisible()}


def point_at(window, text):
    """Move the pointer over a message."""
    labels = window.notification_bar.findChildren(QLabel)
    (label,) = [label for label in labels if label.isVisible() and label.text() == text]
    QTest.mouseMove(label)
    return label.parentWidget()


def point_away(window):
    QTest.mouseMove(window.map_view.viewport(), QPoint(20, 20))
    QApplication.processEvents()


def test_new_message_is_above_the_others_which_do_not_move(window):
    window.notifier.fault("a.npz cannot be read")
    before = places(window)
    for name in "bc":
        window.notifier.say(f"Saved {name}.mcap", remedies=[QAction("Replay", window)])
        after = places(window)
        assert after.items() > before.items()
        assert min(after, key=after.get) == f"Saved {name}.mcap"
        before = after


def test_messages_under_the_pointer_do_not_move_or_leave(window, later):
    replay = QAction("Replay", window)
    pressed = []
    replay.triggered.connect(lambda: pressed.append("Replay"))
    window.notifier.say("Saved a.csv")
    window.notifier.fault("b.npz cannot be read", of="open map")
    window.notifier.say("Saved c.mcap", remedies=[replay])
    before = places(window)
    toast = point_at(window, "Saved c.mcap")
    later(2 * READ_SECONDS)
    window.notifier.succeed("open map")
    window.notifier.fault("d.npz cannot be read")
    assert places(window) == before
    left_click(toast.findChild(QToolButton, "message-remedy"))
    assert pressed == ["Replay"]
    assert places(window).items() < before.items(), "the place of the message that was used remains empty"
    point_away(window)
    assert texts(window) == ["Saved a.csv", "d.npz cannot be read"]
    assert list(places(window)) == ["Saved a.csv", "d.npz cannot be read"]


def test_message_that_is_over_cannot_be_used_while_the_pointer_keeps_it(window):
    window.notifier.say("a.npz cannot be read", fault=True, of="open map", remedies=[QAction("Help", window)])
    toast = point_at(window, "a.npz cannot be read")
    button = toast.findChild(QToolButton, "message-remedy")
    assert button.isEnabled()
    window.notifier.succeed("open map")
    assert list(places(window)) == ["a.npz cannot be read"]
    assert not button.isEnabled()
    point_away(window)
    assert places(window) == {}
    assert not window.notification_bar.isVisible()


class LeaveOnHide(QObject):
    """Sends a leave event to the messages while one of them is hidden, as Qt does with the pointer over it."""

    def eventFilter(self, watched, event):
        if event.type() is QEvent.Type.Hide and watched.parentWidget() is not None:
            QApplication.sendEvent(watched.parentWidget(), QEvent(QEvent.Type.Leave))
        return False


def test_pointer_that_leaves_while_a_message_is_hidden_removes_the_others_once(window):
    bar = window.notification_bar
    window.notifier.fault("a.toml cannot be read", of="open file")
    window.notifier.fault("b.npz cannot be read", of="open map")
    QApplication.processEvents()
    leaving = LeaveOnHide(bar)
    for toast in bar._toasts:
        toast.installEventFilter(leaving)
    bar.clear()
    assert (bar._toasts, bar.isVisible()) == ([], False)


def test_message_that_waited_for_room_takes_the_place_of_information(window):
    for name in "abc":
        window.notifier.say(f"Saved {name}.csv")
    before = places(window)
    point_at(window, "Saved a.csv")
    for name in "de":
        window.notifier.fault(f"{name}.npz cannot be read")
        assert places(window) == before
    point_away(window)
    assert list(places(window)) == ["Saved c.csv", "d.npz cannot be read", "e.npz cannot be read"]


def test_information_with_an_action_leaves_for_others_before_failures_do(window):
    window.notifier.fault("a.npz cannot be read", of="open map")
    window.notifier.say("Saved a.mcap", remedies=[QAction("Replay", window)])
    for name in "bcd":
        window.notifier.say(f"Saved {name}.csv")
    expected = ["a.npz cannot be read", "Saved a.mcap", "Saved d.csv"]
    assert [message.text for message in window.notification_bar.messages] == expected
    for name in "ef":
        window.notifier.fault(f"{name}.npz cannot be read")
    expected = ["a.npz cannot be read", "e.npz cannot be read", "f.npz cannot be read"]
    assert [message.text for message in window.notification_bar.messages] == expected


def test_actions_of_messages_leave_with_the_document_they_act_on(window, tmp_path, prepared):
    bar = window.notification_bar
    window.presenters.map_files._save(tmp_path / "own.npz")
    assert bar.findChild(QToolButton, "message-remedy").text() == "Save scene as"
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
    assert bar.messages == ()
    window.presenters.map_files._save(tmp_path / "other.npz")
    record_run(window, tmp_path / "a.mcap", 0.1)
    assert len(bar.messages) == 2
    window.live.open_recording(tmp_path / "a.mcap")
    assert [message.text for message in bar.messages] == [f"Saved {tmp_path / 'a.mcap'}"], "it replays a file"
    window.live.replay.leave()
    assert len(bar.messages) == 1


def test_messages_are_a_stack_of_three_that_keeps_failures(window):
    bar = window.notification_bar
    window.notifier.fault("a.npz cannot be read", of="open map")
    for name in ("b", "c", "d"):
        window.notifier.say(f"Saved {name}.csv")
    QApplication.processEvents()
    assert [message.text for message in bar.messages] == ["a.npz cannot be read", "Saved c.csv", "Saved d.csv"]
    labels = [label for label in bar.findChildren(QLabel) if label.isVisible()]
    heights = [label.mapTo(bar, label.rect().topLeft()).y() for label in labels]
    assert len(labels) == 3
    assert heights == sorted(heights, reverse=True), "the newest is at the top"
    assert {note.text for note in window.column["messages"].list.notes} >= {"Saved b.csv", "Saved c.csv"}
    left_click(bar.findChild(QToolButton, "message-dismiss"))
    assert [message.text for message in bar.messages] == ["Saved c.csv", "Saved d.csv"]


def test_offer_remains_while_other_messages_appear_and_disappear(window):
    window.notifier.offer("Restore the edits?", remedies=[], dismiss="Later")
    for name in "abcd":
        window.notifier.say(f"Saved {name}.csv")
    assert window.notification_bar.messages[0].text == "Restore the edits?"
    window.notifier.withdraw()
    assert [message.text for message in window.notification_bar.messages] == ["Saved c.csv", "Saved d.csv"]


def test_failure_disappears_once_the_same_operation_succeeds(window, tmp_path):
    files = window.presenters.map_files
    good = tmp_path / "good.npz"
    files._save(good)
    bad = tmp_path / "bad.npz"
    bad.write_bytes(b"not a map")
    window.notification_bar.clear()
    assert not files.open(str(bad))
    assert "bad.npz" in window.notification_bar.text
    window.presenters.view.find_taxel("3")
    assert "bad.npz" in window.notification_bar.text, "another operation succeeded"
    assert files.open(str(good))
    assert not any(message.fault for message in window.notification_bar.messages)


def test_every_operation_that_can_fail_can_succeed():
    """The message of a failed operation remains until the operation succeeds or another document is opened."""
    failing = set()
    succeeding = set()
    for path in Path(tactile_widgets.__file__).parent.rglob("*.py"):
        if not re.search("fault|succeed|errors_shown|say", text := path.read_text(encoding="utf8")):
            continue
        for call in (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)):
            words = {word.arg: word.value for word in call.keywords}
            named = ast.unparse(call.func).split(".")[-1]
            if named == "partial" and call.args:
                named = ast.unparse(call.args[0]).split(".")[-1]
                operation = words.get("of", call.args[-1])
            else:
                operation = words.get("of", call.args[0] if call.args else None)
            if not isinstance(operation, ast.Constant):
                assert named != "fault" or ast.unparse(call).endswith(("of=of)", "describe_unexpected_error(error))"))
            elif named == "fault" or (named == "say" and "fault" in words):
                failing.add(operation.value)
                succeeding |= {operation.value} if not isinstance(words.get("fault"), ast.Constant | None) else set()
            elif named in ("succeed", "errors_shown", "say"):
                succeeding |= {operation.value} if "finishes" not in words else set()
                failing |= {operation.value} if named == "errors_shown" else set()
    assert len(failing) > 20
    assert failing - succeeding == {"open file"}, "its failures leave when a document is opened"


@pytest.mark.parametrize("width", [1107, 1400])
def test_message_is_at_the_lower_right_without_covering_the_colour_bar(window, width):
    window.resize(width, 768)
    for name in "abcd":
        window.notifier.fault(f"A long message about the file {name} that cannot be read. " * 3)
    QApplication.processEvents()
    bar = window.notification_bar
    views = window.views
    colours = window.colour_bar
    assert bar.geometry().bottom() > views.height() - 20
    assert bar.geometry().right() > views.width() - 20
    assert bar.x() > colours.mapTo(views, colours.rect().topRight()).x()
    bar.clear()


@pytest.mark.parametrize("size", [(900, 600), (1366, 768)])
def test_buttons_of_messages_are_in_view(window, size):
    """Also next to a wide robot view, over a high area of plots, and for several messages."""
    window.resize(*size)
    bar = window.notification_bar
    actions = [QAction("Restore the edits", window), QAction("Discard the edits…", window)]
    window.views._splitter.setSizes([2000, 100])
    for number in range(3):
        window.notifier.say(f"Message {number} with {20 * 'several words '}", remedies=actions, fault=True)
    for height in (1, 400):
        window.resizeDocks([window.bottom], [height], Qt.Orientation.Vertical)
        QApplication.processEvents()
        shown = [button for button in bar.findChildren(QToolButton) if button.isVisible()]
        assert len(shown) >= 3
        assert any(label.isVisible() and "Message 2" in label.text() for label in bar.findChildren(QLabel))
        for button in shown:
            assert button.visibleRegion().boundingRect() == button.rect(), button.text()
        for label in (label for label in bar.findChildren(QLabel) if label.isVisible()):
            assert label.height() >= label.heightForWidth(label.width())
    window.views._splitter.setSizes([100, 100])
    window.resizeDocks([window.bottom], [1], Qt.Orientation.Vertical)


def test_failed_measurement_keeps_the_progress_of_a_scene(window):
    window.live.report_progress("Placing taxels", 0.4)
    window.live.measurements.cost_failed.emit("Measuring ended unexpectedly")
    assert window.notification_bar.text == "Measuring ended unexpectedly"
    assert window.loading_bar.busy
    window.live.loading_ended.emit()
    assert not window.loading_bar.busy


def test_cancel_ends_only_the_shown_job(window, monkeypatch):
    ended = []
    monkeypatch.setattr(window.live.scene_jobs, "cancel", lambda: ended.append("scene"))
    measurements = window.live.measurements
    monkeypatch.setattr(measurements.cost_executor, "hold", True)
    measurements.weighing_changed.connect(lambda weighing: weighing or ended.append("weighing"))
    window.live.report_progress("Placing taxels", 0.4)
    window.live.measurements.weigh(window.live.prepared, window.live.prepared.scene.effects)
    cancel(window)
    assert ended == ["weighing"]
    assert window.loading_bar.busy, "the scene is still being prepared"
    cancel(window)
    assert ended == ["weighing", "scene"]
    assert not window.loading_bar.busy


def test_repeated_error_is_reported_once(window, crash_files):
    def fail(number):
        raise RuntimeError(f"in frame {number}")

    def fail_elsewhere():
        raise RuntimeError("elsewhere")

    for number in range(5):
        try:
            fail(number)
        except RuntimeError as error:
            window.notifier.unexpected(error)
    assert len(crash_files()) == 1
    assert "unexpected problem" in window.notification_bar.text
    assert "5 times" in window.statusBar().currentMessage()
    try:
        fail_elsewhere()
    except RuntimeError as error:
        window.notifier.unexpected(error)
    assert len(crash_files()) == 2


@pytest.mark.long
def test_contact_shapes_are_shown_in_both_views_while_paused(window):
    window.action("mark_shapes").trigger()
    pixel = press_map(window, 70)
    run(window, 0.5)
    window.action("pause").trigger()
    shapes = window.robot_view.display.actors.layers["shapes"]
    assert not any(actor.visibility for actor in shapes.ellipses)
    window.action("mark_shapes").trigger()
    window.robot_view.display.draw_now()
    assert any(actor.visibility for actor in shapes.ellipses)
    assert window.map_view.picture._overlays.shows("shapes")
    window.action("mark_shapes").trigger()
    assert not any(actor.visibility for actor in shapes.ellipses)
    left_release(window.map_view.viewport(), pixel)
