"""Paths, runs and map positions of edges on small real maps, and picking on map and body, without a screen."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from tactile_maps.editing.document import MapDocument, show_patches
from tactile_maps.flattening.cut import shortest_edge_path
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_widgets.tools.map_editing.mesh_picking import (
    PICK_RADIUS_PX,
    EdgePaths,
    as_edges,
    lines_on_map,
    on_map,
    present_seams,
    seam_at,
    seam_runs,
    vertex_at,
    vertex_on_map,
    vertex_point,
    vertices_under_brush,
)
from tactile_widgets.views.interaction.view_tool import PointerHit
from tests.support.surfaces import frustum, sheet, skin_of


@pytest.fixture(scope="module")
def document():
    return MapDocument.of(build_map(skin_of(frustum(around=16, along=6), sheet(8, 6), taxels=12)))


def pairs(edges):
    return {tuple(edge) for edge in np.sort(edges, axis=1).tolist()}


@pytest.mark.parametrize("seed", range(5))
def test_path_equals_that_of_a_drawn_seam(document, seed):
    surface = document.skin.patches[1].surface
    random = np.random.default_rng(seed)
    importance = random.uniform(0, 9, len(surface.vertices))
    through = random.choice(len(surface.vertices), 4, replace=False).tolist()
    for weights in (None, importance):
        path = EdgePaths(surface, weights).through(through)
        assert pairs(as_edges(path)) == pairs(shortest_edge_path(surface, through, importance=weights))
        assert path[0] == through[0]
        assert path[-1] == through[-1]


def test_runs_end_at_ends_and_branches_and_rings_are_closed():
    star = np.array([[0, 1], [1, 2], [2, 3], [2, 4], [4, 5]])
    assert sorted(line.tolist() for line in seam_runs(star)) in (
        [[0, 1, 2], [2, 3], [2, 4, 5]],
        [[0, 1, 2], [3, 2], [2, 4, 5]],
        [[0, 1, 2], [3, 2], [5, 4, 2]],
        [[0, 1, 2], [2, 3], [5, 4, 2]],
    )
    (ring,) = seam_runs(np.array([[3, 4], [4, 5], [5, 3]]))
    assert ring[0] == ring[-1]
    assert sorted(ring[:-1].tolist()) == [3, 4, 5]
    assert seam_runs(np.zeros((0, 2), int)) == []


@pytest.mark.parametrize("seed", range(5))
def test_runs_contain_every_edge_once(document, seed):
    edges = document.skin.patches[1].surface.edges
    some = edges[np.random.default_rng(seed).random(len(edges)) < 0.3]
    found = np.concatenate([as_edges(line) for line in seam_runs(some)])
    assert len(found) == len(some)
    assert pairs(found) == pairs(some)


def test_edge_is_on_the_map_once_and_seam_edge_twice(document):
    seams = present_seams(document, 0)
    assert pairs(seams) == pairs(document.charts[0].seams)
    inner = document.skin.patches[0].surface.connectivity.edges[:1]
    assert pairs(inner).isdisjoint(pairs(seams))
    assert len(on_map(document, 0, inner)) == 1
    segments = on_map(document, 0, seams)
    assert len(segments) == 2 * len(seams)
    known = {tuple(sorted(map(tuple, ends))) for ends in document.map.seams[0].round(9).tolist()}
    assert {tuple(sorted(map(tuple, ends))) for ends in segments.round(9).tolist()} == known
    lines = lines_on_map(document, 0, seams)
    assert len(lines) == 2
    assert sum(len(line) - 1 for line in lines) == len(segments)


def test_chart_of_a_closed_map_is_not_kept():
    document = MapDocument.of(build_map(skin_of(sheet(4, 4), taxels=6)))
    assert len(on_map(document, 0, document.skin.patches[0].surface.edges)) > 0
    chart = weakref.ref(document.charts[0])
    del document
    gc.collect()
    assert chart() is None


def test_vertex_is_found_on_body_and_map(document):
    vertex = int(document.charts[0].seams[0, 0])
    assert len(vertex_on_map(document, 0, vertex)) == 2
    at = vertex_point(document, 0, vertex)
    np.testing.assert_allclose(document.skin.position(at), document.skin.patches[0].surface.vertices[vertex])


PIXEL = 1e-3
NOWHERE = PointerHit(None, None, PIXEL)


@pytest.fixture(scope="module")
def thin_tube():
    """Document with a thin tube of 4 mm radius and a sheet."""
    return MapDocument.of(
        build_map(skin_of(frustum(0.004, 0.004, length=0.08, around=12, along=20), sheet(8, 6), taxels=9))
    )


def on_body(face, patch=0, weights=(0.6, 0.3, 0.1)):
    return PointerHit(SurfacePoint(patch, face, weights), None, PIXEL)


def at_map_point(thin_tube, point):
    return PointerHit(thin_tube.map.to_body(np.asarray(point)), np.asarray(point, float), PIXEL)


def test_nearest_corner_is_picked_on_the_skin_and_none_off_the_body(thin_tube):
    assert vertex_at(thin_tube, on_body(5)) == (0, thin_tube.skin.patches[0].surface.faces[5, 0])
    assert vertex_at(thin_tube, NOWHERE) is None
    for vertex in (10, 31):
        point = thin_tube.map.uv[1][thin_tube.charts[1].vertex_of == vertex][0]
        inwards = point + 0.05 * (thin_tube.map.boxes[1].mean(axis=0) - point)
        assert vertex_at(thin_tube, at_map_point(thin_tube, inwards)) == (1, vertex)


def test_border_of_a_hidden_patch_is_not_picked(thin_tube):
    low, high = thin_tube.map.boxes[1]
    outside = np.array([high[0] + 0.4 * PICK_RADIUS_PX * PIXEL, 0.5 * (low[1] + high[1])])
    assert vertex_at(thin_tube, at_map_point(thin_tube, outside))[0] == 1
    assert vertex_at(show_patches(thin_tube, [1], visible=False), at_map_point(thin_tube, outside)) is None
    assert vertex_at(thin_tube, at_map_point(thin_tube, [9.0, 9.0])) is None


def test_seam_is_picked_from_both_map_sides_and_on_the_body(thin_tube):
    edges = {tuple(edge) for edge in present_seams(thin_tube, 0).tolist()}
    for side in thin_tube.map.seams[0][[0, -1]]:
        number, run = seam_at(thin_tube, at_map_point(thin_tube, side.mean(axis=0)))
        assert number == 0
        assert {tuple(sorted(edge)) for edge in zip(run[:-1].tolist(), run[1:].tolist(), strict=True)} <= edges
    vertex = next(iter(edges))[0]
    (face, corner), *_ = np.argwhere(thin_tube.skin.patches[0].surface.faces == vertex).tolist()
    weights = tuple(float(k == corner) for k in range(3))
    assert seam_at(thin_tube, on_body(face, weights=weights))[0] == 0
    assert seam_at(thin_tube, at_map_point(thin_tube, thin_tube.map.boxes[1].mean(axis=0))) is None
    assert seam_at(thin_tube, NOWHERE) is None


def test_brush_on_the_body_skips_the_back_of_a_thin_patch(thin_tube):
    surface = thin_tube.skin.patches[0].surface
    place = on_body(200)
    near = np.linalg.norm(surface.vertices - thin_tube.skin.position(place.at), axis=1) <= 10e-3
    facing = surface.vertex_normals @ thin_tube.skin.normal(place.at) > 0
    assert near.sum() > (near & facing).sum() > 10
    np.testing.assert_array_equal(vertices_under_brush(thin_tube, place, place, 10)[0], np.flatnonzero(near & facing))


def test_brush_covers_the_line_between_two_positions_in_one_view(thin_tube):
    start, end = (at_map_point(thin_tube, thin_tube.map.boxes[1].mean(axis=0) + [x, 0]) for x in (-0.02, 0.02))
    way = set(vertices_under_brush(thin_tube, start, end, 12)[1].tolist())
    assert way > {
        *vertices_under_brush(thin_tube, start, start, 12)[1].tolist(),
        *vertices_under_brush(thin_tube, end, end, 12)[1].tolist(),
    }
    assert set(vertices_under_brush(thin_tube, on_body(3), end, 12)[1].tolist()) < way
    assert vertices_under_brush(thin_tube, end, NOWHERE, 6) == {}


def test_smallest_brush_covers_the_nearest_vertex(thin_tube):
    place = on_body(7, patch=1)
    assert vertices_under_brush(thin_tube, place, place, 0.01)[1].tolist() == [
        thin_tube.skin.patches[1].surface.faces[7, 0]
    ]
    point = thin_tube.map.boxes[1].mean(axis=0) + [0.002, 0.003]
    place = at_map_point(thin_tube, point)
    assert vertices_under_brush(thin_tube, place, place, 0.01) == {1: [vertex_at(thin_tube, place)[1]]}
