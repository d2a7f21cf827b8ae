"""The controller's task and contact ellipses on the map: location, colour and cached pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QColor

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument, show_patches
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.layers import LAYERS, at_first
from tactile_widgets.views.map.painting.map_layers import ellipses_on_map
from tactile_widgets.views.map.painting.task_layer import ACTUAL, REFERENCE, TARGET, task_legend_entries
from tactile_widgets.views.overlays.task_overlay import (
    NO_TASK,
    ContactTrail,
    ReferencePath,
    TaskOverlay,
    lines_on_skin,
)
from tests.widgets.support.layered_map_view import layered_map_view
from tests.widgets.support.samples import leaf_map, middle_taxel, touched
from tests.widgets.support.snapshots import check_picture, pixels


@pytest.fixture(scope="module")
def tactile_map():
    return leaf_map()


@pytest.fixture
def view(qtbot, tactile_map):
    made = layered_map_view(DARK, PressureScale())
    qtbot.addWidget(made)
    made.resize(700, 420)
    made.show_document(MapDocument.of(tactile_map))
    made.show()
    qtbot.waitExposed(made)
    return made


def middle(tactile_map, patch=0):
    return tactile_map.boxes[patch].mean(axis=0)


def example_task(tactile_map, *, above=0.03):
    """A path over both leaves, a target, and a contact path below."""
    here = middle(tactile_map)
    there = middle(tactile_map, 1)
    corners = np.array([here + [-0.06, above], here + [0.05, above], there + [0.0, above]])
    lines = lines_on_skin(corners, tactile_map)
    assert [line.patch for line in lines] == [0, 1]
    way = here + np.linspace([-0.05, -0.04], [0.05, -0.04], 30)
    at = [tactile_map.to_body(point) for point in way]
    skin = tactile_map.skin
    body, up = (np.array([of(one) for one in at]) for of in (skin.position, skin.normal))
    tail = ContactTrail(np.zeros(30, int), way, body, up, np.linspace(0.98, 0.0, 30), np.zeros(30, bool))
    crossing = np.array([[lines[0].on_map[-1], lines[1].on_map[0]]])
    return TaskOverlay(ReferencePath(lines, crossing, np.array([[0, 1]])), tactile_map.to_body(here), 3.0, 0, tail)


def colour(view, point):
    """Colour of the pixel of a map point (2,) [m]."""
    x, y = view.map_to_pixels(np.array(point)[None])[0].round().astype(int).tolist()
    return np.array(QColor(view.grab().toImage().pixelColor(x, y)).getRgb()[:3])


def near(one, hex_):
    return bool(np.abs(one - QColor(hex_).getRgb()[:3]).max() < 40)


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_path_is_violet_and_contact_path_white_with_a_dark_rim(view, tactile_map, theme):
    view.set_theme(theme)
    task = example_task(tactile_map)
    before = [colour(view, line.on_map[len(line.on_map) // 2]) for line in task.path.lines]
    view.show_task(task)
    for line, plain in zip(task.path.lines, before, strict=True):
        assert near(colour(view, line.on_map[len(line.on_map) // 2]), theme.intent)
        assert not near(plain, theme.intent)
    now = task.tail.on_map[-3]
    old = task.tail.on_map[2]
    assert colour(view, now).min() > 245
    rim = [
        colour(view, now + [0.0, step * view._pixel_size(view.picture.shapes.frame)]).max() for step in (-3, -2, 2, 3)
    ]
    assert min(rim) < 80
    faded = [
        colour(view, old + [0.0, step * view._pixel_size(view.picture.shapes.frame)]).max() for step in (-3, -2, 2, 3)
    ]
    assert min(faded) > min(rim) + 60


def test_target_mark_leaves_its_centre_free(view, tactile_map):
    plain = colour(view, middle(tactile_map))
    view.show_task(example_task(tactile_map))
    np.testing.assert_array_equal(colour(view, middle(tactile_map)), plain)
    for dx, dy in ((15, 0), (-15, 0), (0, 15), (0, -15)):
        assert near(
            colour(view, middle(tactile_map) + view._pixel_size(view.picture.shapes.frame) * np.array([dx, dy])),
            DARK.intent,
        )


def test_hidden_patch_hides_its_part_of_the_task(view, tactile_map):
    task = example_task(tactile_map)
    view.show_task(task)
    hidden = show_patches(MapDocument.of(tactile_map), [0], visible=False)
    view.show_document(hidden)
    for line, shown in zip(task.path.lines, (False, True), strict=True):
        assert near(colour(view, line.on_map[len(line.on_map) // 2]), DARK.intent) is shown
    assert not near(
        colour(view, middle(tactile_map) + [9 * view._pixel_size(view.picture.shapes.frame), 0]), DARK.intent
    )


def test_legend_lists_the_marks_of_the_task(view, tactile_map):
    task = example_task(tactile_map)
    assert task_legend_entries(task) == (REFERENCE, TARGET, ACTUAL)
    assert task_legend_entries(replace(task, path=ReferencePath(), tail=ContactTrail())) == (TARGET,)
    before = pixels(view.grab().toImage())
    view.show_task(task)
    view.show_task(NO_TASK)
    np.testing.assert_array_equal(pixels(view.grab().toImage()), before)


def test_cached_path_equals_painted_path_and_moves_with_the_map(view, tactile_map):
    view.show_task(example_task(tactile_map))
    first = pixels(view.grab().toImage())
    np.testing.assert_array_equal(pixels(view.grab().toImage()), first)
    view.pan(17, -9)
    assert near(colour(view, example_task(tactile_map).path.lines[0].on_map[10]), DARK.intent)
    view.pan(-17, 9)
    np.testing.assert_array_equal(pixels(view.grab().toImage()), first)
    view.zoom(1.7, view.viewport().rect().center().toPointF())
    assert near(colour(view, example_task(tactile_map).path.lines[0].on_map[18]), DARK.intent)


def test_contact_ellipse_and_error_circle_are_drawn(view, tactile_map):
    frame = touched(tactile_map, [middle_taxel(tactile_map, 0)])
    (region,) = frame.regions
    view.show_frame(frame)
    with_shapes = pixels(view.grab().toImage())
    view.set_overlays(at_first(LAYERS).toggled("shapes"))
    without = pixels(view.grab().toImage())
    changed = np.argwhere((with_shapes != without).any(axis=2))[:, ::-1]
    assert len(changed) > 60
    centre = view.map_to_pixels(tactile_map.to_map(region.at)[None])[0]
    ellipse, error = (
        axes / view._pixel_size(view.picture.shapes.frame) for axes in ellipses_on_map(region, tactile_map)
    )
    away = np.stack([changed[:, 0] - centre[0], centre[1] - changed[:, 1]])
    on_ellipse, on_circle = (
        np.abs(np.linalg.norm(np.linalg.solve(axes.T, away), axis=0) - 1) < 0.25 for axes in (ellipse, error)
    )
    assert on_ellipse.sum() > 30
    assert on_circle.sum() > 8
    assert (on_ellipse | on_circle).mean() > 0.95


def test_ellipse_follows_rotation_and_scale_of_the_patch(tactile_map):
    """A patch turned and drawn twice as large has its ellipse turned and twice as large."""
    region = touched(tactile_map, [middle_taxel(tactile_map, 0)]).regions[0]
    placed = tactile_map.layout.placements[0]
    other = replace(placed, angle=placed.angle + 0.7, scale=2.0)
    layout = replace(tactile_map.layout, placements=(other, *tactile_map.layout.placements[1:]))
    before, _ = ellipses_on_map(region, tactile_map)
    after, circle = ellipses_on_map(region, replace(tactile_map, layout=layout))
    turn = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    np.testing.assert_allclose(after, 2 * before @ turn, atol=1e-12)
    np.testing.assert_allclose(circle @ circle.T, (2 * region.place_error) ** 2 * np.eye(2), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(before, axis=1), np.linalg.norm(region.link_axes, axis=1))


def test_small_ellipses_are_not_drawn(view, tactile_map):
    frame = touched(tactile_map, [middle_taxel(tactile_map, 0)], radius=0.02)
    small = tuple(replace(r, link_axes=0.05 * r.link_axes, place_error=1e-4) for r in frame.regions)
    view.show_frame(replace(frame, regions=small))
    with_shapes = pixels(view.grab().toImage())
    view.set_overlays(at_first(LAYERS).toggled("shapes"))
    np.testing.assert_array_equal(pixels(view.grab().toImage()), with_shapes)


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_task_layer_matches_its_snapshot(view, tactile_map, theme):
    view.set_theme(theme)
    frame = touched(tactile_map, [middle_taxel(tactile_map, 0)])
    view.show_frame(frame, task=replace(example_task(tactile_map), contact=frame.regions[0].id))
    check_picture(view, f"task_on_map_{theme.name}")


def test_path_and_contact_path_are_drawn_with_a_patch_that_is_dragged(view, tactile_map):
    task = example_task(tactile_map)
    view.show_task(task)
    by = np.array([0.0, -0.02])
    start = MapDocument.of(tactile_map)
    moving = [task.path.lines[0].on_map[10], task.tail.on_map[-3]]
    inks = [colour(view, point) for point in moving]
    view.show_document(move(start, [0], (0.0, -0.3)), in_gesture=True)
    view.show_document(move(start, [0], tuple(by)), in_gesture=True)
    for point, ink in zip(moving, inks, strict=True):
        assert np.abs(colour(view, point + by) - ink).max() < 40
    assert not near(colour(view, moving[0]), DARK.intent)
    still = task.path.lines[1].on_map
    assert near(colour(view, still[len(still) // 2]), DARK.intent)
    view.show_document(start, in_gesture=True)
    assert near(colour(view, moving[0]), DARK.intent)
