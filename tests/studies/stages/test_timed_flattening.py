"""Patches flattened by the clock: rounds add up over patches, and the errors are those that theory knows."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.studies.stages.timed_flattening import (
    chart_errors,
    chosen_patches,
    distortion_percent,
    flatten_timed,
    seam_plan_fingerprint,
)
from tactile_maps.studies.study.work_precision import PatchRecipe, Subject


def laid(subject, **how):
    patches = chosen_patches(subject)
    return patches, flatten_timed(patches, [PatchRecipe(**how) for _ in patches])


def test_tube_is_flattened_without_error(tube):
    patches, made = laid(tube, method="symmetric-dirichlet")
    errors = chart_errors(patches, made.charts, made.rounds[-1])
    assert errors["distortion"] < 0.1
    assert errors["angles"] < 0.1
    assert 0 < errors["torn"] < 50, "its seam takes some neighbours apart"


def test_conformal_map_of_a_hemisphere_keeps_angles_and_not_lengths(hemisphere):
    balanced, conformal = (
        chart_errors(*(found := laid(hemisphere, method=method))[:1], found[1].charts, found[1].rounds[-1])
        for method in ("symmetric-dirichlet", "lscm")
    )
    assert conformal["angles"] < 0.5 * balanced["angles"]
    assert conformal["distortion"] > 1.2 * balanced["distortion"]
    assert balanced["torn"] == 0, "an open cup needs no seam"


@pytest.mark.long
def test_rounds_of_several_patches_add_up(bodies, tube, hemisphere):
    how = {"method": "symmetric-dirichlet"}
    both = laid(Subject.of(bodies), **how)[1]
    single = [laid(subject, **how)[1] for subject in (tube, hemisphere)]
    assert len(both.rounds) == len(both.seconds) == max(len(one.rounds) for one in single)
    areas = [patch.surface.area for patch in bodies.skin.patches]
    assert both.rounds[-1] == pytest.approx(np.average([one.rounds[-1] for one in single], weights=areas))
    assert len(both.charts) == 2


def test_corrections_are_noted(hemisphere):
    assert "flips triangles" in laid(hemisphere, method="unroll")[1].note
    assert laid(hemisphere, method="tutte")[1].note == ""


@pytest.mark.parametrize("stretch", [1.0, 1.05, 1.5, 4.0])
def test_distortion_is_the_uniform_stretch_with_the_same_energy(stretch):
    assert distortion_percent(2 * (stretch**2 + stretch**-2)) == pytest.approx(100 * (stretch - 1), abs=1e-6)


def test_stamp_includes_drawn_seams_and_areas_of_interest():
    plans = [SeamPlan(), SeamPlan(drawn=np.array([[0, 1]])), SeamPlan(importance=np.ones(3))]
    assert len({seam_plan_fingerprint(plan) for plan in plans}) == 3
    assert seam_plan_fingerprint(SeamPlan(2)) == seam_plan_fingerprint(SeamPlan()), "how many more is what is tried"


def test_seconds_of_several_patches_add_up(bodies, tube, hemisphere):
    def total(subject) -> float:
        ticks = itertools.count()  # a clock that advances at each call: one run is enough
        patches = chosen_patches(subject)
        made = flatten_timed(
            patches, [PatchRecipe("symmetric-dirichlet") for _ in patches], clock=lambda: float(next(ticks))
        )
        assert list(made.seconds) == sorted(made.seconds)
        return made.seconds[-1]

    assert total(Subject.of(bodies)) == total(tube) + total(hemisphere)


def test_rejected_seam_does_not_count_as_the_result(hemisphere, monkeypatch):
    monkeypatch.setattr("tactile_maps.flattening.flatten.WORTH_A_SEAM", 4.1)
    monkeypatch.setattr("tactile_maps.flattening.flatten._WORTH_KEEPING", 0.99)
    _, made = laid(hemisphere, method="symmetric-dirichlet")
    assert made.rounds[-1] == made.charts[0].energies[-1]
    assert min(made.rounds) < made.rounds[-1] - 0.01, "with the seam it was less distorted"
