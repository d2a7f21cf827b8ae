"""The map study: every method, more rows for iterative ones, and errors that theory knows."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tactile_maps.flattening.methods import METHODS
from tactile_maps.studies.sweeps.map_cost import STUDY, cases, figures, measure


@pytest.fixture(scope="module")
def rows():
    requested = [case for case in cases(True, 0) if case["mesh"] == "hemisphere" or case["method"] != "slim"]
    return [{**case, **row} for case in requested for row in measure(case)]


def last(rows, **expected):
    (found,) = [row for row in rows if row["last"] and all(row[key] == value for key, value in expected.items())]
    return found


@pytest.mark.long
def test_tube_is_unrolled_without_distortion(rows):
    for method in ("symmetric-dirichlet", "unroll", "arap"):
        row = last(rows, mesh="tube", method=method)
        assert row["symmetric_dirichlet"] == pytest.approx(4, abs=1e-3)
        assert row["edge_error"] < 0.01


def test_seconds_grow_and_distortion_falls_from_round_to_round(rows):
    ours = [row for row in rows if row["method"] == "symmetric-dirichlet" and row["mesh"] == "hemisphere"]
    for seams in (0, 1):
        curve = [row for row in ours if row["extra_seams"] == seams]
        assert len(curve) > 3
        assert all(a["ms"] < b["ms"] for a, b in pairwise(curve))
        energies = [row["symmetric_dirichlet"] for row in curve]
        assert all(after < 1.01 * before for before, after in pairwise(energies))
        assert energies[-1] == min(energies) < energies[0] - 0.5
        assert [row["last"] for row in curve] == [False] * (len(curve) - 1) + [True]


def test_seam_lowers_the_distortion_of_a_hemisphere(rows):
    none, one = (
        last(rows, mesh="hemisphere", method="symmetric-dirichlet", extra_seams=seams)["symmetric_dirichlet"]
        for seams in (0, 1)
    )
    assert 4 < one < none < 4.2


def test_balanced_map_is_the_least_distorted_of_the_hemisphere(rows):
    reached = {
        method: last(rows, mesh="hemisphere", method=method, extra_seams=0)["symmetric_dirichlet"] for method in METHODS
    }
    assert reached["symmetric-dirichlet"] <= min(reached.values()) * (1 + 1e-4)


def test_figures_have_a_panel_per_body_and_points_on_curves_of_iterative_methods(rows):
    drawn = figures(rows)
    assert [panel.title for panel in drawn[0].panels] == ["tube", "hemisphere"]
    assert len(drawn[0].panels[1].curves["symmetric-dirichlet"]) > 3
    assert len(drawn[3].panels[1].curves["symmetric-dirichlet"]) == 2, "without and with a seam"
    assert STUDY.name == "map-cost"
