"""The area around vertices: triangles and outlines say the same, and all vertices make the whole."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.overlays.body_overlays import area_outlines, area_triangles
from tests.support.surfaces import cap, sheet


def flat(mesh):
    return mesh.vertices[:, :2]


def covered(mesh, marked):
    """Area of the triangles, and the one that the outlines enclose, holes taken off."""
    points = flat(mesh)
    corners = points[area_triangles(mesh.faces, marked)].mean(axis=2)
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    loops = area_outlines(mesh.faces, marked, points)
    shoe = [np.sum(loop[:, 0] * np.roll(loop[:, 1], -1) - loop[:, 1] * np.roll(loop[:, 0], -1)) / 2 for loop in loops]
    return 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]), shoe


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("mesh", [sheet(12, 9), cap(1e-3, rings=9)], ids=["sheet", "disk"])
def test_outlines_enclose_the_covered_triangles(mesh, share):
    random = np.random.default_rng(3)
    for _ in range(5):
        marked = random.random(len(mesh.vertices)) < share
        triangles, loops = covered(mesh, marked)
        assert (triangles > 0).all()
        assert sum(loops) == pytest.approx(triangles.sum(), abs=1e-15)


def test_area_of_all_vertices_is_the_whole_mesh_and_of_none_is_empty():
    mesh = sheet(5, 4)
    triangles, loops = covered(mesh, np.ones(len(mesh.vertices), bool))
    assert triangles.sum() == pytest.approx(mesh.area)
    assert len(loops) == 1
    triangles, loops = covered(mesh, np.zeros(len(mesh.vertices), bool))
    assert len(triangles) == len(loops) == 0


def test_hole_is_excluded_from_the_area():
    mesh = sheet(8, 8)
    marked = np.ones(len(mesh.vertices), bool)
    marked[40] = False
    _, loops = covered(mesh, marked)
    assert sorted(np.sign(loops).tolist()) == [-1.0, 1.0]
