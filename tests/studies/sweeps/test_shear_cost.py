"""The study of shear: its reference against closed forms, and what it measures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tactile_maps.studies.sweeps.shear_cost import ERRORS, LOADING, MODULI_KPA, UNLOADING, cases, drag_ball, measure
from tactile_maps.studies.testbeds.reference_touch import flat_skin
from tactile_maps.tactile.mechanics.coulomb_bed import STUCK
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.contact_model import WITH_SHEAR


@pytest.fixture(scope="module")
def dragged():
    return drag_ball(flat_skin(100, 0), ElasticLayer(), 0.003, -0.004)


def test_stick_region_of_the_reference_follows_the_closed_form(dragged):
    # Under a paraboloid p = p0 (1 - r²/a²) and the traction is min(mu p, c): c = mu p0 (1 - sqrt(1 - Q / (mu P))).
    for share, stuck in zip(LOADING, dragged.stuck, strict=False):
        level = 1 - math.sqrt(1 - share)
        assert stuck == pytest.approx(1 - (level / STUCK) ** 2, abs=0.005)


def test_reference_has_the_tangential_force_of_each_state(dragged):
    np.testing.assert_allclose(dragged.forces.sum(axis=1) / dragged.limit, LOADING + UNLOADING, atol=0.003)
    assert [load.shear[0] / dragged.limit for load in dragged.loads] == pytest.approx(LOADING + UNLOADING)


def test_shear_is_locked_under_a_released_ball(dragged):
    released = dragged.forces[len(LOADING) + UNLOADING.index(0.0)]
    assert np.abs(released).sum() > 0.1 * dragged.limit


def test_times_of_a_small_case_are_those_with_and_without_shear():
    case = {"taxels": 100, "modulus_kpa": 100, "model": "water-fill", "touches": 1, "repeats": 3, "seed": 0}
    (row,) = measure(case)
    assert row["total_percent"] < 1e-9
    assert 0 < row["ms"] <= row["p95_ms"]
    assert row["steps"] == pytest.approx(1e3 * row["ms"] / row["step_us"])
    assert row["shear_steps"] < row["steps"]


@pytest.mark.long
def test_more_taxels_reduce_the_error_of_models_with_an_area():
    requested = {"modulus_kpa": 100, "touches": 3, "repeats": 10, "seed": 0}
    for model in WITH_SHEAR:
        few, many = (measure({**requested, "taxels": count, "model": model})[0] for count in (316, 3162))
        for row in (few, many):
            assert row["total_percent"] < 1e-9
            assert 0 < row["ms"] <= row["p95_ms"]
        if model == "point":
            assert many["traction_percent"] > 50
        else:
            assert many["traction_percent"] < 0.5 * few["traction_percent"] < 2
            assert many["stuck_percent"] < few["stuck_percent"] < 2


def test_every_model_is_measured_with_every_cover():
    full = cases(False, 0)
    assert {(case["model"], case["modulus_kpa"]) for case in full} == {(m, e) for m in WITH_SHEAR for e in MODULI_KPA}
    assert {kind.key for kind in ERRORS} == {"traction_percent", "stuck_percent", "total_percent"}
