"""The study of contacts: which cases it has, and how a row is judged."""

from __future__ import annotations

from itertools import product

import pytest

from tactile_maps.studies.stages.simulation import INTEGRATORS
from tactile_maps.studies.sweeps.contact import (
    CHECKS,
    EXCEPTIONS,
    MODELS,
    MOTIONS,
    RATIOS,
    STEPS_MS,
    STUDY,
    TOLERANCES,
    cases,
    exception_of,
    figures,
    measure,
)
from tactile_maps.studies.testbeds.contact_bench import BODIES, SKINS

CASES = cases(False, 0)


def case(check, **expected):
    return next(
        one for one in CASES if one["check"] == check and all(one[key] == value for key, value in expected.items())
    )


def test_cases_cover_the_table():
    assert STUDY.name == "contact"
    assert figures([]) == []
    assert {one["check"] for one in CASES} == set(CHECKS)
    rest = {(one["skin"], one["shape"], one["physics"]) for one in CASES if one["check"] == "rest"}
    assert set(product(SKINS, BODIES, ("solver", "foundation", "depth"))) <= rest
    motions = {(one["integrator"], one["timestep_ms"], one["motion"]) for one in CASES if one["check"] == "rest"}
    assert set(product(INTEGRATORS, STEPS_MS, MOTIONS)) <= motions
    for pair in (("integrator", "ratio"), ("timestep_ms", "ratio"), ("motion", "ratio")):
        values = {"integrator": INTEGRATORS, "timestep_ms": STEPS_MS, "motion": MOTIONS}[pair[0]]
        found = {tuple(one[key] for key in pair) for one in CASES if one["check"] == "rest"}
        assert set(product(values, RATIOS)) <= found
    impacts = {(one["integrator"], one["timestep_ms"], one["ratio"]) for one in CASES if one["check"] == "impact"}
    assert set(product(INTEGRATORS, STEPS_MS, RATIOS)) <= impacts


def test_quick_cases_are_few_and_a_subset_of_all():
    assert 10 < len(cases(True, 0)) < 40
    assert all(one in CASES for one in cases(True, 0))


@pytest.mark.long
def test_row_has_every_quantity_and_a_verdict():
    requested = case("rest", skin="flat", shape="mesh", physics="solver", motion="free", timestep_ms=4.0)
    rows = {row["model"]: row for row in measure(requested)}
    assert set(rows) == {"point", "water-fill", "punch", "half-space"}
    assert set(TOLERANCES) < set(rows["punch"])
    assert rows["punch"]["verdict"] == "ok"
    assert rows["punch"]["note"] == ""
    assert abs(rows["punch"]["weight_percent"]) < 0.1
    # A leaning block bears on one side: a bed of springs without tilt cannot show that.
    assert rows["water-fill"]["verdict"] == "outside"
    assert rows["water-fill"]["centre_mm"] > TOLERANCES["centre_mm"]
    assert exception_of({**requested, **rows["water-fill"]}).reason in rows["water-fill"]["note"]


def test_quantity_beyond_its_tolerance_is_outside_with_the_known_reason():
    (row,) = measure(case("rest", skin="flat", shape="box on corner", physics="depth", motion="guided"))
    assert (row["verdict"], row["model"]) == ("outside", "depth")
    assert row["note"].startswith("centre_mm nan: ")


def test_unstable_settings_are_rejected_with_a_remedy():
    requested = case("rest", motion="scripted", integrator="euler", timestep_ms=4.0, physics="solver")
    rows = measure(requested)
    assert {row["verdict"] for row in rows} == {"rejected"}
    assert "discrete" in rows[0]["note"]
    (row,) = measure(case("impact", physics="foundation", integrator="implicit", timestep_ms=4.0))
    assert row["verdict"] == "rejected"
    assert "Use a time step of at most" in row["note"]
    assert all(row[column] is None for column in TOLERANCES)


def test_foundation_with_friction_is_rejected():
    (row,) = measure(case("stick", physics="foundation"))
    assert (row["verdict"], row["model"]) == ("rejected", "foundation")


@pytest.mark.parametrize("known", EXCEPTIONS, ids=lambda known: known.reason[:30])
def test_exceptions_cover_rows_that_exist(known):
    assert any(known.covers({**one, "model": model, "verdict": "outside"}) for one in CASES for model in MODELS), known


def test_row_without_an_exception_fails():
    row = {**case("rest"), "model": "punch"}
    assert exception_of(row) is None
