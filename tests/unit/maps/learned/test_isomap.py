"""Isomap with both distances: the bias of edges, and the exactness of the exact."""

from __future__ import annotations

import numpy as np
import pytest

from app.core.errors import MapError
from app.geometry.mesh import Mesh
from app.maps.learned.isomap import isomap
from tests.support.surfaces import sheet, with_thin_faces


def _lattice(shape, columns=14, rows=15, side=0.01) -> Mesh:
    """Equilateral triangles, rolled up without stretching by ``shape``."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    a, low = (i * rows + j), j % 2 == 0
    inner = (i < columns - 1) & (j < rows - 1)
    a, low = a[inner], low[inner]
    right, up, corner = a + rows, a + 1, a + rows + 1
    first = np.stack([a, right, np.where(low, up, corner)], axis=1)
    second = np.stack([np.where(low, right, a), corner, up], axis=1)
    return Mesh(shape(side * (i + 0.5 * (j % 2)), side * np.sqrt(0.75) * j), np.concatenate([first, second]))


SHAPES = {
    "flat": lambda x, y: np.stack([x, y, 0 * x], axis=1),
    "half a tube": lambda x, y: np.stack([0.05 * np.cos(x / 0.05), 0.05 * np.sin(x / 0.05), y], axis=1),
}


def _stretch(surface, learned):
    ends = surface.edges
    on_map = np.linalg.norm(learned.points[ends[:, 0]] - learned.points[ends[:, 1]], axis=1)
    return on_map / np.linalg.norm(surface.vertices[ends[:, 0]] - surface.vertices[ends[:, 1]], axis=1)


@pytest.mark.parametrize("shape", SHAPES)
def test_edges_make_everything_a_tenth_too_long(shape):
    surface = _lattice(SHAPES[shape])
    stretch = _stretch(surface, isomap(surface, distances="edges"))
    assert 1.08 < stretch.mean() < 1.12


@pytest.mark.parametrize("shape", SHAPES)
def test_exact_distances_do_not(shape):
    surface = _lattice(SHAPES[shape])
    learned = isomap(surface)
    stretch = _stretch(surface, learned)
    assert abs(stretch.mean() - 1) < 0.003
    assert np.sqrt(((stretch - 1) ** 2).mean()) < 0.008
    assert learned.stress < 0.003
    assert (learned.method, learned.findings) == ("isomap-exact", ())


def test_some_vertices_are_placed_like_all():
    surface = sheet(6, 4)
    some = np.array([0, 3, 17, 30])
    points = isomap(surface, vertices=some).points
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    truth = surface.vertices[some]
    assert apart == pytest.approx(np.linalg.norm(truth[:, None] - truth[None], axis=-1), abs=1e-9)


def test_what_cannot_be_exact_is_said():
    (note,) = isomap(with_thin_faces()).findings
    assert note.kind == "inexact-distance"


def test_pieces_have_no_distance():
    one = sheet(2, 2)
    two = Mesh(np.concatenate([one.vertices, one.vertices + 1]), np.concatenate([one.faces, one.faces + 9]))
    with pytest.raises(MapError, match="vertices are not connected"):
        isomap(two, distances="edges")
    with pytest.raises(MapError, match="three vertices"):
        isomap(one, vertices=np.array([0, 1]))
