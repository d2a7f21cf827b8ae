"""Selection of taxels with mouse events in either view: shown in both views, without hidden taxels."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.tool_kinds import (
    BRUSH,
    LARGEST_BRUSH,
    POKE,
    SELECT_BOX,
    SELECT_BRUSH,
    SELECT_LASSO,
    SMALLEST_BRUSH,
    resized_brush,
)
from tests.widgets.support.samples import middle_taxel
from tests.widgets.support.window_driver import run, visible_skin

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
CTRL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
ALT = Qt.KeyboardModifier.AltModifier


class Side:
    """Driver of one of the two views."""

    def __init__(self, window, name):
        self.window = window
        self.name = name
        self.view = window.map_view if name == "map" else window.robot_view
        self.target = self.view.viewport() if name == "map" else self.view.display.canvas.widget

    def pixel(self, taxel):
        return self.view.pixel_of(self.window.live.prepared.skin.taxel_point(taxel)).toPoint()

    def taxels(self):
        """Visible taxels, the first with others around it."""
        tactile_map = self.window.live.prepared.map
        skin = self.window.live.prepared.skin
        if self.name == "map":
            centre = middle_taxel(tactile_map, 0)
            seen = np.arange(int(skin.first[1]))
            away = np.linalg.norm(tactile_map.taxel_points[seen] - tactile_map.taxel_points[centre], axis=1)
        else:
            centre = self.view.taxel_at(QPointF(visible_skin(self.window)[1]).toTuple())
            seen = np.array([k for k in range(len(skin)) if self.picked(k) == k])
            away = np.linalg.norm(self.view.taxel_pixels()[seen] - self.view.taxel_pixels()[centre], axis=1)
        return seen[np.argsort(away)]

    def picked(self, taxel):
        return self.view.taxel_at(QPointF(self.pixel(taxel)).toTuple())

    def click(self, taxel, keys=NONE):
        QTest.mouseClick(self.target, LEFT, keys, self.pixel(taxel))

    def press(self, pixel, keys=NONE):
        QTest.mousePress(self.target, LEFT, keys, pixel)

    def drag(self, *pixels):
        for pixel in pixels:
            QTest.mouseMove(self.target, pixel)

    def release(self, pixel, keys=NONE):
        QTest.mouseRelease(self.target, LEFT, keys, pixel)


@pytest.fixture
def window(window_again):
    """Shared window: only the selection has to be undone."""
    return window_again


@pytest.fixture(params=["map", "body"])
def side(window, request):
    run(window, 0.1)
    window.presenters.view.set_tool(SELECT_BOX)
    return Side(window, request.param)


def selected(window):
    return window.views.selection.taxels.tolist()


def ringed_on_body(window):
    """Taxels that the robot view rings, of all patches."""
    return np.concatenate(window.robot_view.display.actors.skin._rings._shown).tolist()


def around(pixel, reach):
    return [pixel + QPoint(x, y) for x, y in ((-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach))]


@pytest.mark.long
def test_selection_in_one_view_is_marked_in_both(window, side):
    taxel = int(side.taxels()[0])
    before = window.map_view.grab().toImage()
    side.click(taxel)
    assert ringed_on_body(window) == [taxel]
    assert window.map_view.picture.taxels.selected.tolist() == [taxel]
    assert window.map_view.grab().toImage() != before
    assert f"Taxel {taxel} selected" in window.findChild(object, "selection-count").text()


@pytest.mark.long
def test_selecting_does_not_poke(window, side):
    heard = []
    for gestures in window.views.interactions:
        gestures.poke_pressed.connect(heard.append)
    side.click(int(side.taxels()[0]))
    window.presenters.view.set_tool(SELECT_LASSO)
    side.press(side.pixel(int(side.taxels()[0])))
    assert heard == []
    window.presenters.view.set_tool(POKE)
    side.press(side.pixel(int(side.taxels()[0])))
    assert len(heard) == 1, "precondition: with the poke tool it does"


@pytest.mark.long
@pytest.mark.rotating
@pytest.mark.parametrize("tool", [SELECT_BOX, SELECT_LASSO])
def test_box_and_lasso_select_the_taxels_that_they_enclose(window, side, tool):
    window.presenters.view.set_tool(tool)
    taxel = int(side.taxels()[0])
    middle = side.pixel(taxel)
    reach = 40
    corners = around(middle, reach)
    start = middle if side.name == "body" else corners[0]
    side.press(start)
    # A box has only two corners; on the body it must begin on the skin, and here ends past the taxel itself.
    path = [corners[2]] if tool is SELECT_BOX else [*corners, corners[0]]
    side.drag(*path)
    outline = side.view.interaction.taxel_selector.rubber_band.outline
    side.release(path[-1])
    pixels = side.view.taxel_pixels()
    low = outline.min(axis=0)
    high = outline.max(axis=0)
    expected = np.flatnonzero(((pixels >= low) & (pixels <= high)).all(axis=1))
    expected = expected[~side.view.hidden(expected)]
    assert len(expected) >= 2
    if tool is SELECT_BOX:
        assert selected(window) == expected.tolist()
    else:
        assert taxel in selected(window)
        assert set(selected(window)) <= set(expected.tolist())
    assert side.view.interaction.taxel_selector.rubber_band.outline is None


@pytest.mark.long
def test_shrinking_box_releases_taxels(window, side):
    kept = int(side.taxels()[-1])
    side.click(kept)
    start = side.pixel(int(side.taxels()[0]))
    side.press(start, SHIFT)
    side.drag(start + QPoint(90, 90))
    many = len(selected(window))
    side.drag(start + QPoint(-1, -1))
    assert len(selected(window)) < many
    assert kept in selected(window)
    side.release(start + QPoint(-1, -1))


@pytest.mark.long
def test_brush_selects_within_its_radius(window, side):
    window.presenters.view.set_tool(SELECT_BRUSH)
    start = side.pixel(int(side.taxels()[0]))
    counts = []
    for steps in (-3, 6):
        window.views.resize_brush(steps)
        side.press(start)
        side.drag(start + QPoint(15, 0), start + QPoint(30, 0))
        side.release(start + QPoint(30, 0))
        counts.append(len(selected(window)))
    assert counts[1] > counts[0]
    radius = side.view.interaction.taxel_selector.rubber_band.radius
    assert radius > BRUSH
    chosen = side.view.taxel_pixels()[selected(window)]
    on_line = np.clip(chosen[:, 0], start.x(), start.x() + 30)
    away = np.hypot(chosen[:, 0] - on_line, chosen[:, 1] - start.y())
    assert away.max() <= radius + 1e-9


@pytest.mark.long
def test_bracket_keys_resize_the_brush_of_both_views(window, side):
    window.activateWindow()
    side.view.setFocus()
    window.presenters.view.set_tool(SELECT_BRUSH)
    for key, larger in ((Qt.Key.Key_BracketRight, True), (Qt.Key.Key_BracketLeft, False)):
        before = side.view.interaction.taxel_selector.rubber_band.radius
        QTest.keyClick(side.view, key)
        radii = {view.interaction.taxel_selector.rubber_band.radius for view in (window.map_view, window.robot_view)}
        assert len(radii) == 1
        assert (radii.pop() > before) is larger


@pytest.mark.long
@pytest.mark.rotating
@pytest.mark.parametrize("tool", [SELECT_BOX, SELECT_LASSO, SELECT_BRUSH])
def test_escape_cancels_a_drag_and_then_clears_the_selection(window, side, tool):
    kept = int(side.taxels()[-1])
    side.click(kept)
    window.presenters.view.set_tool(tool)
    start = side.pixel(int(side.taxels()[0]))
    side.press(start)
    side.drag(start + QPoint(20, 0), start + QPoint(40, 40), start + QPoint(0, 40))
    assert selected(window) != [kept]
    QTest.keyClick(side.view, Qt.Key.Key_Escape)
    assert selected(window) == [kept]
    side.release(start)
    assert selected(window) == [kept], "the release afterwards is no click"
    QTest.keyClick(side.view, Qt.Key.Key_Escape)
    assert selected(window) == []


@pytest.mark.long
def test_far_side_of_the_body_is_never_selected(window):
    run(window, 0.1)
    window.presenters.view.set_tool(SELECT_LASSO)
    side = Side(window, "body")
    view = window.robot_view
    prepared = window.live.prepared
    start = visible_skin(window)[1]
    side.press(start)
    whole = [QPoint(2, 2), QPoint(view.width() - 3, 2), QPoint(view.width() - 3, view.height() - 3)]
    side.drag(*whole, QPoint(2, view.height() - 3), QPoint(2, 2))
    side.release(QPoint(2, 2))
    chosen = selected(window)
    assert 20 < len(chosen) < len(prepared.skin) - 20
    positions, normals = view._taxels.world(view.display.actors.poses)
    towards = view.display.actors.viewpoint.eye - positions
    facing = np.einsum("nk,nk->n", towards, normals) > 0
    assert facing[chosen].all()
    # A ray to each taxel meets the skin around it; at the rim it may miss.
    met = [view.point_at(QPointF(*pixel)) for pixel in view.taxel_pixels()[chosen]]
    pairs = [(positions[taxel], _world(view, prepared, at)) for taxel, at in zip(chosen, met, strict=True) if at]
    assert len(pairs) >= 0.9 * len(chosen)
    assert max(np.linalg.norm(taxel - place) for taxel, place in pairs) < 0.02
    hidden = view.hidden(np.flatnonzero(facing))
    assert hidden.any(), "some taxels that face the camera are behind another link"
    assert not set(np.flatnonzero(facing)[hidden].tolist()) & set(chosen)


def _world(view, prepared, at):
    pose = view.display.actors.poses[prepared.robot.link_index[prepared.skin.patches[at.patch].link]]
    return pose[:3, :3] @ prepared.skin.position(at) + pose[:3, 3]


@pytest.mark.long
def test_keys_select_all_or_no_taxels_and_invert_the_selection(window, side):
    count = len(window.live.prepared.skin)
    window.activateWindow()
    side.view.setFocus()
    QTest.keyClick(side.view, Qt.Key.Key_A)
    assert len(selected(window)) == count
    side.click(int(side.taxels()[0]), ALT)
    QTest.keyClick(side.view, Qt.Key.Key_I, CTRL)
    assert selected(window) == [int(side.taxels()[0])]
    QTest.keyClick(side.view, Qt.Key.Key_A, ALT)
    assert selected(window) == []
    window.column.setFocus()
    QApplication.processEvents()
    QTest.keyClick(window.column, Qt.Key.Key_A)
    assert len(selected(window)) == count, "the keys work wherever no text is entered"


@pytest.mark.long
def test_hovered_location_is_marked_in_both_views(window, side):
    taxel = int(side.taxels()[0])
    QTest.mouseMove(side.target, side.pixel(taxel))
    at = window.map_view.interaction.hover if side.name == "map" else window.robot_view.interaction.hover
    assert at is not None
    assert window.map_view.marks.hover is not None
    np.testing.assert_allclose(
        window.map_view.marks.hover.toTuple(), window.map_view.picture.place_of(at).toTuple(), atol=1e-9
    )
    mark = window.robot_view.display.actors._marks._hover
    window.robot_view.display.draw_now()
    assert mark.visibility
    place = np.asarray(mark.user_matrix)[:3, 3]
    assert np.linalg.norm(place - _world(window.robot_view, window.live.prepared, at)) < 2e-3
    assert f"taxel {side.picked(taxel) if side.name == 'body' else taxel}" in window.readout.text()
    QTest.mouseMove(side.target, QPoint(3, 3))
    assert window.map_view.marks.hover is None
    window.robot_view.display.draw_now()
    assert not mark.visibility
    assert window.readout.text() == ""


def test_brush_grows_and_shrinks_in_steps_within_limits():
    assert resized_brush(BRUSH, 1) > BRUSH
    assert resized_brush(resized_brush(BRUSH, 1), -1) == pytest.approx(BRUSH)
    assert [resized_brush(BRUSH, steps) for steps in (99, -99)] == [LARGEST_BRUSH, SMALLEST_BRUSH]
