"""A polygon cut at the patches' borders."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.control.path_cut import cut_at_borders
from app.maps.glue import Gluing
from tests.touch import arm
from tests.unit.control.plates import two_plates

MAP = two_plates()
GLUING = Gluing(MAP)


def cut(*points):
    return cut_at_borders(np.array(points, dtype=float), GLUING)


def test_what_stays_inside_is_one_run():
    [run] = cut((0.01, 0.01), (0.05, 0.09), (0.09, 0.01))
    assert run.patch == 0
    assert run.points[[0, -1]] == pytest.approx(np.array([[0.01, 0.01], [0.09, 0.01]]))


def test_from_one_patch_over_the_ground_into_the_other_and_out():
    runs = cut((0.05, 0.05), (0.30, 0.05))
    assert [run.patch for run in runs] == [0, -1, 1, -1]
    assert [run.points[0][0] for run in runs] == pytest.approx([0.05, 0.10, 0.12, 0.22])
    assert runs[-1].points[-1] == pytest.approx([0.30, 0.05])


def test_out_and_in_by_the_same_border_within_one_side_and_another():
    assert [run.patch for run in cut((0.05, 0.05), (0.05, -0.01), (0.06, -0.01), (0.06, 0.05))] == [0, -1, 0]


def test_a_point_alone_has_no_runs():
    assert cut((0.05, 0.05)) == ()
    assert cut_at_borders(np.array([[0.05, 0.05], [0.05, 0.05 + 1e-10]]), GLUING) == ()


def test_nothing_on_the_skin_is_one_run_outside():
    assert [run.patch for run in cut((9.0, 9.0), (9.1, 9.0))] == [-1]


@pytest.mark.parametrize("seed", range(6))
def test_runs_are_the_polygon_and_each_is_where_it_says(seed):
    """Walks of 40 sides all over the map of our arm, which is cut open by seams."""
    map_ = arm().map
    low, high = map_.bounds
    points = np.random.default_rng(seed).uniform(low - 0.05, high + 0.05, (40, 2))
    runs = cut_at_borders(points, Gluing(map_))
    assert len(runs) > 20, "it must come in and leave"
    length = sum(np.linalg.norm(np.diff(run.points, axis=0), axis=1).sum() for run in runs)
    assert length == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    for before, after in pairwise(runs):
        assert before.points[-1] == pytest.approx(after.points[0])
        assert before.patch != after.patch
    for run in runs:
        shares = np.linspace(0.01, 0.99, 9)[:, None]
        for start, end in zip(run.points[:-1], run.points[1:], strict=True):
            assert set(map_.to_body_many(start + shares * (end - start))[0]) == {run.patch}
