"""*File > Connect…*: the dialog connects a source or shows the error."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QWidget

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.editing.arrange import move, rotate
from tactile_widgets.dialogs.connect_dialog import KINDS
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.tools.registry import PATH
from tests.widgets.support.mouse import left_release
from tests.widgets.support.window_driver import answer, choose_effect, press_map, replay_run, run


@pytest.fixture(scope="module")
def known_dialog(visible_window):
    """The shared window has made its dialog, which it keeps."""
    (window,), _ = visible_window
    window.action("connect").trigger()
    window.presenters.live_input.dialog.reject()


@pytest.mark.long
def test_dialog_connects_a_source(window, tmp_path):
    window.action("connect").trigger()
    dialog = window.presenters.live_input.dialog
    assert dialog.isVisible()
    assert dialog.address.text() == KINDS["UDP"]
    dialog.address.setText("udp://127.0.0.1:0")
    dialog.tare.setValue(20)
    dialog.go.click()
    assert not dialog.isVisible()
    assert window.live.live_input.session.facts.taring
    window.action("disconnect").trigger()
    assert window.live.live_input is None


@pytest.mark.usefixtures("known_dialog")
def test_token_is_made_and_copied(window_again):
    window_again.action("connect").trigger()
    dialog = window_again.presenters.live_input.dialog
    dialog.make_token.click()
    token = dialog.token.text()
    assert len(token) >= 16
    assert QApplication.clipboard().text() == token
    assert dialog.settings.options.token == token
    dialog.make_token.click()
    assert dialog.token.text() != token
    dialog.token.clear()
    dialog.reject()


@pytest.mark.usefixtures("known_dialog")
@pytest.mark.parametrize(("entered", "shown", "tare"), [(1, "None", None), (5, "5 readings", 5)])
def test_tare_at_the_start_has_at_least_five_readings(window_again, entered, shown, tare):
    window_again.action("connect").trigger()
    dialog = window_again.presenters.live_input.dialog
    dialog.tare.setValue(entered)
    assert (dialog.tare.text(), dialog.settings.tare) == (shown, tare)
    dialog.tare.setValue(dialog.tare.minimum())
    dialog.reject()


@pytest.mark.usefixtures("known_dialog")
def test_invalid_source_is_reported_in_the_dialog(window_again, tmp_path):
    window_again.action("connect").trigger()
    dialog = window_again.presenters.live_input.dialog
    for kind, address, said in (
        ("File", str(tmp_path / "none.csv"), "none.csv"),
        ("File", " ", "No source is named"),
        ("UDP", "udp://0.0.0.0:9870", "This address is open to other machines (found: 0.0.0.0). Listen on 127.0.0.1"),
        ("UDP", "udp://no-such-host.invalid:9870", "Unknown host (found: no-such-host.invalid). Check its spelling"),
        ("ROS 2", "ros2:", "need a mapping"),
    ):
        dialog.kind.setCurrentText(kind)
        dialog.address.setText(address)
        dialog.go.click()
        assert dialog.isVisible()
        assert said in dialog.problem.text()
        buttons = dialog.findChild(QDialogButtonBox)
        assert dialog.problem.height() >= dialog.problem.heightForWidth(dialog.problem.width())
        assert dialog.height() - buttons.geometry().bottom() < 20, "no empty space below the buttons"
    assert window_again.live.live_input is None
    (tmp_path / "gains.toml").write_text("gain = 2.0\n")
    dialog.kind.setCurrentText("UDP")
    assert dialog.address.text() == "udp://no-such-host.invalid:9870", "kept as typed"
    dialog.address.setText("udp://127.0.0.1:9999")
    dialog.inverted.setChecked(True)
    dialog.calibration.setText(str(tmp_path / "gains.toml"))
    dialog.go.click()
    assert "Negate the gains in the file instead" in dialog.problem.text()
    assert dialog.settings.inverted
    dialog.inverted.setChecked(False)
    dialog.calibration.clear()
    assert window_again.settings.source == ("UDP", "udp://127.0.0.1:9999")
    dialog.kind.setCurrentText("Serial port")
    assert dialog.problem.isHidden()
    assert dialog.height() - buttons.geometry().bottom() < 20
    assert not dialog.findChild(QWidget, "connect-mapping").isEnabled(), "only for ROS messages"
    dialog.reject()


def draw_path(window, taxels):
    """Click the corners of a path on the map, and end it."""
    window.action("draw_path").trigger()
    assert window.presenters.tools.active == PATH
    for taxel in taxels:
        left_release(window.map_view.viewport(), press_map(window, taxel))
    QTest.keyClick(window.map_view, Qt.Key.Key_Return)
    run(window, 0.01)


def connect(window, folder):
    """Connect to a file of readings with the dialog."""
    (folder / "readings.csv").write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
    window.action("connect").trigger()
    dialog = window.presenters.live_input.dialog
    dialog.kind.setCurrentText("File")
    dialog.address.setText(str(folder / "readings.csv"))
    dialog.go.click()
    assert window.live.live_input is not None
    assert "Try:" not in window.statusBar().currentMessage(), "a real skin has no suggestion of a scene"
    run(window, 0.05)


@pytest.fixture
def prepared_by_user(known_dialog, window_again):
    """The shared window with a path, another controller, goals, an effect, contact detection and an edited map."""
    window = window_again
    draw_path(window, (5, 12, 20))
    window.column["controller"].choose_controller("hybrid")
    window.action("more_force").trigger()
    window.presenters.effects.choose("gravity", "on")
    window.live.set_reading(ReadingSettings(threshold=2500.0))
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    run(window, 0.05)
    settings = window.live.run.settings
    assert len(settings.settings.path) >= 2
    assert settings.settings.controller == "hybrid"
    return window


def test_disconnect_keeps_the_settings_and_the_edited_map(prepared_by_user, tmp_path):
    window = prepared_by_user
    before = window.live.run.settings
    chosen = window.presenters.effects.scene
    assert chosen.overrides != window.live.prepared.scene.overrides
    connect(window, tmp_path)
    assert window.live.run.settings.settings == before.settings, "shown while connected"
    connect(window, tmp_path)  # a second source: the settings of the simulation are still known
    window.editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    run(window, 0.05)
    names = window.editor.history.names
    document = window.editor.document
    window.action("disconnect").trigger()
    run(window, 0.05)
    session = window.live.runner.session
    assert session.settings == before.settings
    assert session.effects == before.effects
    assert session.runtime_settings.reading == before.reading
    assert session.map is document.map
    assert window.presenters.effects.scene == chosen
    assert window.editor.history.names == names
    assert window.editor.document is document
    assert window.presenters.map_files.unsaved
    window.live.reset()
    run(window, 0.05)
    assert window.live.runner.session.map is document.map


@pytest.mark.parametrize("changed", [False, True])
def test_connect_from_a_recording_does_not_change_the_scene(window, tmp_path, changed):
    """Only an effect that was chosen while the session was recorded is unsaved, as after *Take over from here*."""
    if changed:
        window.live.recording.start(tmp_path / "a.mcap")
        choose_effect(window, "gravity", "on")
        run(window, 0.1)
        window.live.recording.stop()
        choose_effect(window, "gravity", "auto")
        run(window, 0.05)
        window.live.open_recording(tmp_path / "a.mcap")
        window.live.replay.seek(0.1)
    else:
        replay_run(window, tmp_path / "a.mcap", 0.1)
    unsaved = ("effects",) if changed else ()
    connect(window, tmp_path)
    assert window.presenters.scene_file.unsaved == unsaved
    assert window.isWindowModified() is changed
    window.action("disconnect").trigger()
    run(window, 0.05)
    assert window.presenters.scene_file.unsaved == unsaved


class Viewer:
    """A viewer that keeps the maps it is offered."""

    address = "ws://127.0.0.1:1"
    gone = False

    def __init__(self):
        self.maps = []

    def offer(self, _frame, map_):
        self.maps.append(map_)

    def close(self):
        self.maps.clear()


def test_share_live_shows_the_edited_map(window_again):
    window_again.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    viewer = window_again.live.sharing._server = Viewer()
    run(window_again, 0.05)
    assert viewer.maps[-1] is window_again.editor.document.map
    assert viewer.maps[-1] is not window_again.live.prepared.map
    window_again.live.sharing.stop()


@pytest.mark.long
def test_connect_from_a_recording_asks_about_unsaved_edits_and_takes_its_map(window, tmp_path):
    """The recorded map becomes the document, as *Take over from here* does."""
    window.live.recording.start(tmp_path / "a.mcap")
    run(window, 0.1)
    window.editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    run(window, 0.2)
    recorded = window.editor.document.map.layout
    window.live.recording.stop()
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    own = window.editor.document
    window.live.open_recording(tmp_path / "a.mcap")
    window.live.replay.seek(0.25)
    window.action("connect").trigger()
    assert window.presenters.live_input.dialog is None or not window.presenters.live_input.dialog.isVisible()
    answer(window, Button.Cancel)
    assert window.live.replay.player is not None
    assert window.editor.document is own
    window.action("connect").trigger()
    answer(window, Button.Discard)
    window.presenters.live_input.dialog.reject()
    connect(window, tmp_path)
    assert window.editor.document.map.layout == recorded
    assert window.live.run.map is window.editor.document.map
    window.action("disconnect").trigger()
    assert window.editor.document.map.layout == recorded
