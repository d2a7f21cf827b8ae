"""Paths, runs and places of edges on real small maps, without a screen."""

from __future__ import annotations

import numpy as np
import pytest

from app.editing.document import MapDocument
from app.geometry.topology import edge_table
from app.maps.build import build_map
from app.maps.seams import path_along_edges
from tests.numerics.map_surfaces import frustum, sheet, skin_of
from widgets.edit_tools.edges import (
    EdgePaths,
    as_edges,
    lines_on_map,
    on_map,
    present_seams,
    runs,
    vertex_on_map,
    vertex_point,
)


@pytest.fixture(scope="module")
def document():
    return MapDocument.of(build_map(skin_of(frustum(around=16, along=6), sheet(8, 6), taxels=12)))


def pairs(edges):
    return {tuple(edge) for edge in np.sort(edges, axis=1).tolist()}


@pytest.mark.parametrize("seed", range(5))
def test_a_path_is_the_one_a_drawn_seam_takes(document, seed):
    surface, random = document.skin.patches[1].surface, np.random.default_rng(seed)
    importance = random.uniform(0, 9, len(surface.vertices))
    through = random.choice(len(surface.vertices), 4, replace=False).tolist()
    for weights in (None, importance):
        path = EdgePaths(surface, weights).through(through)
        assert pairs(as_edges(path)) == pairs(path_along_edges(surface, through, importance=weights))
        assert path[0] == through[0]
        assert path[-1] == through[-1]


def test_runs_go_from_end_or_branch_to_the_next_and_rings_close():
    star = np.array([[0, 1], [1, 2], [2, 3], [2, 4], [4, 5]])
    assert sorted(line.tolist() for line in runs(star)) in (
        [[0, 1, 2], [2, 3], [2, 4, 5]],
        [[0, 1, 2], [3, 2], [2, 4, 5]],
        [[0, 1, 2], [3, 2], [5, 4, 2]],
        [[0, 1, 2], [2, 3], [5, 4, 2]],
    )
    (ring,) = runs(np.array([[3, 4], [4, 5], [5, 3]]))
    assert ring[0] == ring[-1]
    assert sorted(ring[:-1].tolist()) == [3, 4, 5]
    assert runs(np.zeros((0, 2), int)) == []


@pytest.mark.parametrize("seed", range(5))
def test_runs_hold_every_edge_once(document, seed):
    edges = document.skin.patches[1].surface.edges
    some = edges[np.random.default_rng(seed).random(len(edges)) < 0.3]
    found = np.concatenate([as_edges(line) for line in runs(some)])
    assert len(found) == len(some)
    assert pairs(found) == pairs(some)


def test_an_edge_lies_once_on_the_map_and_a_seam_twice(document):
    seams = present_seams(document, 0)
    assert pairs(seams) == pairs(document.charts[0].seams)
    inner = edge_table(document.skin.patches[0].surface.faces).edges[:1]
    assert pairs(inner).isdisjoint(pairs(seams))
    assert len(on_map(document, 0, inner)) == 1
    segments = on_map(document, 0, seams)
    assert len(segments) == 2 * len(seams)
    known = {tuple(sorted(map(tuple, ends))) for ends in document.map.seams[0].round(9).tolist()}
    assert {tuple(sorted(map(tuple, ends))) for ends in segments.round(9).tolist()} == known
    lines = lines_on_map(document, 0, seams)
    assert len(lines) == 2
    assert sum(len(line) - 1 for line in lines) == len(segments)


def test_a_vertex_is_found_on_body_and_map(document):
    vertex = int(document.charts[0].seams[0, 0])
    assert len(vertex_on_map(document, 0, vertex)) == 2
    at = vertex_point(document, 0, vertex)
    np.testing.assert_allclose(document.skin.position(at), document.skin.patches[0].surface.vertices[vertex])
