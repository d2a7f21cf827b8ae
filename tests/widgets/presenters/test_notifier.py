"""Messages in the real window: plain text, one progress per job, one report per error."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QToolButton

from tests.widgets.support.window_driver import press_map, run

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(window_again):
    """Window without messages."""
    return window_again


@pytest.fixture
def crash_files(tmp_path, monkeypatch):
    """Files with the details of unexpected errors."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return lambda: list((tmp_path / "state").rglob("*crash*"))


def cancel(window):
    QTest.mouseClick(window.loading_bar.findChild(QToolButton, "loading-cancel"), LEFT)


def test_message_is_shown_as_plain_text(window):
    text = "arm.urdf: its root must be <robot>, not <b>model</b>"
    window.live.failed.emit(text)
    assert window.notification_bar.text == text
    assert window.notification_bar.findChild(QLabel, "message-text").textFormat() == Qt.TextFormat.PlainText


def test_information_leaves_by_itself_and_a_failure_with_the_next_document(window, monkeypatch, prepared):
    bar = window.notification_bar
    monkeypatch.setattr(bar, "underMouse", lambda: False)
    window.notifier.say("Saved a.mcap")
    assert bar._read.interval() == 6000
    assert bar._read.isActive()
    bar._read.timeout.emit()
    assert bar.text == ""
    window.notifier.fault("a.toml cannot be read")
    assert not bar._read.isActive()
    assert bar.text
    window.live.show_prepared(prepared)
    assert bar.text == ""
    assert [note.text for note in window.column["messages"].list.notes][1:3] == [
        "a.toml cannot be read",
        "Saved a.mcap",
    ]


@pytest.mark.parametrize("width", [1107, 1400])
def test_message_is_at_the_lower_right_and_clear_of_the_colour_bar(window, width):
    window.resize(width, 768)
    window.notifier.fault("A long message about a file that cannot be read. " * 4)
    QApplication.processEvents()
    bar = window.notification_bar
    views = window.views
    colours = window.colour_bar
    assert bar.geometry().bottom() > views.height() - 20
    assert bar.geometry().right() > views.width() - 20
    assert bar.x() > colours.mapTo(views, colours.rect().topRight()).x()
    bar.hide()


def test_failed_measurement_keeps_the_progress_of_a_scene(window):
    window.live.loading.emit("Placing taxels", 0.4)
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
    window.live.loading.emit("Placing taxels", 0.4)
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
    QTest.mouseRelease(window.map_view.viewport(), LEFT, pos=pixel)
