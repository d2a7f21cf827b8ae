"""The table of what is steady, and the warning before a corner of it that is not."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import get_args

import pytest

from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.objects import MIN_MOVING_MASS, ObjectSpec
from tactile_maps.scene.stability import (
    PROBE_MASS,
    StabilityResult,
    equivalent_stiffness,
    measured_stability,
    stability_table,
    stability_warning,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

TOUCHED = Effects(contact="all")
EULER = replace(TOUCHED, integrator="euler", timestep=0.008)


def ball(mass: float) -> ObjectSpec:
    return ObjectSpec("ball", "sphere", size=(0.02,), mass=mass)


def test_table_has_each_combination_once():
    """Every integrator at every step and stiffness, once."""
    keys = [(row.integrator, row.timestep, row.stiffness) for row in stability_table()]
    steps, stiffnesses = ({key[k] for key in keys} for k in (1, 2))
    assert len(keys) == len(set(keys)) == len(get_args(Integrator)) * len(steps) * len(stiffnesses)
    assert (min(steps), max(steps)) == pytest.approx((0.0005, 0.008))
    assert (min(stiffnesses), max(stiffnesses)) == (1e3, 1e7)
    assert {key[0] for key in keys} == set(get_args(Integrator))


@pytest.mark.parametrize("integrator", get_args(Integrator))
def test_steady_rows_remain_steady_with_a_shorter_step_and_a_softer_contact(integrator):
    """The lookup of the next worse row relies on it."""
    steady = {
        (row.timestep, row.stiffness)
        for row in stability_table()
        if (row.integrator, row.verdict) == (integrator, "steady")
    }
    own = [row for row in stability_table() if row.integrator == integrator]
    for step, stiffness in steady:
        assert all((r.timestep, r.stiffness) in steady for r in own if r.timestep <= step and r.stiffness <= stiffness)


def test_only_discrete_is_steady_everywhere():
    verdicts = {name: {r.verdict for r in stability_table() if r.integrator == name} for name in get_args(Integrator)}
    assert [name for name, found in verdicts.items() if found == {"steady"}] == ["discrete"]


def test_worse_row_counts_between_rows():
    found = measured_stability("implicitfast", 0.0011, 1.1e4)
    assert isinstance(found, StabilityResult)
    assert (found.timestep, found.stiffness) == (pytest.approx(0.002), 3e4)
    assert measured_stability("implicitfast", 0.001, 1e4) == measured_stability(
        "implicitfast", 1e-3 * (1 + 1e-12), 1e4 * (1 - 1e-12)
    )
    assert measured_stability("implicitfast", 1e-5, 1.0) == measured_stability("implicitfast", 0.0005, 1e3)


@pytest.mark.parametrize(("step", "stiffness"), [(0.0081, 1e3), (0.001, 1.1e7)])
def test_settings_outside_the_table_are_reported_as_not_measured(step, stiffness):
    assert measured_stability("discrete", step, stiffness) is None
    found = stability_warning(replace(TOUCHED, integrator="discrete", timestep=step), ElasticLayer(stiffness=stiffness))
    assert found is not None
    assert "not been measured" in found.action


@pytest.mark.parametrize("changes", [{"contact": "off"}, {"dynamics": False}, {"skin": "foundation"}])
def test_settings_without_contacts_of_the_solver_are_not_reported(changes):
    assert stability_warning(EULER, ElasticLayer()) is not None
    assert stability_warning(replace(EULER, **changes), ElasticLayer()) is None


@pytest.mark.parametrize(
    ("effects", "layer", "words"),
    [
        (EULER, ElasticLayer(), r"diverges there: choose a time step of 2 ms or the integrator discrete"),
        (
            replace(TOUCHED, timestep=0.004),
            ElasticLayer(stiffness=1e4),
            r"bounces there: .* step of 2 ms or .*discrete",
        ),
        (replace(TOUCHED, timestep=0.0005), ElasticLayer(stiffness=1e7), r"there: choose the integrator discrete$"),
        (replace(EULER, timestep=0.02), ElasticLayer(stiffness=1e8), "measured there: .* softer cover"),
    ],
)
def test_unsteady_settings_name_the_nearest_steady_ones(effects, layer, words):
    found = stability_warning(effects, layer)
    assert found is not None
    assert found.kind == "unstable-time-step"
    assert f"{effects.integrator} at {1e3 * effects.timestep:g} ms" in found.where
    assert re.search(words, found.action)


def test_suggested_settings_are_steady():
    """Whatever a corner advises is steady by the same table."""
    for row in stability_table():
        effects = replace(TOUCHED, integrator=row.integrator, timestep=row.timestep)
        found = stability_warning(effects, ElasticLayer(stiffness=row.stiffness))
        assert (found is None) == (row.verdict == "steady")
        if found is None:
            continue
        step = re.search(r"step of ([\d.]+) ms", found.action)
        if step:
            assert (
                stability_warning(
                    replace(effects, timestep=1e-3 * float(step[1])), ElasticLayer(stiffness=row.stiffness)
                )
                is None
            )
        for other in re.findall(r"discrete|euler|implicit(?:fast)?", found.action.split("integrator")[-1]):
            assert stability_warning(replace(effects, integrator=other), ElasticLayer(stiffness=row.stiffness)) is None


def test_light_objects_need_shorter_steps():
    """Stiffness over mass is what counts: 2 g at 2e4 N/m are as unsteady as the table's probe at 1e6."""
    assert equivalent_stiffness(ElasticLayer(stiffness=2e4), [ball(0.002)]) == pytest.approx(1e6)
    assert stability_warning(TOUCHED, ElasticLayer(stiffness=2e4), objects=[ball(0.002)]) is not None
    assert stability_warning(TOUCHED, ElasticLayer(stiffness=2e4), objects=[ball(1.0)]) is None


def test_heavy_and_fixed_objects_count_as_the_probe():
    wall = ObjectSpec("wall", "box", size=(1.0, 1.0, 1.0))
    probe = ObjectSpec("probe", "probe", size=(0.01,), mass=0.001)
    assert equivalent_stiffness(ElasticLayer(stiffness=1e4), []) == 1e4
    assert equivalent_stiffness(ElasticLayer(stiffness=1e4), [wall, ball(50.0)]) == 1e4
    assert equivalent_stiffness(ElasticLayer(stiffness=1e4), [wall, probe]) == pytest.approx(
        1e4 * PROBE_MASS / MIN_MOVING_MASS
    )
