"""Seams: as drawn, as proposed, around what is important, and what each further one gains."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.cut import SeamPlan, cut_to_disk, planned_cuts, shortest_edge_path
from tactile_maps.flattening.flatten import flatten
from tests.support.surfaces import cap, frustum, sheet, sphere


def _pairs(edges):
    return {tuple(sorted(edge)) for edge in np.asarray(edges).tolist()}


@pytest.fixture
def tube():
    return frustum(length=0.2, around=24, along=16)


def test_drawn_seam_is_the_seam_of_a_tube(tube):
    drawn = shortest_edge_path(tube, [5, 5 + 16 * 24])
    assert len(drawn) == 16
    assert _pairs(cut_to_disk(tube, drawn=drawn).seams) == _pairs(drawn)


def test_drawn_slit_inside_is_joined_to_the_border():
    plate = sheet(12, 8)
    middle = [6 * 9 + 2, 6 * 9 + 5]
    drawn = shortest_edge_path(plate, middle)
    cut = cut_to_disk(plate, drawn=drawn)
    assert _pairs(drawn) < _pairs(cut.seams)
    np.testing.assert_array_equal(cut.vertex_of[cut.faces], plate.faces)


def test_seam_that_separates_the_patch_is_rejected():
    plate = sheet(12, 8)
    with pytest.raises(MapError, match="in two"):
        cut_to_disk(plate, drawn=shortest_edge_path(plate, [6 * 9, 6 * 9 + 8]))


def test_seam_off_the_edges_is_rejected(tube):
    with pytest.raises(MapError, match=r"leaves the edges.*vertices 0 and 100"):
        cut_to_disk(tube, drawn=np.array([[0, 100]]))


def test_seam_goes_around_an_area_of_interest(tube):
    straight = cut_to_disk(tube)
    importance = np.zeros(len(tube.vertices))
    near = np.unique(straight.seams)
    middle = near[np.abs(tube.vertices[near, 2] - 0.1) < 0.03]
    importance[np.linalg.norm(tube.vertices[:, None] - tube.vertices[middle], axis=2).min(axis=1) < 0.01] = 50.0
    around = cut_to_disk(tube, importance=importance)
    assert importance[np.unique(straight.seams)].any()
    assert not importance[np.unique(around.seams)].any()


def test_ball_is_opened_outside_the_area_of_interest():
    ball = sphere(radius=0.05)
    importance = np.where(ball.vertices[:, 2] > 0, 10.0, 0.0)
    seams = np.unique(cut_to_disk(ball, importance=importance).seams)
    assert (importance[seams] > 0).mean() < 0.2


def test_each_extra_seam_reduces_the_distortion_of_a_nearly_closed_body():
    body = cap(2.8, rings=10)
    charts = [flatten(body, seams=SeamPlan(extra=extra)) for extra in range(4)]
    lengths = [len(chart.seams) for chart in charts]
    assert lengths[0] == 0
    assert lengths == sorted(set(lengths))
    energies = [chart.energies[-1] for chart in charts]
    assert energies == sorted(energies, reverse=True)
    assert energies[0] - energies[1] > 1


def test_path_visits_the_places_in_order(tube):
    whole = shortest_edge_path(tube, [0, 4, 28])
    assert _pairs(whole) == _pairs(shortest_edge_path(tube, [0, 4])) | _pairs(shortest_edge_path(tube, [4, 28]))


def test_invalid_seam_plans_are_rejected(tube):
    with pytest.raises(MapError, match="two ends"):
        shortest_edge_path(tube, [3])
    with pytest.raises(MapError, match="out of range"):
        SeamPlan(extra=-1)
    with pytest.raises(MapError, match="importance"):
        SeamPlan(importance=np.array([np.nan]))
    with pytest.raises(MapError, match="another surface"):
        next(planned_cuts(tube, SeamPlan(importance=np.ones(3))))
