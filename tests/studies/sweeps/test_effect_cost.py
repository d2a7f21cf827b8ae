"""The cost of each effect: one at a time, on the least it needs, against a bare step of the same arm."""

from __future__ import annotations

from dataclasses import fields, replace

import mujoco
import pytest

from tactile_maps.scene.effects import EFFECTS, Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.sweeps.effect_cost import ALL_OFF, effect_cases, measure
from tactile_maps.studies.testbeds.pressed_robot import pressed_arm

TINY = {"taxels": 120, "rounds": 8, "seed": 0}


def row(effect, choice):
    case = {"effect": effect, "choice": choice, **TINY}
    (found,) = measure(case)
    return {**case, **found}


@pytest.fixture(scope="module")
def arm():
    return pressed_arm(120)


@pytest.fixture(scope="module")
def rows():
    return [row("none", ""), row("integrator", "implicit"), row("skin", "water-fill"), row("noise", "on")]


def test_every_effect_is_measured_with_only_the_effects_it_needs():
    for one in effect_cases()[1:]:
        names = [field.name for field in fields(Effects)]
        changed = [name for name in names if getattr(one.effects, name) != getattr(one.without, name)]
        if one.effect in names:
            assert set(changed) <= {one.effect}
        else:
            assert changed == ["sensor"]
            assert getattr(one.effects.sensor, one.effect) is not None


def test_every_choice_of_every_effect_except_the_time_step_is_measured():
    found = {one.effect for one in effect_cases()}
    assert found == {"none", *EFFECTS} - {"timestep", "dynamics"}
    assert {one.choice for one in effect_cases() if one.effect == "skin"} == set(EFFECTS["skin"].choices) - {"off"}
    assert {one.choice for one in effect_cases() if one.effect == "integrator"} == set(EFFECTS["integrator"].choices)
    assert len({(one.effect, one.choice) for one in effect_cases()}) == len(effect_cases())


@pytest.mark.long
def test_all_effects_off_cost_nothing(arm):
    model = assemble(arm.robot, arm.skin, ALL_OFF, objects=(arm.probe,))
    assert (model.npair, model.ngeom, model.nsensor, model.nv) == (0, 0, 0, len(arm.robot.joints))
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    simulation = Simulation(arm.robot, arm.skin, ALL_OFF, objects=(arm.probe,))
    assert simulation.readings == ()


@pytest.mark.long
def test_measured_contacts_are_pressed(arm):
    """The rows of contacts and skins measure a skin in touch, not an idle one."""
    probed = replace(ALL_OFF, contact="probe", skin="water-fill")
    simulation = Simulation(arm.robot, arm.skin, probed, objects=(arm.probe,))
    simulation.step(1500, arm.command)
    assert float(simulation.sense() @ arm.skin.areas) == pytest.approx(10.0, rel=0.05)


@pytest.mark.long
def test_rows_carry_effect_and_ratio(rows):
    for found in rows:
        assert found["ratio"] > 0.8
        assert found["ratio_p95"] >= found["ratio"]
        assert found["step_us"] > 0.8 * found["bare_us"] > 0
    none, implicit, skin, _ = rows
    assert abs(none["cost"]) < 0.3
    assert implicit["cost"] > 0, "derivatives and another factorization"
    assert skin["ratio"] > none["ratio"]
