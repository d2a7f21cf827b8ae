"""The touch experiment measures what it says: every model, errors ordered as theory says, times in steps."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from app.experiments.touch_cost import (
    CONTACTS_MM,
    ERRORS,
    EXPERIMENT,
    MISPLACED_MM,
    TITLES,
    bare_step,
    cases,
    figures,
    measure,
)
from app.experiments.touch_physics import PHYSICS
from app.experiments.touch_skins import GROUNDS
from app.scene.effects import SkinModel
from app.touch.models.table import MODELS


@pytest.fixture(scope="module")
def rows():
    asked = [case for case in cases(True, 0) if case["taxels"] == 1000 and case["skin"] == "flat"]
    return [{**case, **row} for case in asked for row in measure(case | {"repeats": 1})]


def of(rows, model, contact, key, *, misplaced=0):
    (found,) = [
        row[key]
        for row in rows
        if (row["model"], row["contact_mm"], row["misplaced_mm"]) == (model, contact, misplaced)
    ]
    return found


def test_every_model_is_measured_under_every_contact(rows):
    assert {(row["model"], row["contact_mm"]) for row in rows} == {(m, c) for m in TITLES for c in CONTACTS_MM}
    assert set(TITLES) == set(get_args(SkinModel)) - {"off"}
    for row in rows:
        assert all(np.isfinite(row[key]) for key in ERRORS)
        assert 0 < row["ms"] <= row["p95_ms"]
        assert row["steps"] == pytest.approx(1e3 * row["ms"] / row["step_us"])


def test_no_model_loses_force(rows):
    assert max(row["force_percent"] for row in rows if row["model"] in MODELS) < 1e-7


def test_the_physics_own_lose_what_falls_between_their_points(rows):
    for contact in CONTACTS_MM:
        deep, bed = (of(rows, model, contact, "force_percent") for model in ("depth", "foundation"))
        assert deep > 3 * bed > 0, "a point a taxel, or eight"
        assert of(rows, "depth", contact, "surface_percent") > of(rows, "water-fill", contact, "surface_percent")


def test_a_touch_that_is_not_felt_is_told(rows):
    case = next(case for case in cases(True, 0) if (case["skin"], case["model"]) == ("bent", "depth"))
    (row,) = measure(case | {"taxels": 30, "repeats": 1})
    assert row["missed_percent"] > 0
    assert row["surface_percent"] > 50


@pytest.mark.parametrize("contact", CONTACTS_MM)
def test_errors_are_ordered_by_what_models_know(rows, contact):
    surface = {model: of(rows, model, contact, "surface_percent") for model in MODELS}
    felt = {model: of(rows, model, contact, "felt_percent") for model in MODELS}
    assert surface["point"] > 3 * surface["water-fill"], "it knows no shape"
    assert surface["water-fill"] < surface["half-space"], "which is not about the surface"
    assert felt["half-space"] < felt["water-fill"], "which knows no depth"
    assert felt["half-space"] < 10


def test_a_larger_contact_is_easier(rows):
    for key in ("surface_percent", "felt_percent", "place_mm"):
        errors = [of(rows, "water-fill", contact, key) for contact in CONTACTS_MM]
        assert errors == sorted(errors, reverse=True)


def test_only_punch_places_a_contact_right_whose_body_is_told_wrong(rows):
    for contact in (10, 30):
        assert of(rows, "water-fill", contact, "place_mm", misplaced=1) > 0.5
        assert of(rows, "punch", contact, "place_mm", misplaced=1) < 0.1


def test_the_full_sweep_asks_all_that_must_be_measured():
    every = cases(False, 0)
    assert {case["taxels"] for case in every} >= {100, 1000, 10_000}
    assert {case["contact_mm"] for case in every} == {4, 10, 30}
    assert {case["skin"] for case in every} == set(GROUNDS)
    assert len(every) == len({tuple(case.items()) for case in every})


def test_a_bare_step_takes_microseconds():
    assert 1e-7 < bare_step() < 1e-3


def test_figures_have_a_panel_a_contact_and_a_curve_a_model(rows):
    drawn = figures(rows)
    assert len(drawn) == len(ERRORS) * len(MISPLACED_MM)
    assert set(drawn[0].panels[0].curves) == set(TITLES.values())
    assert set(PHYSICS.values()).isdisjoint(drawn[-1].panels[0].curves), "they are told nothing that could be wrong"
    assert len({figure.title for figure in drawn}) == len(drawn)
    for figure in drawn:
        assert len(figure.panels) == len(CONTACTS_MM)
        for panel in figure.panels:
            assert set(panel.curves) >= {entry.title for entry in MODELS.values()}
            assert all(len(points) == 1 for points in panel.curves.values())


def test_a_case_that_failed_is_left_out_of_the_figures(rows):
    failed = {key: rows[0][key] for key in ("skin", "taxels", "contact_mm", "misplaced_mm", "model")}
    drawn = figures([*rows[1:], {**failed, "problem": "no"}])
    assert sum(len(points) for f in drawn for panel in f.panels for points in panel.curves.values()) == (
        len(ERRORS) * (len(rows) - 1)
    )
    assert EXPERIMENT.name == "touch-cost"
