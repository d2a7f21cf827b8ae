"""Friction adds no energy: braked bodies, damped joints, and steps that need no repetition."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.simulation.model.passive_friction import PassiveFriction, friction_work

FRICTION = 0.6
GRAVITY = 10.0
BRAKE = 40.0
"""Deceleration by a force on the sliding ball [m/s^2]: more than the reference of friction."""
NAMES = {"euler": "Euler"}
INTEGRATORS = ("implicitfast", "discrete", "euler", "implicit")


def _ball_on_plane(
    integrator: str, *, damping: float = 0.0, axes: tuple[str, str] = ("1 0 0", "0 0 1"), reference: float = 20.0
) -> mujoco.MjModel:
    """A ball on two sliding joints, 1 kg, the first one damped; ``reference`` is the damping of friction [1/s]."""
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <option integrator="{NAMES.get(integrator, integrator)}" timestep="0.001" gravity="0 0 {-GRAVITY}"
                  cone="elliptic" impratio="1000" tolerance="1e-12" jacobian="dense">
            <flag island="disable" refsafe="disable"/>
          </option>
          <worldbody>
            <geom name="ground" type="plane" size="1 1 1"/>
            <body name="ball" pos="0 0 0.1">
              <joint name="x" type="slide" axis="{axes[0]}" damping="{damping}"/>
              <joint name="z" type="slide" axis="{axes[1]}"/>
              <geom name="ball" size="0.1" mass="1"/>
            </body>
          </worldbody>
          <contact><pair geom1="ground" geom2="ball" condim="3" friction="{FRICTION} {FRICTION} 0 0 0"
                         solref="-5000 -100" solreffriction="-1 {-reference}" solimp="0.5 0.5 0.001"/></contact>
        </mujoco>"""
    )


def _settled(model: mujoco.MjModel, *, speed: float) -> mujoco.MjData:
    data = mujoco.MjData(model)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    data.qvel[0] = speed
    mujoco.mj_forward(model, data)
    return data


def _slide(model: mujoco.MjModel, data: mujoco.MjData, count: int, *, passive: bool) -> float:
    """Make steps against the brake; return the greatest work of friction in one of them [J]."""
    friction = PassiveFriction(model)
    most = -np.inf
    for _ in range(count):
        mujoco.mj_step1(model, data)
        data.qfrc_applied[0] = -BRAKE
        if passive:
            friction.finish_step(data)
        else:
            mujoco.mj_step2(model, data)
        most = max(most, max(friction_work(model, data), default=0.0))
    return most


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_friction_opposes_sliding_even_with_strong_braking(integrator):
    """Coulomb's force adds to the brake, although the brake exceeds the reference of friction."""
    model = _ball_on_plane(integrator)
    pushed = _settled(model, speed=1.0)
    assert _slide(model, pushed, 10, passive=False) > 1e-3, "MuJoCo's friction pushes the ball along"
    data = _settled(model, speed=1.0)
    assert _slide(model, data, 10, passive=True) <= 0
    assert 1.0 - data.qvel[0] == pytest.approx(0.01 * (BRAKE + FRICTION * GRAVITY), rel=0.03)


@pytest.mark.parametrize("integrator", ["implicitfast", "implicit", "euler"])
def test_friction_on_a_strongly_damped_joint_adds_no_energy(integrator):
    """These integrators damp after the solver, whose friction holds the ball for an acceleration that it never has."""
    model = _ball_on_plane(integrator, damping=1e4, axes=("1 0 1", "1 0 -1"), reference=500.0)
    gained, usual = _push_out(model, passive=False)
    assert gained > 1e-5
    work, speed = _push_out(model, passive=True)
    assert work <= 1e-10
    assert speed <= usual, "the joint is as damped as before"


def _push_out(model: mujoco.MjModel, *, passive: bool) -> tuple[float, float]:
    """Let the ground push the ball out; return the greatest work of friction in a step [J] and speed of the damped
    joint [m/s]."""
    data = mujoco.MjData(model)
    data.qpos[:] = -0.002, 0.002  # 2.8 mm deep
    data.qfrc_applied[:] = 2.0, 2.0  # along the ground
    friction = PassiveFriction(model)
    most = -np.inf
    fastest = 0.0
    for _ in range(20):
        mujoco.mj_step1(model, data)
        if passive:
            friction.finish_step(data)
        else:
            mujoco.mj_step2(model, data)
        most = max(most, max(friction_work(model, data), default=0.0))
        fastest = max(fastest, abs(float(data.qvel[0])))
    return most, fastest


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_step_without_energy_gain_equals_that_of_mujoco(integrator):
    model = _ball_on_plane(integrator)
    data = _settled(model, speed=0.5)
    plain = _settled(model, speed=0.5)
    friction = PassiveFriction(model)
    for _ in range(50):
        mujoco.mj_step1(model, data)
        friction.finish_step(data)
        mujoco.mj_step(model, plain)
    assert 0.1 < data.qvel[0] < 0.4, "it slides"
    np.testing.assert_array_equal(data.qpos, plain.qpos)
    np.testing.assert_array_equal(data.qvel, plain.qvel)
