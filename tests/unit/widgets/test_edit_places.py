"""What the pointer means: vertices and seams in reach, and what a brush covers, on map and body."""

from __future__ import annotations

import numpy as np
import pytest

from app.editing.document import MapDocument
from app.editing.patches import show
from app.geometry.surface_point import SurfacePoint
from app.maps.build import build_map
from tests.numerics.map_surfaces import frustum, sheet, skin_of
from widgets.edit_tool import Place
from widgets.edit_tools.edges import present_seams
from widgets.edit_tools.places import REACH_PX, brushed, seam_at, vertex_at

PIXEL = 1e-3
NOWHERE = Place(None, None, PIXEL)


@pytest.fixture(scope="module")
def document():
    """A thin tube of 4 mm radius, and a sheet."""
    return MapDocument.of(
        build_map(skin_of(frustum(0.004, 0.004, length=0.08, around=12, along=20), sheet(8, 6), taxels=9))
    )


def on_body(face, patch=0, weights=(0.6, 0.3, 0.1)):
    return Place(SurfacePoint(patch, face, weights), None, PIXEL)


def on_map(document, point):
    return Place(document.map.to_body(np.asarray(point)), np.asarray(point, float), PIXEL)


def test_on_the_skin_the_nearest_corner_is_meant_and_beside_the_body_nothing(document):
    assert vertex_at(document, on_body(5)) == (0, document.skin.patches[0].surface.faces[5, 0])
    assert vertex_at(document, NOWHERE) is None
    for vertex in (10, 31):
        point = document.map.uv[1][document.charts[1].vertex_of == vertex][0]
        inwards = point + 0.05 * (document.map.boxes[1].mean(axis=0) - point)
        assert vertex_at(document, on_map(document, inwards)) == (1, vertex)


def test_a_hidden_patch_has_no_border_to_snap_to(document):
    low, high = document.map.boxes[1]
    beside = np.array([high[0] + 0.4 * REACH_PX * PIXEL, 0.5 * (low[1] + high[1])])
    assert vertex_at(document, on_map(document, beside))[0] == 1
    assert vertex_at(show(document, [1], visible=False), on_map(document, beside)) is None
    assert vertex_at(document, on_map(document, [9.0, 9.0])) is None


def test_a_seam_is_in_reach_from_both_its_sides_and_on_the_body(document):
    edges = {tuple(edge) for edge in present_seams(document, 0).tolist()}
    for side in document.map.seams[0][[0, -1]]:
        number, run = seam_at(document, on_map(document, side.mean(axis=0)))
        assert number == 0
        assert {tuple(sorted(edge)) for edge in zip(run[:-1].tolist(), run[1:].tolist(), strict=True)} <= edges
    vertex = next(iter(edges))[0]
    (face, corner), *_ = np.argwhere(document.skin.patches[0].surface.faces == vertex).tolist()
    weights = tuple(float(k == corner) for k in range(3))
    assert seam_at(document, on_body(face, weights=weights))[0] == 0
    assert seam_at(document, on_map(document, document.map.boxes[1].mean(axis=0))) is None
    assert seam_at(document, NOWHERE) is None


def test_a_brush_on_the_body_leaves_the_far_side_of_a_thin_patch_alone(document):
    surface, place = document.skin.patches[0].surface, on_body(200)
    near = np.linalg.norm(surface.vertices - document.skin.position(place.at), axis=1) <= 10e-3
    facing = surface.vertex_normals @ document.skin.normal(place.at) > 0
    assert near.sum() > (near & facing).sum() > 10
    np.testing.assert_array_equal(brushed(document, place, place, 10)[0], np.flatnonzero(near & facing))


def test_a_brush_covers_the_way_from_place_to_place_of_one_view(document):
    start, end = (on_map(document, document.map.boxes[1].mean(axis=0) + [x, 0]) for x in (-0.02, 0.02))
    way = set(brushed(document, start, end, 12)[1].tolist())
    assert way > {*brushed(document, start, start, 12)[1].tolist(), *brushed(document, end, end, 12)[1].tolist()}
    assert set(brushed(document, on_body(3), end, 12)[1].tolist()) < way
    assert brushed(document, end, NOWHERE, 6) == {}


def test_the_smallest_brush_covers_the_nearest_vertex(document):
    place = on_body(7, patch=1)
    assert brushed(document, place, place, 0.01)[1].tolist() == [document.skin.patches[1].surface.faces[7, 0]]
    point = document.map.boxes[1].mean(axis=0) + [0.002, 0.003]
    place = on_map(document, point)
    assert brushed(document, place, place, 0.01) == {1: [vertex_at(document, place)[1]]}
