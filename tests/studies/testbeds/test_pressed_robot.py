"""A robot pressed by a probe: the scene and the results of a run."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.scene.stability import PROBE_MASS
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.studies.testbeds.pressed_robot import (
    HOLDING,
    PRESS_FORCE,
    REFERENCE_EFFECTS,
    SAMPLE_MS,
    SETTLING,
    PressRun,
    effects_at_step,
    press_robot,
    pressed_arm,
    run_press,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.touch import bar, bar_skin

EFFECTS = Effects(gravity="off", contact="probe", fingers=False)


@pytest.fixture(scope="module")
def arm():
    return pressed_arm(120)


@pytest.mark.long
def test_probe_starts_off_the_skin_and_moves_straight_in_along_an_axis(arm):
    first, last = np.array(arm.probe.spec.path)[[0, -1], 1:]
    way = last - first
    assert np.count_nonzero(np.abs(way) > 1e-12) == 1
    touched = Configuration(arm.robot).pose("forearm").points(arm.skin.position(arm.at)[None])[0]
    assert np.linalg.norm(first - touched) == pytest.approx(arm.probe.spec.size[0] + 0.002)
    assert arm.probe.spec.mass == PROBE_MASS


SOFT = ElasticLayer(stiffness=1e4)


@pytest.fixture(scope="module")
def fine(arm):
    return run_press(arm, REFERENCE_EFFECTS, SOFT)


def made(forces=(1.0,), postures=((0.0,),), stopped=""):
    return PressRun(np.array(postures), np.array(forces), np.array([8e-3, 1.0, 8e-3]), stopped)


@pytest.mark.long
def test_fine_step_has_converged(fine, arm):
    """A fine step has converged: another integrator and twice the step give the same posture and force."""
    for integrator in ("discrete", "implicitfast"):
        other = run_press(arm, effects_at_step(integrator, 0.1), SOFT)
        assert other.forces.mean() == pytest.approx(fine.forces.mean(), rel=1e-6)
        assert np.abs(other.postures - fine.postures).max() < 2e-5
    assert np.ptp(fine.postures, axis=0).max() > 1e-3, "it gave way"
    assert fine.forces.mean() == pytest.approx(PRESS_FORCE, rel=0.05)


@pytest.mark.long
def test_contact_is_sampled_often_and_finally_at_every_step(fine, arm):
    looks = round(1e3 * SETTLING / SAMPLE_MS)
    steps = round(HOLDING / REFERENCE_EFFECTS.timestep)
    assert fine.postures.shape == (looks, len(arm.robot.joints))
    assert fine.seconds.shape == (looks,)
    assert fine.forces.shape == (steps,)
    assert fine.steady(fine)
    assert fine.posture_error(fine) == 0


@pytest.mark.long
def test_stopped_runs_keep_their_data(fine, arm):
    run = run_press(arm, effects_at_step("euler", 8.0), SOFT)
    assert "time step" in run.stopped
    assert 0 < len(run.postures) < len(fine.postures)
    assert not run.steady(fine)


def test_errors_refer_to_the_true_force():
    true = made(forces=(2.0, 2.0))
    run = made(forces=(1.0, 2.0), postures=((3.0,),))
    assert run.force_errors(true) == pytest.approx((0.25, 0.25))
    assert run.posture_error(true) == pytest.approx(3.0)
    assert not run.steady(true)
    assert made(forces=(1.99, 2.01)).steady(true)
    assert made(forces=(0.0, 2.0, 2.0, 4.0)).lost == 0.25
    assert not made(forces=(2.0, 2.0), stopped="why").steady(true)


def test_robot_without_joints_has_no_posture_error():
    still = press_robot(bar(hinged=False), bar_skin())
    run = run_press(still, effects_at_step("discrete", 1.0), SOFT)
    assert run.posture_error(run) is None
    assert run.steady(run)
    assert run.forces.mean() == pytest.approx(PRESS_FORCE, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("name", ["ur5e", "icub"])
def test_probe_reaches_the_skin_on_concave_links(name):
    prepared = prepare_cached(load_scene(name))
    pressed = press_robot(prepared.robot, prepared.skin)
    run = run_press(pressed, effects_at_step("discrete", 1.0), prepared.scene.layer)
    assert run.forces.mean() == pytest.approx(PRESS_FORCE, rel=0.01)


def test_true_wrench_without_contact_is_rejected():
    nothing = PressRun(np.zeros((2, 1)), np.zeros(5), np.ones(2))
    with pytest.raises(SimulationError, match="does not reach the skin"):
        nothing.force_errors(nothing)
