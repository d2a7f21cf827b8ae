"""Grid tool: two clicks, keys that change rows and columns, a preview in both views, and undo steps."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.skin.fitting.grid import is_grid_patch
from tactile_widgets.document.skin_steps import SkinSteps
from tactile_widgets.tools.map_editing.grid_tool import GridTool
from tactile_widgets.tools.registry import GRID
from tactile_widgets.views.interaction.view_tool import PointerHit
from tactile_widgets.views.overlays.body_overlays import MarkRole
from tests.widgets.support.window_driver import run


def press(tool, at):
    left = Qt.MouseButton.LeftButton
    here = QPointF(0, 0)
    event = QMouseEvent(QEvent.Type.MouseButtonPress, here, here, left, left, Qt.KeyboardModifier.NoModifier)
    return tool.press(PointerHit(at, None, 1e-3), event)


def key(tool, *keys):
    for one in keys:
        assert tool.key(QKeyEvent(QEvent.Type.KeyPress, one, Qt.KeyboardModifier.NoModifier)), one


def corners(skin, name="patch 0"):
    """Two places of the patch, 25 to 60 mm apart, on one side of it."""
    number = [patch.name for patch in skin.patches].index(name)
    surface = skin.patches[number].surface
    middles = surface.vertices[surface.faces].mean(axis=1)
    start = int(np.linalg.norm(middles - middles.mean(axis=0), axis=1).argmin())
    away = np.linalg.norm(middles - middles[start], axis=1)
    facing = surface.face_normals @ surface.face_normals[start]
    end = int(np.argmax(np.where((away < 0.06) & (facing > 0.5), away, 0)))
    assert away[end] > 0.02
    return [SurfacePoint(number, face, (1 / 3, 1 / 3, 1 / 3)) for face in (start, end)]


@pytest.fixture
def tool(editor):
    return GridTool(editor)


def test_two_clicks_are_opposite_corners_of_a_preview(tool, editor):
    skin = editor.document.skin
    first, last = corners(skin)
    assert not press(tool, None)
    assert press(tool, first)
    assert (tool.spec, tool.words) == (None, "Click the opposite corner")
    assert [tool.overrides_shortcut(key) for key in (Qt.Key.Key_Backspace, Qt.Key.Key_Up)] == [True, False]
    assert press(tool, last)
    assert tool.overrides_shortcut(Qt.Key.Key_Up)
    spec = tool.spec
    assert (spec.link, spec.rows, spec.columns) == ("link 0", 8, 8)
    np.testing.assert_allclose([spec.first, spec.last], [skin.position(first), skin.position(last)])
    assert tool.words.startswith("8 rows × 8 columns, ")
    marks = tool.body_marks()
    offered = np.array([skin.position(spot.at) for spot in marks.spots if spot.role is MarkRole.OFFERED])
    assert 0 < len(offered) <= 64
    near = np.linalg.norm(offered[:, None] - [spec.first, spec.last], axis=2).min(axis=0)
    assert near.max() < 1e-4
    assert tool.body_marks() is marks


@pytest.mark.long
def test_keys_change_the_grid(tool, editor):
    for at in corners(editor.document.skin):
        assert not tool.overrides_shortcut(Qt.Key.Key_Up)
        press(tool, at)
    assert tool.overrides_shortcut(Qt.Key.Key_Up)
    key(tool, Qt.Key.Key_Up, Qt.Key.Key_Left, Qt.Key.Key_Left, Qt.Key.Key_M)
    assert (tool.spec.rows, tool.spec.columns, tool.spec.mirrored) == (9, 6, True)
    key(tool, *[Qt.Key.Key_Down] * 12, *[Qt.Key.Key_Left] * 9)
    assert (tool.spec.rows, tool.spec.columns) == (1, 2)
    key(tool, Qt.Key.Key_Backspace)
    assert tool.spec is None
    assert tool.cancel()
    assert not tool.cancel()
    assert tool.words == ""


def test_corners_on_two_patches_are_rejected(tool, editor):
    failures = []
    editor.failed.connect(failures.append)
    skin = editor.document.skin
    press(tool, corners(skin)[0])
    press(tool, skin.taxel_point(len(skin) - 1))
    assert "one patch" in failures[0]
    assert tool.spec is None


def test_undo_steps_are_scenes():
    steps = SkinSteps()
    shown = []
    steps.scene_requested.connect(shown.append)
    one, two, three = (scene_for(f"{name}.urdf") for name in ("a", "b", "c"))
    cancelled = []
    steps.cancel_requested.connect(cancelled.append)

    def opened():
        assert steps.expects(shown[-1])
        steps.show_requested()

    steps.push("Taxel grid", one, two)
    assert (steps.pending, steps.can_redo, steps.undo_step.name) == (True, False, "Taxel grid")
    assert (steps.names_before, steps.names_after) == ((), ("Taxel grid",))
    opened()
    steps.push("Skin", two, three)
    steps.undo()
    assert (cancelled[-1], steps.pending, steps.redo_step.name) == ("Skin", False, "Skin")
    steps.redo()
    steps.go(1)
    assert shown == [two, three, three], "the step that is being made is not requested again"
    opened()
    assert (steps.can_undo, steps.can_redo, steps.undo_step.name) == (True, False, "Skin")
    for change in (steps.undo, steps.undo, steps.redo):
        change()
        opened()
    assert shown[3:] == [two, one, two]
    assert (steps.names_before, steps.names_after) == (("Open",), ("Skin",))
    steps.go(1)
    opened()
    steps.go(-2)
    opened()
    assert shown[6:] == [three, one]
    assert (steps.names_before, steps.names_after) == ((), ("Taxel grid", "Skin"))
    steps.redo()
    steps.stop()  # the one requested last did not open
    assert (steps.can_undo, steps.redo_step.name) == (False, "Taxel grid")
    steps.reset()
    assert (steps.can_undo, steps.can_redo) == (False, False)


@pytest.mark.long
def test_grid_is_placed_and_undone_in_the_window(window):
    before = window.live.prepared
    window.action("grid").trigger()
    assert window.presenters.tools.active == GRID
    tool = window.presenters.tools.get(GridTool)
    for at in corners(before.skin, "hand"):
        press(tool, at)
    key(tool, *[Qt.Key.Key_Down] * 4, *[Qt.Key.Key_Left] * 3)
    window.robot_view.grab()
    window.map_view.grab()
    key(tool, Qt.Key.Key_Return)
    skin = window.live.prepared.skin
    (patch,) = [patch for patch in skin.patches if is_grid_patch(patch)]
    assert (patch.link, len(patch.taxels)) == ("hand", 20)
    assert {patch.link for patch in skin.patches} == {patch.link for patch in before.skin.patches}
    assert window.live.prepared.scene.grids[0].rows == 4
    assert "replaces the cover of hand" in window.notification_bar.text
    run(window, 0.1)
    assert window.action("undo").isEnabled()
    window.action("undo").trigger()
    assert window.live.prepared.scene == before.scene
    window.action("redo").trigger()
    assert len(window.live.prepared.scene.grids) == 1
