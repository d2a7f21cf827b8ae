"""Context menus in the real window, the same in both views, and held fingers."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QMenu

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.taxel_selection import SelectionUpdate
from tactile_widgets.plots.choice.plot_choice import PlotChoice, PlotKey
from tactile_widgets.tools.map_editing.mesh_picking import present_seams, seam_runs
from tactile_widgets.tools.map_editing.pin_tool import with_pins
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.views.interaction.view_tool import PointedAt
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import press_map, run, visible_skin

RIGHT = Qt.MouseButton.RightButton
LEFT = Qt.MouseButton.LeftButton
SHIFT = Qt.KeyboardModifier.ShiftModifier

OFFERED_ON_SKIN = [
    "poke",
    "target",
    "path",
    "plot-taxel",
    "plot-link",
    "plot-joint",
    "frame",
    "hide",
    "hide-body",
    "remove-skin",
    "copy",
]


@pytest.fixture
def window(window_again):
    """Window without touch, with the standard plots of the controller."""
    yield window_again
    window_again.plots.choose(PlotChoice())


def right_click(window, view, pixel):
    """Return the context menu at a pixel, or None."""
    target = window.robot_view.display.canvas.widget if view == "robot" else window.map_view.viewport()
    window.presenters.pointing.menu = None
    QTest.mouseClick(target, RIGHT, Qt.KeyboardModifier.NoModifier, pixel)
    return window.presenters.pointing.menu


def names(menu):
    return [] if menu is None else [entry.objectName().removeprefix("pointed-") for entry in menu.actions()]


def choose(menu, name):
    entry = menu.findChild(object, f"pointed-{name}")
    menu.close()
    entry.trigger()
    QApplication.processEvents()


def pixels(window):
    """Return a point of the skin and its pixel in both views."""
    at, pixel = visible_skin(window)
    return at, {"robot": pixel, "map": window.map_view.pixel_of(at).toPoint()}


def held(window):
    return {poke.id: poke for poke in window.live.shown.pokes if poke.id > 1}


pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


def test_both_views_offer_the_same_actions(window):
    _, places = pixels(window)
    offered = {view: names(right_click(window, view, pixel)) for view, pixel in places.items()}
    window.findChild(QMenu, "pointed-menu").close()
    assert offered["robot"] == offered["map"] == OFFERED_ON_SKIN
    assert names(right_click(window, "robot", QPoint(4, 4))) == [], "there is nothing in the corner"


@pytest.mark.long
def test_held_finger_is_changed_and_removed(window, tmp_path):
    _at, places = pixels(window)
    window.live.recording.start(tmp_path / "held.mcap")
    window.presenters.touch.fingers.held.setValue(2.0)
    choose(right_click(window, "robot", places["robot"]), "poke")
    run(window, 0.6)
    (number,) = held(window)
    assert held(window)[number].force == pytest.approx(2.0, abs=0.3)
    window.column["controller"].sliders.by_name["stiffness"]._value.setValue(20.0)
    run(window, 0.2)
    assert window.live.runner.session.settings.stiffness == 20.0
    assert number in held(window), "it stays without a pressed button"
    field = window.column["contacts"].fingers.findChild(object, f"held-{number}")
    field.setValue(4.0)
    window.live.runner.run_for(0.01)
    window.live.pump()
    assert held(window)[number].force > 1.5, "it presses on from where it is"
    run(window, 0.6)
    assert held(window)[number].force == pytest.approx(4.0, abs=0.4)
    menu = right_click(window, "map", window.map_view.pixel_of(held(window)[number].at).toPoint())
    assert names(menu)[:2] == ["away", "force"]
    choose(menu, "away")
    run(window, 0.1)
    assert not held(window)
    window.live.recording.stop()
    again = verify(RecordingPlayer(tmp_path / "held.mcap"))
    assert again.identical
    assert again.frames > 200


def test_shift_clicks_hold_fingers_and_shift_drags_do_not(window):
    _at, places = pixels(window)
    canvas = window.robot_view.display.canvas.widget
    viewport = window.map_view.viewport()
    QTest.mouseClick(canvas, LEFT, SHIFT, places["robot"])
    other = window.live.prepared.skin.taxel_point(140)
    QTest.mouseClick(viewport, LEFT, SHIFT, window.map_view.pixel_of(other).toPoint())
    run(window, 0.2)
    assert len(held(window)) == 2
    QTest.mousePress(viewport, LEFT, SHIFT, places["map"])
    QTest.mouseMove(viewport, places["map"] + QPoint(30, 10))
    QTest.mouseRelease(viewport, LEFT, SHIFT, places["map"] + QPoint(30, 10))
    run(window, 0.1)
    assert len(held(window)) == 2
    for number in tuple(held(window)):
        left_click(window.column["contacts"].fingers.findChild(object, f"held-{number}-away"))
    run(window, 0.1)
    assert not held(window)


def test_menu_sets_target_draws_path_plots_frames_and_copies(window):
    at, places = pixels(window)
    session = window.live.runner.session
    choose(right_click(window, "robot", places["robot"]), "target")
    run(window, 0.05)
    assert session.settings.task == "hold_point"
    np.testing.assert_allclose(session.settings.path[0], session.map.to_map(at), atol=0.004)
    choose(right_click(window, "robot", places["robot"]), "path")
    assert window.presenters.control_tools._tools.active.name == "draw_path"
    viewport = window.map_view.viewport()
    left_click(viewport, places["map"] + QPoint(20, 0))
    QTest.keyClick(window.map_view, Qt.Key.Key_Return)
    run(window, 0.05)
    assert session.settings.task == "follow_path"
    assert len(session.settings.path) == 2
    choose(right_click(window, "map", places["map"]), "plot-taxel")
    assert len(window.views.selection.taxels) == 1
    assert window.plots.shown[-1] == f"taxel:{window.views.selection.taxels[0]}"
    camera = window.map_view.camera
    choose(right_click(window, "map", places["map"]), "frame")
    assert window.map_view.camera != camera
    menu = right_click(window, "map", window.map_view.pixel_of(at).toPoint())
    choose(menu, "copy")
    assert "taxel" in QApplication.clipboard().text().lower()
    window.views.frame_all()
    window.presenters.control_tools.settings_editor.clear_path()
    window.views.selection.clear()
    window.action("controller_impedance").trigger()


def test_bare_link_is_framed_plotted_and_copied(window):
    view = window.robot_view
    for x in range(20, view.width(), 25):
        for y in range(20, view.height() - 60, 25):
            hit = view.pointed_at(QPoint(x, y).toPointF())
            if hit.at is None and hit.body is not None and not view.over_control(QPoint(x, y).toPointF()):
                before = view.display.actors.viewpoint.distance
                menu = right_click(window, "robot", QPoint(x, y))
                assert names(menu) == ["plot-joint", "frame", "hide-body", "cover", "copy"]
                choose(menu, "plot-joint")
                assert window.plots.shown[-1].startswith("joint:")
                choose(right_click(window, "robot", QPoint(x, y)), "copy")
                assert " rad/s" in QApplication.clipboard().text()
                choose(right_click(window, "robot", QPoint(x, y)), "frame")
                assert view.display.actors.viewpoint.distance < before
                window.views.frame_all()
                return
    raise AssertionError("no bare link in sight")


def test_hidden_patch_can_be_undone(window):
    at, places = pixels(window)
    choose(right_click(window, "map", places["map"]), "hide")
    assert not window.editor.document.patches[at.patch].visible
    window.editor.undo()
    assert window.editor.document.patches[at.patch].visible


def test_hidden_link_cannot_be_pressed_until_shown(window):
    view = window.robot_view
    at, places = pixels(window)
    link = window.live.prepared.robot.link_index[window.live.prepared.skin.patches[at.patch].link]
    menu = right_click(window, "robot", places["robot"])
    assert "show-bodies" not in names(menu)
    assert not window.action("show_bodies").isEnabled()
    choose(menu, "hide-body")
    assert view.display.actors.hidden == {link}
    met = view.pointed_at(places["robot"].toPointF())
    assert met.at is None or met.at.patch != at.patch, "what is behind it is pointed at"
    assert met.body != link
    first, last = window.live.prepared.skin.first[at.patch : at.patch + 2]
    assert np.isnan(view.taxel_pixels()[first:last]).all(), "no frame selects what is not seen"
    assert window.editor.document.patches[at.patch].visible, "the map keeps it"
    assert "show-bodies" in names(right_click(window, "map", places["map"]))
    window.presenters.pointing.menu.close()
    window.action("show_bodies").trigger()
    assert not view.display.actors.hidden
    assert view.point_at(places["robot"].toPointF()).patch == at.patch


def test_pin_is_found_only_while_its_map_is_shown(window):
    """A replayed recording may have another skin, to which the pins do not belong."""
    at, _ = pixels(window)
    editor = window.context.editor
    resolve = window.presenters.pointing.resolve
    assert editor.do("Pin", lambda document: with_pins(document, [at]))
    assert resolve(PointedAt(at)).pin == at
    editor.set_enabled(enabled=False)
    assert resolve(PointedAt(at)).pin is None
    editor.set_enabled(enabled=True)
    editor.undo()


def test_seam_is_framed_copied_and_erased_at_the_pointer(window, small_arm):
    window.live.show_prepared(small_arm)
    document = window.editor.document
    pointing = window.presenters.pointing
    runs = [(patch, run) for patch in range(3) for run in seam_runs(present_seams(document, patch))]
    patch, run = max(runs, key=lambda pair: len(pair[1]))
    faces = document.skin.patches[patch].surface.faces
    face = int(np.flatnonzero((faces == run[len(run) // 2]).any(axis=1))[0])
    weights = tuple(float(vertex == run[len(run) // 2]) for vertex in faces[face])
    seam = pointing.resolve(PointedAt(SurfacePoint(patch, face, weights)))
    offered = {action.name: action for action in pointing.actions(seam)}
    assert offered["erase-seam"].text == "Erase this seam"
    assert offered["frame-seam"].text == "Frame this seam"
    away = pointing.resolve(PointedAt(visible_skin(window)[0]))
    assert not {"erase-seam", "frame-seam"} & {action.name for action in pointing.actions(away)}
    window.views.frame_all()
    offered["frame-seam"].run()
    assert window.map_view.viewport().rect().contains(window.map_view.pixel_of(seam.at).toPoint())
    scene = window.robot_view.display.actors
    size = window.robot_view.display.size
    pose = scene.poses[window.live.prepared.robot.link_index[document.skin.patches[patch].link]]
    ends = document.skin.patches[patch].surface.vertices[run] @ pose[:3, :3].T + pose[:3, 3]
    x, y = scene.viewpoint.pixels(ends, size).T
    assert ((x > 0) & (x < size[0]) & (y > 0) & (y < size[1])).all()
    assert max(np.ptp(x) / size[0], np.ptp(y) / size[1]) > 0.3, "and it is near"
    window.views.frame_all()
    offered["copy"].run()
    along = document.skin.patches[patch].surface.vertices[run]
    length = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(along))
    assert f"\nSeam: {length:.4g} m long" in QApplication.clipboard().text()
    window.editor.set_enabled(enabled=False)  # as during a replay of another robot
    assert window.presenters.tools.get(SeamTool).seam_length(replace(seam.at, face=10**6)) is None
    window.editor.set_enabled(enabled=True)
    before = present_seams(document, patch)
    offered["erase-seam"].run()
    assert not np.array_equal(present_seams(window.editor.document, patch), before)
    window.editor.undo()


def test_selected_taxels_are_plotted_as_a_named_group(window):
    _, places = pixels(window)
    skin = window.live.prepared.skin
    selection = window.views.selection
    taxels = np.arange(60, 80)
    selection.take(SelectionUpdate(taxels, SelectionMode.REPLACE))
    choose(right_click(window, "map", places["map"]), "plot-group")
    asked = window.findChild(QInputDialog, "group-name")
    asked.setTextValue("palm: left")
    asked.accept()
    selection.clear()
    assert "plot-group" not in names(right_click(window, "map", places["map"]))
    window.presenters.pointing.menu.close()
    assert window.plots.shown[-2:] == ("group-force:palm: left=60-79", "group-pressure:palm: left=60-79")
    pixel = press_map(window, 70)
    run(window, 0.3)
    pressed = window.live.shown.pressures[taxels]
    left_release(window.map_view.viewport(), pixel)
    assert pressed.max() > 0
    force, mean, highest = (
        series.values[-1]
        for key in window.plots.shown_keys[-2:]
        for series in window.plots._parts[PlotKey.parse(key.text)].series()
    )
    assert force == pytest.approx(pressed @ skin.areas[taxels], rel=1e-5)
    assert (mean, highest) == pytest.approx((1e-3 * pressed.mean(), 1e-3 * pressed.max()), rel=1e-5)
    again = PlotChoice.from_text(window.plots.choice.to_text())
    assert again.order == window.plots.choice.order, "kept with the layout"
