"""The map's shapes: a patch's outline falls into skin border and seams, without loss and in long pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.editing.arrange import mirror, rotate, scale
from tactile_maps.editing.document import MapDocument
from tactile_widgets.views.map.items.map_coordinates import SceneTransform
from tactile_widgets.views.map.items.map_shapes import ChartShape, MapShapes, split_loop, wireframe

ANGLES = np.linspace(0, 2 * np.pi, 13)
LOOP = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
LOOP[-1] = LOOP[0]


def _length(lines):
    return sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)


@pytest.mark.parametrize("shift", range(12))
def test_loop_is_split_into_long_polylines(shift):
    marked = np.roll(np.array([True] * 3 + [False] * 4 + [True] * 2 + [False] * 3), shift)
    plain, seams = split_loop(LOOP, marked)
    assert sorted(len(line) for line in plain) == [4, 5]
    assert sorted(len(line) for line in seams) == [3, 4]
    edge = np.linalg.norm(LOOP[1] - LOOP[0])
    assert _length(plain) == pytest.approx(7 * edge)
    assert _length(seams) == pytest.approx(5 * edge)


def test_loop_of_one_kind_stays_whole():
    plain, seams = split_loop(LOOP, np.zeros(12, dtype=bool))
    assert (len(plain), seams) == (1, ())
    plain, seams = split_loop(LOOP, np.ones(12, dtype=bool))
    assert (plain, len(seams)) == ((), 1)


def test_shapes_of_a_real_map_are_complete(prepared):
    document = MapDocument.of(prepared.map)
    shapes = MapShapes.of(document, SceneTransform.around(prepared.map.bounds))
    assert [patch.name for patch in shapes.patches] == [patch.name for patch in prepared.skin.patches]
    assert shapes.taxels == pytest.approx(shapes.frame.to_scene(prepared.map.taxel_points))
    assert shapes.pitch > 0
    for patch, seams, outline in zip(shapes.patches, prepared.map.seams, prepared.map.outlines, strict=True):
        shape = patch.chart
        assert _length(shape.border) + _length(shape.seam) == pytest.approx(_length([shape.outline]))
        assert _length(shape.seam) == pytest.approx(_length(np.asarray(seams).reshape(-1, 2, 2)), rel=1e-6)
        assert patch.to_scene(shape.outline[:-1]) == pytest.approx(shapes.frame.to_scene(outline))


def test_layout_keeps_chart_shapes(prepared):
    document = MapDocument.of(prepared.map)
    first = MapShapes.of(document, SceneTransform.around(prepared.map.bounds))
    moved = mirror(rotate(scale(document, [0], 1.5), [0, 1], 0.7), [0])
    second = MapShapes.of(moved, first.frame, known=first)
    assert all(old.chart is new.chart for old, new in zip(first.patches, second.patches, strict=True))
    assert second.taxels == pytest.approx(first.frame.to_scene(moved.map.taxel_points))
    low, high = first.frame.to_scene(moved.map.bounds)
    assert second.bounds == pytest.approx(np.array([[low[0], high[1]], [high[0], low[1]]]))


def test_dragged_chart_keeps_its_loop(prepared):
    document = MapDocument.of(prepared.map)
    first = MapShapes.of(document, SceneTransform.around(prepared.map.bounds))
    pulled = replace(document.charts[0], plane=document.charts[0].plane * [1.2, 1.0])
    shape = ChartShape.of(document.skin.patches[0], pulled, known=first.patches[0].chart)
    assert "border" not in vars(pulled)
    assert shape.outline == pytest.approx(first.patches[0].chart.outline * [1.2, 1.0])


def test_wireframe_connects_taxels_but_not_across_seams(prepared):
    patch = prepared.skin.patches[0]
    shape = ChartShape.of(prepared.skin.patches[0], prepared.map.charts[0])
    all_lines = np.linalg.norm(np.diff(shape.taxels[patch.taxels.neighbours], axis=1)[:, 0], axis=1)
    assert all_lines.max() > 5 * np.median(all_lines)
    joined = shape.lines(wireframe(shape, patch, most=3000))
    lengths = np.linalg.norm(np.diff(joined, axis=1)[:, 0], axis=1)
    assert lengths.max() <= 3 * np.median(all_lines)
    assert len(joined) > 0.9 * len(patch.taxels.neighbours)


def test_wireframe_without_neighbours_is_a_thinned_mesh(prepared):
    patch = prepared.skin.patches[0]
    chart = prepared.map.charts[0]
    shape = ChartShape.of(patch, chart)
    bare = replace(patch, taxels=replace(patch.taxels, neighbours=np.zeros((0, 2), int)))
    by_taxels, whole = wireframe(shape, bare, most=10**6)
    assert not by_taxels
    edges = len(chart.vertex_of) + len(chart.faces) - 1  # Euler, of a disk
    assert 0.9 * edges < len(whole) <= edges
    _, thin = wireframe(shape, bare, most=100)
    assert len(np.unique(thin, axis=0)) == 100
    assert shape.lines((False, thin)).shape == (100, 2, 2)
