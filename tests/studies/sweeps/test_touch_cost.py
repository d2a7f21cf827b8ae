"""The study of contact models, those within the physics among them."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from tactile_maps.scene.effects import SkinModel
from tactile_maps.studies.sweeps.touch_cost import (
    CONTACTS_MM,
    ERRORS,
    MISPLACED_MM,
    PHYSICS,
    TITLES,
    cases,
    figures,
    hold_ball,
    measure,
    step_and_sense,
)
from tactile_maps.studies.testbeds.reference_touch import INDENTATION, REFERENCE_SKINS, ball_radius
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS


def ball(tested, contact=0.01):
    at, normal = tested.place(0.003, -0.004)
    return sphere_load(tested.dense.link, at, normal, 1.0, ball_radius(contact), depth=INDENTATION)


@pytest.mark.long
@pytest.mark.parametrize("name", REFERENCE_SKINS)
def test_depth_is_that_of_each_taxel_inside_the_ball(name):
    tested = REFERENCE_SKINS[name](1000, 0)
    load = ball(tested)
    inside = -load.shape.distance(load.pose.inverse.points(tested.skin.patches[0].taxels.positions))
    expected = ElasticLayer().foundation * np.maximum(inside, 0)
    assert (expected > 0).sum() >= 3
    np.testing.assert_allclose(step_and_sense(hold_ball(tested, "depth", load)), expected, atol=0.02 * expected.max())


@pytest.mark.long
@pytest.mark.parametrize("name", REFERENCE_SKINS)
def test_foundation_is_the_sum_over_the_points_in_the_ball(name):
    tested = REFERENCE_SKINS[name](316, 0)
    load = ball(tested)
    points = tested.skin.patches[0].taxels.quadrature
    radial = load.pose.inverse.points(points.positions)
    across = -np.einsum("ij,ij->i", radial, load.pose.inverse.directions(points.normals))
    inside = np.maximum(-load.shape.distance(radial), 0) * across / np.linalg.norm(radial, axis=1)
    inside[points.normals @ load.normal < 0] = 0
    expected = ElasticLayer().foundation * np.bincount(points.taxel, inside * points.areas) / tested.skin.areas
    assert (expected > 0).sum() >= 3
    np.testing.assert_allclose(step_and_sense(hold_ball(tested, "foundation", load)), expected, rtol=2e-5, atol=1e-2)


@pytest.mark.long
@pytest.mark.parametrize("model", PHYSICS)
def test_robot_does_not_move_during_the_measurement(model):
    tested = REFERENCE_SKINS["flat"](100, 0)
    simulation = hold_ball(tested, model, ball(tested, 0.03))
    first = step_and_sense(simulation)
    assert first.any()
    for _ in range(20):
        np.testing.assert_array_equal(step_and_sense(simulation), first)


@pytest.fixture(scope="module")
def rows():
    requested = [case for case in cases(True, 0) if case["taxels"] == 1000 and case["skin"] == "flat"]
    return [{**case, **row} for case in requested for row in measure(case | {"repeats": 1})]


def of(rows, model, contact, key, *, misplaced=0):
    (found,) = [
        row[key]
        for row in rows
        if (row["model"], row["contact_mm"], row["misplaced_mm"]) == (model, contact, misplaced)
    ]
    return found


@pytest.mark.long
def test_every_model_is_measured_under_every_contact(rows):
    assert {(row["model"], row["contact_mm"]) for row in rows} == {(m, c) for m in TITLES for c in CONTACTS_MM}
    assert set(TITLES) == set(get_args(SkinModel)) - {"off"}
    for row in rows:
        assert all(np.isfinite(row[kind.key]) for kind in ERRORS)
        assert 0 < row["ms"] <= row["p95_ms"]
        assert row["steps"] == pytest.approx(1e3 * row["ms"] / row["step_us"])


@pytest.mark.long
def test_no_model_loses_force(rows):
    assert max(row["force_percent"] for row in rows if row["model"] in CONTACT_MODELS) < 1e-7


@pytest.mark.long
def test_solver_contacts_miss_taxels_between_their_points(rows):
    for contact in CONTACTS_MM:
        deep, bed = (of(rows, model, contact, "force_percent") for model in ("depth", "foundation"))
        assert deep > 3 * bed > 0, "a point a taxel, or eight"
        assert of(rows, "depth", contact, "surface_percent") > of(rows, "water-fill", contact, "surface_percent")


def test_undetected_touches_are_counted():
    case = next(case for case in cases(True, 0) if (case["skin"], case["model"]) == ("flat", "depth"))
    (row,) = measure(case | {"taxels": 30, "touches": 2, "repeats": 1})
    assert row["missed_percent"] > 0
    assert row["surface_percent"] > 50


@pytest.mark.long
@pytest.mark.parametrize("contact", CONTACTS_MM)
def test_more_detailed_models_have_smaller_errors(rows, contact):
    surface = {model: of(rows, model, contact, "surface_percent") for model in CONTACT_MODELS}
    felt = {model: of(rows, model, contact, "depth_percent") for model in CONTACT_MODELS}
    assert surface["point"] > 3 * surface["water-fill"], "it knows no shape"
    assert surface["water-fill"] < surface["half-space"], "which is not about the surface"
    assert felt["half-space"] < felt["water-fill"], "which knows no depth"
    assert felt["half-space"] < 10


@pytest.mark.long
def test_only_the_punch_model_locates_contacts_with_a_wrong_body(rows):
    for contact in (10, 30):
        assert of(rows, "water-fill", contact, "place_mm", misplaced=1) > 0.5
        assert of(rows, "punch", contact, "place_mm", misplaced=1) < 0.1


@pytest.mark.long
def test_figures_have_a_panel_per_contact_and_a_curve_per_model(rows):
    drawn = figures(rows)
    assert len(drawn) == len(ERRORS) * len(MISPLACED_MM)
    assert set(drawn[0].panels[0].curves) == set(TITLES.values())
    assert set(PHYSICS.values()).isdisjoint(drawn[-1].panels[0].curves), "the simulator's contacts are never misplaced"
    assert len({figure.title for figure in drawn}) == len(drawn)
    for figure in drawn:
        assert len(figure.panels) == len(CONTACTS_MM)
        for panel in figure.panels:
            assert set(panel.curves) >= {entry.title for entry in CONTACT_MODELS.values()}
            assert all(len(points) == 1 for points in panel.curves.values())
