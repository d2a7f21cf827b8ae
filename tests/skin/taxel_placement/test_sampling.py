from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.skin.taxel_placement.sampling import (
    face_graph,
    farthest_points,
    geodesic_voronoi,
    place_evenly,
    straighten_cells,
    taxels_at_points,
)
from tests.hard_cases.meshes import HARD_MESHES

BALL = wrap_mesh(HARD_MESHES["sphere"], thickness=0.01, voxel=0.008).surface
CENTRES = BALL.face_centres


@pytest.mark.parametrize("count", [0, len(BALL.faces) + 1])
def test_more_taxels_than_faces_are_rejected(count):
    with pytest.raises(SkinError, match="too coarse"):
        place_evenly(BALL, count)


def test_cells_end_at_their_reach():
    owner = geodesic_voronoi(face_graph(BALL), np.array([0]), reach=0.03)
    away = np.linalg.norm(CENTRES - CENTRES[0], axis=1)
    assert (away[owner == 0] < 0.03).all()
    assert (owner[away > 0.03] == -1).all()
    assert (owner[away < 0.015] == 0).all()


def test_relaxation_brings_cells_closer_to_their_taxels_and_empties_none():
    seeds = np.random.default_rng(0).choice(len(CENTRES), 40, replace=False)
    rough = geodesic_voronoi(face_graph(BALL), seeds)
    straight = straighten_cells(BALL, CENTRES[seeds], rough, seeds)
    assert (straight != rough).any()
    assert set(straight) == set(range(40))

    def away(owner):
        return float(np.linalg.norm(CENTRES - CENTRES[seeds][owner], axis=1).mean())

    assert away(straight) < away(rough)


def test_faces_without_an_owner_belong_to_no_cell():
    owner = np.where(CENTRES[:, 2] > 0, 0, -1)
    taxels = taxels_at_points(BALL, np.array([[0, 0, 0.2]]), owner)
    assert taxels.areas == pytest.approx([BALL.face_areas[owner == 0].sum()])
    assert taxels.quadrature.positions[:, 2].min() > 0
    assert taxels.positions[0, 2] == pytest.approx(0.11, abs=1e-3)
    assert taxels.normals[0] == pytest.approx([0, 0, 1], abs=0.05)


def test_each_next_point_is_the_farthest_from_all_before():
    line = np.array([[0.0], [1.0], [4.0], [10.0]])
    assert farthest_points(line, 4, np.array([0])).tolist() == [0, 3, 2, 1]
    assert farthest_points(line, 3, np.array([1, 2])).tolist() == [1, 2, 3]
    assert farthest_points(line, 2, np.array([0]), allowed=np.array([True, True, True, False])).tolist() == [0, 2]
    assert farthest_points(line, 2, np.array([0]), weight=np.array([1.0, 200.0, 1.0, 1.0])).tolist() == [0, 1]
