"""The physics of a scene: second-order joints, time, determinism."""

from __future__ import annotations

import numpy as np
import pytest

from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.touch import BAR_INERTIA, arm, bar, bar_skin, hold, no_command


def test_a_joint_under_impedance_answers_as_the_equation_says():
    """I q'' + d q' + k q = torque, critically damped, against the closed form."""
    robot, frequency = bar(), 10.0
    command = hold(robot, BAR_INERTIA * frequency**2, 2 * BAR_INERTIA * frequency)
    simulation = Simulation(robot, bar_skin(), Effects(timestep=1e-4))
    simulation._data.qpos[:] = 0.1
    simulation.step(3000, command)
    exact = 0.1 * (1 + frequency * 0.3) * np.exp(-frequency * 0.3)
    assert simulation.posture[0] == pytest.approx(exact, rel=2e-3)


def test_added_torque_balances_the_spring():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    simulation.step(4000, type(hold(robot, 1, 1))(np.zeros(1), np.array([20.0]), np.array([3.0]), np.array([2.0])))
    assert simulation.posture[0] == pytest.approx(0.1, rel=1e-6)


def test_weight_sags_unless_compensated():
    robot = bar()
    for gravity, sagged in (("on", True), ("compensated", False), ("off", False)):
        simulation = Simulation(robot, bar_skin(), Effects(gravity=gravity))
        simulation.step(3000, hold(robot, 40.0, 6.0))
        assert (abs(simulation.posture[0]) > 0.02) == sagged
        if sagged:
            angle = simulation.posture[0]
            assert 40.0 * angle == pytest.approx(9.81 * 0.2 * np.cos(angle), rel=1e-3), "about +y, down is positive"


def test_joints_stop_at_their_limits():
    robot = bar()
    push = type(no_command(robot))(np.zeros(1), np.zeros(1), np.ones(1), np.array([5.0]))
    for limits, free in ((True, False), (False, True)):
        simulation = Simulation(robot, bar_skin(), Effects(joint_limits=limits))
        simulation.step(3000, push)
        assert (simulation.posture[0] > 1.6) == free


def test_same_calls_same_numbers():
    prepared = arm()

    def run():
        simulation = Simulation(prepared.robot, prepared.skin, Effects(contact="self"))
        acts = {0: PokePressed(1, prepared.skin.taxel_point(10)), 40: PokePressed(2, prepared.skin.taxel_point(200)),
                60: PokeMoved(1, prepared.skin.taxel_point(12)), 90: PokeReleased(2)}  # fmt: skip
        states, pressures = [], []
        for tick in range(120):
            if tick in acts:
                simulation.apply(acts[tick])
            simulation.step(5, hold(prepared.robot, 3.0, 0.5))
            states.append(simulation.state())
            pressures.append(simulation.sense())
        return states, pressures

    first, second = run(), run()
    assert any(p.any() for p in first[1])
    for one, other in zip(first[0] + first[1], second[0] + second[1], strict=True):
        assert np.array_equal(one, other)


def test_reset_forgets_everything():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    start = simulation.state()
    simulation.apply(PokePressed(1, bar_skin().taxel_point(5)))
    simulation.step(200, hold(robot, 1.0, 0.1))
    assert simulation.time == pytest.approx(0.2)
    assert abs(simulation.posture[0]) > 1e-3
    simulation.reset()
    assert np.array_equal(simulation.state(), start)
    assert simulation.pokes == ()
    assert simulation.timestep == 0.001


def test_what_is_handed_out_is_not_what_is_inside():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    simulation.posture[0] = 9
    simulation.velocity[0] = 9
    assert simulation.posture[0] == simulation.velocity[0] == 0


def test_a_robot_without_joints_is_pressed_too():
    robot, skin = bar(hinged=False), bar_skin()
    simulation = Simulation(robot, skin, Effects())
    simulation.apply(PokePressed(1, skin.taxel_point(5), Finger(max_force=3.0)))
    simulation.step(1000, no_command(robot))
    assert simulation.sense() @ skin.areas == pytest.approx(3.0, rel=1e-12)
    assert simulation.posture.shape == simulation.velocity.shape == (0,)
