"""What is off leaves no element, no buffer and no call behind, and what is left obeys its closed form."""

from __future__ import annotations

from collections import Counter

import mujoco
import numpy as np
import pytest

from app.scene.effects import Effects
from app.simulation.assemble import assemble
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokePressed, PokeReleased
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from tests.things import every_kind, thing
from tests.touch import BAR_INERTIA, arm, bar, bar_skin, hold, no_command

BARE = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
SIZES = [name for name in dir(mujoco.MjModel) if name.startswith("n") and name not in ("names", "numeric_adr",
         "numeric_data", "numeric_size", "name_actuatoradr", "nbuffer")]  # fmt: skip


def sizes(model: mujoco.MjModel) -> dict[str, int]:
    return {name: int(value) for name in SIZES if isinstance(value := getattr(model, name), int)}


@pytest.mark.parametrize(
    ("feature", "without"),
    [
        (Effects(contact="off"), Effects(contact="off", friction=True)),
        (Effects(skin="water-fill"), Effects(skin="off")),
        (Effects(skin="water-fill"), Effects(skin="depth")),
        (Effects(skin="water-fill"), Effects(skin="foundation")),
        (Effects(fingers=True), Effects(fingers=False)),
        (Effects(), Effects(sensor=SensorEffects(noise=Noise()))),
    ],
)
def test_what_has_nothing_to_act_on_leaves_the_model_as_it_is(feature, without):
    models = [assemble(arm().robot, arm().skin, effects, objects=every_kind()) for effects in (feature, without)]
    assert sizes(models[0]) == sizes(models[1])


@pytest.mark.parametrize("contact", ["off", "probe", "environment", "self", "all"])
def test_objects_out_of_reach_of_the_effect_leave_the_model_as_if_they_did_not_exist(contact):
    kinds = {"off": (), "self": (), "probe": ("probe",)}.get(contact)
    present = tuple(t for t in every_kind() if kinds is None or t.spec.kind in kinds)
    effects = Effects(contact=contact)
    with_all = assemble(arm().robot, arm().skin, effects, objects=every_kind())
    assert sizes(with_all) == sizes(assemble(arm().robot, arm().skin, effects, objects=present))


@pytest.fixture
def calls(monkeypatch) -> Counter[str]:
    """Counts every call of a MuJoCo function."""
    counted: Counter[str] = Counter()

    def counting(name, function):
        def call(*args, **kwargs):
            counted[name] += 1
            return function(*args, **kwargs)

        return call

    for name in dir(mujoco):
        if name.startswith(("mj_", "mju_")):
            monkeypatch.setattr(mujoco, name, counting(name, getattr(mujoco, name)))
    return counted


def run(effects: Effects, calls: Counter[str], *, things=(), poke: bool = False) -> Counter[str]:
    """Calls of one step of five under an old command, and one reading."""
    robot = bar()
    simulation, command = Simulation(robot, bar_skin(), effects, objects=things), hold(robot, 5.0, 0.5)
    simulation.step(5, command)
    if poke:
        simulation.apply(PokePressed(1, bar_skin().taxel_point(5), Finger(speed=0.0)))
    calls.clear()
    simulation.step(5, command)
    simulation.sense()
    return Counter(calls)


def test_all_off_is_one_call_of_mujoco_for_all_steps(calls):
    assert run(BARE, calls) == {"mj_step": 1, "mj_getState": 1, "mju_dot": 1}


def test_idle_fingers_and_a_skin_that_nothing_touches_add_no_call(calls):
    assert run(Effects(), calls) == run(BARE, calls)


def test_objects_that_take_no_part_add_no_call(calls):
    assert run(Effects(), calls, things=every_kind()) == run(BARE, calls)


def test_contact_is_read_once_a_reading_and_adds_nothing_to_the_steps(calls):
    made = run(Effects(contact="environment"), calls, things=(thing("box", at=(5.0, 0.0, 0.0)),))
    assert made == {"mj_step": 1, "mj_getState": 1, "mju_dot": 1, "mj_kinematics": 1, "mj_comPos": 1}


def test_what_acts_between_steps_is_called_between_steps(calls):
    made = run(Effects(), calls, poke=True)
    assert made["mj_step1"] == made["mj_step2"] == 5
    assert made["mj_step"] == 0
    walker = thing("probe", path=((0.0, 5.0, 0.0, 0.0), (1.0, 6.0, 0.0, 0.0)))
    assert run(Effects(contact="probe"), calls, things=(walker,))["mj_step1"] == 5
    assert run(Effects(contact="probe"), calls, things=(thing("probe", at=(5.0, 0.0, 0.0)),))["mj_step1"] == 0


def test_a_lifted_finger_leaves_no_call(calls):
    robot = bar()
    simulation, command = Simulation(robot, bar_skin(), Effects()), hold(robot, 5.0, 0.5)
    simulation.apply(PokePressed(1, bar_skin().taxel_point(5)))
    simulation.step(5, command)
    simulation.apply(PokeReleased(1))
    simulation.step(5, command)
    calls.clear()
    simulation.step(5, command)
    assert calls == {"mj_step": 1, "mj_getState": 1, "mju_dot": 1}


def test_gains_are_written_when_the_command_changes_and_only_then():
    robot = bar()
    simulation, command = Simulation(robot, bar_skin(), BARE), hold(robot, 5.0, 0.5)
    simulation.step(1, command)
    simulation._model.actuator_gainprm[0, 0] = 7.0
    simulation.step(1, command)
    assert simulation._model.actuator_gainprm[0, 0] == 7.0
    simulation.step(1, hold(robot, 5.0, 0.5))
    assert simulation._model.actuator_gainprm[0, 0] == 5.0


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit", "rk4"])
def test_many_steps_in_one_call_are_the_same_steps(integrator):
    effects = Effects(gravity="on", integrator=integrator)
    one, many = Simulation(arm().robot, arm().skin, effects), Simulation(arm().robot, arm().skin, effects)
    command = hold(arm().robot, 3.0, 0.5)
    many.step(60, command)
    for _ in range(60):
        one.step(1, command)
    assert np.array_equal(one.state(), many.state())


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit", "rk4"])
def test_a_finger_that_pushes_nothing_changes_no_step(integrator):
    effects = Effects(gravity="on", integrator=integrator)
    free, touched = Simulation(bar(), bar_skin(), effects), Simulation(bar(), bar_skin(), effects)
    touched.apply(PokePressed(1, bar_skin().taxel_point(5), Finger(max_force=0.0)))
    for simulation in (free, touched):
        simulation.step(200, no_command(bar()))
    assert np.array_equal(free.posture, touched.posture)


def test_a_pendulum_swings_as_the_closed_form_says():
    robot = bar()
    effects = Effects(gravity="on", contact="off", joint_limits=False, fingers=False, skin="off", timestep=1e-4,
                      integrator="rk4")  # fmt: skip
    simulation = Simulation(robot, bar_skin(), effects)
    simulation._data.qpos[:] = 0.5 * np.pi - 0.01  # hanging down is +90 degrees about +y
    omega = np.sqrt(9.81 * 0.2 / BAR_INERTIA)
    simulation.step(20000, no_command(robot))
    assert simulation.posture[0] - 0.5 * np.pi == pytest.approx(-0.01 * np.cos(omega * 2.0), abs=2e-5)


def test_without_anything_a_bar_turns_on_for_ever():
    simulation = Simulation(bar(), bar_skin(), BARE)
    simulation._data.qvel[:] = 2.0
    simulation.step(1000, no_command(bar()))
    assert simulation.posture[0] == pytest.approx(2.0, rel=1e-12)
