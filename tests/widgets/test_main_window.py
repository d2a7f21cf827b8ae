"""The whole window, real at every joint: real widgets, real events, the real simulation, time passed by hand."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.recording.player import Player
from app.recording.verify import verify
from tests.widgets.pictures import check_picture
from widgets.colours import DARK, LIGHT, apply_theme
from widgets.main_window import MainWindow
from widgets.runner import InlineRunner
from widgets.settings import Settings


@pytest.fixture
def window(qtbot, prepared, tmp_path, monkeypatch):
    """The window on the small arm, without the scripted hand's touch in the way."""
    monkeypatch.setattr("widgets.commands.recordings_folder", lambda: tmp_path / "recordings")
    apply_theme(QApplication.instance(), DARK)
    made = MainWindow(Settings(tmp_path / "window.ini"), make_runner=InlineRunner)
    made.resize(1400, 900)
    made.show()
    qtbot.waitExposed(made)
    made.live.show_prepared(prepared)
    QApplication.processEvents()
    yield made
    made.close()
    made.deleteLater()


def run(window, seconds):
    """Let simulated time pass, and the window show it."""
    for _ in range(max(round(seconds / 0.2), 1)):
        window.live.runner.run_for(min(seconds, 0.2))
        window.live.pump()
        QApplication.processEvents()


def visible_skin(window):
    """A place on the skin that the robot view shows unhidden, and its pixel there."""
    view, skin = window.robot_view, window.live.prepared.skin
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        pixel = view.pixel_of(at)
        near = [view._at(pixel + QPointF(x, y)) for x in (-4, 4) for y in (-4, 4)]
        # One that faces the eye, so that a pixel aside is little aside on the skin.
        if all(hit is not None and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
            return at, pixel.toPoint()
    raise AssertionError("no taxel can be seen")


def press_map(window, taxel):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(taxel)).toPoint()
    QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    return pixel


def test_it_opens_alive(window):
    run(window, 1.5)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.scripted
    assert frame.regions, "the scripted stroke must keep the map alive"
    assert "1 contact" in window.column.contacts.findChild(object, "contacts-summary").text()
    assert "× real time" in window.session_bar.factor.text()


def test_a_press_on_the_body_and_on_the_map_are_the_same_act(window):
    _, pixel = visible_skin(window)
    felt = []
    window.live.touched.connect(lambda: felt.append(True))
    QTest.mousePress(window.robot_view.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.3)
    from_body = window.live.runner.session.frame.pokes[-1].at
    QTest.mouseRelease(window.robot_view.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.pokes
    map_pixel = window.map_view.pixel_of(from_body).toPoint()
    QTest.mousePress(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=map_pixel)
    run(window, 0.3)
    from_map = window.live.runner.session.frame.pokes[-1].at
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=map_pixel)
    skin = window.live.prepared.skin
    assert felt
    assert from_map.patch == from_body.patch
    # One pixel of the map is a good millimetre.
    assert np.linalg.norm(skin.position(from_map) - skin.position(from_body)) < 3e-3


def test_force_grows_while_held_and_ends_with_the_release(window):
    pixel = press_map(window, 70)
    forces = []
    for _ in range(6):
        run(window, 0.1)
        forces.append(window.live.runner.session.frame.pokes[-1].force)
    assert forces[0] > 0
    assert forces == sorted(forces)
    assert forces[-1] > 2 * forces[0]
    (region,) = window.live.runner.session.frame.regions
    assert region.force == pytest.approx(forces[-1], rel=1e-6)
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.regions


def test_a_drag_strokes(window):
    skin = window.live.prepared.skin
    first, last = skin.neighbours[len(skin.neighbours) // 2]
    press_map(window, int(first))
    run(window, 0.4)
    before = window.live.runner.session.frame
    pixel = window.map_view.pixel_of(skin.taxel_point(int(last))).toPoint()
    QTest.mouseMove(window.map_view.viewport(), pixel)
    run(window, 0.05)
    after = window.live.runner.session.frame
    assert after.pokes[-1].at != before.pokes[-1].at
    assert after.pokes[-1].force > 0.5 * before.pokes[-1].force, "a stroke keeps its depth"
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)


def test_hints_go_with_the_first_touch_and_stay_away(window):
    assert not window.hint_bar.isHidden()
    press_map(window, 70)
    assert window.hint_bar.isHidden()
    assert window.settings.hints_read


def test_holding_force_is_a_click_away_and_works(window):
    QTest.mouseClick(window.column.controller._buttons["hold_force"], Qt.MouseButton.LeftButton)
    press_map(window, 70)
    run(window, 3.0)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.settings.law == "hold_force"
    assert frame.regions[0].force == pytest.approx(window.live.runner.session.settings.force_goal, rel=0.05)
    assert np.abs(frame.posture - window.live.prepared.robot.home).max() > 0.01, "the arm must have moved"


def test_gains_are_live(window):
    slider = window.column.controller._sliders["stiffness"]._slider
    before = window.live.runner.session.settings.stiffness
    QTest.keyClick(slider, Qt.Key.Key_Right)
    run(window, 0.05)
    assert window.live.runner.session.settings.stiffness > before


def test_record_stop_replay_scrub_and_back(window, qtbot, tmp_path):
    window.action("record").trigger()
    assert window.live.recorder is not None
    press_map(window, 70)
    run(window, 0.6)
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton)
    run(window, 0.2)
    window.action("record").trigger()
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert str(file) in window.message_bar.text
    player = Player(file)
    assert len(player) == round(0.8 / window.live.prepared.scene.tick)
    assert verify(player).identical
    window.commands.open_path(str(file))
    assert window.live.mode == "replaying"
    window.timeline.scrubbed.emit(0.5)
    assert window.live._shown.regions, "half a second in, the finger was down"
    window.action("pause").trigger()
    assert window.timeline.playhead.playing
    window.action("pause").trigger()
    quality = window.column.quality.findChild(object, "quality-bijective")
    qtbot.waitUntil(lambda: quality.text() == "yes", timeout=30_000)
    window.timeline.live_requested.emit()
    assert window.live.mode == "live"
    assert window.live._shown.tick == window.live.runner.session.frame.tick


def test_closing_while_recording_completes_the_file(window, tmp_path):
    window.action("record").trigger()
    run(window, 0.3)
    window.close()
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert Player(file).complete


@pytest.mark.parametrize("name", ["nothing.urdf", "picture.docx", "broken.mcap"])
def test_a_bad_file_gives_one_message_and_keeps_the_scene(window, qtbot, tmp_path, name):
    path = tmp_path / name
    if name != "nothing.urdf":
        path.write_bytes(b"not what it says")
    before = window.live.prepared
    window.commands.open_path(str(path))
    qtbot.waitUntil(lambda: bool(window.message_bar.text), timeout=20_000)
    assert str(path) in window.message_bar.text
    assert "Traceback" not in window.message_bar.text
    assert window.live.prepared is before
    assert window.live.mode == "live"
    run(window, 0.1)


def test_a_file_can_be_dropped(window, tmp_path):
    path = tmp_path / "picture.docx"
    path.write_bytes(b"?")
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    event = QDropEvent(
        QPointF(400, 400), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    )
    window.dropEvent(event)
    assert "cannot be opened" in window.message_bar.text


def test_another_robot_is_prepared_beside_the_running_one(window, qtbot, tmp_path):
    path = tmp_path / "ball.obj"
    steps = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = [(0.1 * np.cos(a), 0.1 * np.sin(a), z) for z in (0.0, 0.2) for a in steps]
    faces = [
        f"f {i + 1} {(i + 1) % 24 + 1} {i + 25}\nf {(i + 1) % 24 + 1} {(i + 1) % 24 + 25} {i + 25}" for i in range(24)
    ]
    path.write_text("\n".join(["v {:.5f} {:.5f} {:.5f}".format(*v) for v in ring] + faces))
    with qtbot.waitSignal(window.live.prepared_changed, timeout=60_000):
        window.commands.open_path(str(path))
    assert window.live.prepared.robot.joints == ()
    assert window.live.mode == "live"
    run(window, 0.2)
    assert window.settings.recent[0] == str(path)


def test_loading_can_be_cancelled_and_the_old_scene_stays(window, qtbot):
    before = window.live.prepared
    with qtbot.waitSignal(window.live.loading_ended, timeout=10_000):
        window.commands.open_robot("arm")
        window.live.cancel_loading()
    assert window.live.prepared is before
    run(window, 0.1)


def test_closing_during_loading_leaves_no_process(window):
    window.commands.open_robot("arm")
    process = window.live.worker._process
    window.close()
    assert window.live.worker._process is None
    with pytest.raises(ValueError, match="closed"):
        process.is_alive()


def test_reset_starts_again_and_ends_the_recording(window, tmp_path):
    run(window, 0.3)
    window.action("record").trigger()
    run(window, 0.2)
    window.action("reset").trigger()
    assert window.live.recorder is None
    assert window.live.runner.session.frame.tick == 0
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    assert verify(Player(file)).identical


def test_pause_and_step(window):
    window.action("pause").trigger()
    assert window.live.mode == "paused"
    tick = window.live.runner.session.frame.tick
    run(window, 0.2)
    assert window.live.runner.session.frame.tick == tick
    window.action("step").trigger()
    assert window.live.runner.session.frame.tick == tick + 1
    window.action("pause").trigger()
    run(window, 0.05)
    assert window.live.runner.session.frame.tick > tick + 1


def test_hover_is_shared(window):
    at, pixel = visible_skin(window)
    seen = []
    window.robot_view.hovered.connect(seen.append)
    QTest.mouseMove(window.robot_view.canvas.widget, pixel + QPoint(1, 0))
    QTest.mouseMove(window.robot_view.canvas.widget, pixel)
    assert seen
    assert seen[-1].patch == at.patch


def test_both_themes(window):
    window.action("theme").trigger()
    assert window.theme == LIGHT
    run(window, 0.05)
    light = window.grab().toImage().pixelColor(window.width() // 2, 12).lightness()
    window.action("theme").trigger()
    run(window, 0.05)
    assert window.theme == DARK
    assert light > 200 > window.grab().toImage().pixelColor(window.width() // 2, 12).lightness()


def test_the_pressure_scale_is_shared(window):
    window.colour_bar.maximum_changed.emit(20.0)
    assert window.scale.maximum == 20.0
    assert window.map_view._scale.maximum == 20.0


def test_quality_is_shown(window):
    window.show_quality()
    assert window.column.quality.findChild(object, "quality-flips").text() == "0"
    assert window.column.quality.findChild(object, "quality-bijective").text() == "yes"


def test_the_picture_of_the_whole_window(window):
    """Menus, bars, both views, panels and plots; the changing digits of the clock are left out."""
    window.hint_bar.show()
    run(window, 1.0)
    window.robot_view.draw_now()
    QApplication.processEvents()
    window.session_bar.show_factor(1.0)
    window.column.timing.hide()
    window.plots.hide()
    QApplication.processEvents()
    window.robot_view.draw_now()
    check_picture(window, "window_dark", share=0.97)
