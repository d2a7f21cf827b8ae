"""The bound on the speed of an approach: its model of an impact, and what controllers do with it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.approach_speed import ApproachSpeed, TaxelMotions, peak_force
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY
from tactile_maps.control.motion.limits import ActiveLimits, LimitKind
from tactile_maps.control.motion.task_priority import ContactPresence
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, observed, touch_on
from tests.support.touch import arm, prepared_bar


def held(mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness and damping of joints with the frequency of controllers and critical damping."""
    inertia = np.diagonal(mass)
    return INNER_FREQUENCY**2 * inertia, 2 * INNER_FREQUENCY * inertia


@pytest.mark.parametrize("latency", [0.005, 0.05])
@pytest.mark.parametrize("stiffness", [1e3, 2e4, 1e6])
@pytest.mark.parametrize("mass", [0.2, 5.0])
def test_impact_of_one_mass_follows_the_closed_form(mass, stiffness, latency):
    """x'' + (2 w + sqrt(2) u) x' + (w² + u²) x = w² v (2 / w + t): a ramp and two exponentials, then a ramp less."""
    w = INNER_FREQUENCY
    u = math.sqrt(stiffness / mass)
    damping = 2 * w + math.sqrt(2) * u
    total = w**2 + u**2
    poles = np.roots([1.0, damping, total]).astype(complex)

    def ramp(t: np.ndarray, start: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """Depth and its rate for a desired depth of ``start`` + t, from zero depth and ``speed``."""
        rate = w**2 / total
        level = (w**2 * start - damping * rate) / total
        shares = np.linalg.solve(np.array([[1, 1], poles]), [-level, speed - rate])
        waves = shares[:, None] * np.exp(poles[:, None] * t)
        return (level + rate * t + waves.sum(axis=0)).real, (rate + (poles[:, None] * waves).sum(axis=0)).real

    time = np.linspace(0, latency + 2 / w, 20001)
    depth, rate = ramp(time, 2 / w, 1.0)
    late = time > latency
    less, slower = ramp(time[late] - latency, 0.0, 0.0)
    depth[late] -= less
    rate[late] -= slower
    expected = (stiffness * depth + math.sqrt(2 * stiffness * mass) * rate).max()
    inertia = np.array([[mass]])
    found = peak_force(inertia, held(inertia), np.ones(1), np.array([0.1]), stiffness=stiffness, latency=latency)
    assert found == pytest.approx(0.1 * expected, rel=0.01)


@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
def test_impact_of_coupled_joints_equals_small_steps(stiffness):
    mass = np.array([[0.4, 0.15, 0.02], [0.15, 0.2, 0.03], [0.02, 0.03, 0.05]])
    outward = np.array([0.5, 0.3, -0.2])
    speed = np.array([0.3, 0.2, -0.5])
    spring, damper = held(mass)
    latency = 0.02
    inverse = np.linalg.inv(mass)
    contact = math.sqrt(2 * stiffness / (outward @ inverse @ outward))
    step = 1e-5
    way = np.zeros(3)
    velocity = speed.copy()
    desired = damper * speed / spring
    peak = 0.0
    for tick in range(round((latency + 2 / INNER_FREQUENCY) / step)):
        force = stiffness * outward @ way + contact * outward @ velocity
        peak = max(peak, force)
        velocity = velocity + step * inverse @ (spring * (desired - way) - damper * velocity - force * outward)
        way = way + step * velocity
        desired = desired + step * speed * (tick * step < latency)
    found = peak_force(mass, (spring, damper), outward, speed, stiffness=stiffness, latency=latency)
    assert found == pytest.approx(peak, rel=0.02)


def approach(max_impact: float) -> ApproachSpeed:
    return ApproachSpeed(TaxelMotions.of(arm().skin), max_impact, stiffness=2e4, latency=TICK)


def test_joints_slow_down_until_the_impact_is_within_its_limit_and_report_it():
    configuration = Configuration(arm().robot)
    speed = np.full(7, 0.3)
    impact, link = approach(20.0).impact(configuration, speed)
    assert impact > 40.0
    limits = ActiveLimits()
    slower = approach(20.0).limited(configuration, speed, limits)
    assert approach(20.0).impact(configuration, slower) == (pytest.approx(20.0), link)
    assert slower / speed == pytest.approx(np.full(7, 20.0 / impact))
    [limit] = limits.found
    assert (limit.kind, limit.names, limit.value, limit.bound) == (LimitKind.APPROACH_SPEED, (link,), impact, 20.0)


def test_joints_that_hit_gently_enough_keep_their_speed():
    limits = ActiveLimits()
    speed = np.full(7, 0.3)
    assert approach(1e3).limited(Configuration(arm().robot), speed, limits) is speed
    assert limits.found == ()


def test_no_taxel_hits_harder_than_the_reported_impact():
    """Each taxel alone, with the exact model: the largest is reported, or one within a few percent of it."""
    configuration = Configuration(arm().robot)
    skin = arm().skin
    rng = np.random.default_rng(0)
    mass = configuration.mass_matrix()
    for _ in range(3):
        speed = rng.uniform(-0.5, 0.5, 7)
        rows = []
        for number in range(0, len(skin), 5):
            at = skin.taxel_point(number)
            normal = configuration.pose(skin.link(at)).directions(skin.normal(at))
            rows.append(normal @ configuration.jacobian(skin.link(at), skin.position(at)))
        peaks = [
            peak_force(mass, held(mass), row, speed, stiffness=2e4, latency=TICK) for row in rows if row @ speed > 0
        ]
        assert max(peaks) <= 1.03 * approach(20.0).impact(configuration, speed)[0]


def test_robot_without_joints_has_no_impact():
    bar = prepared_bar(hinged=False)
    found = ApproachSpeed(TaxelMotions.of(bar.skin), 1.0, 2e4, TICK).impact(Configuration(bar.robot), np.zeros(0))
    assert found == (0.0, "")


def manager(controller: str, **settings: float) -> ControllerManager:
    made = ControllerManager(arm().robot, arm().map, ControlSettings(controller, **settings), stiffness=2e4)
    made.readings = SensorTiming(TICK)
    return made


def fastest(made: ControllerManager, contacts=(), *, ticks: int = 60) -> float:
    """Return the largest impact [N] of the commanded motion of an arm that follows it."""
    configuration = Configuration(arm().robot)
    posture = arm().robot.home
    worst = 0.0
    for _ in range(ticks):
        command = made.command(observed(posture, contacts))
        configuration.update(posture)
        worst = max(worst, approach(1.0).impact(configuration, (command.posture - posture) / TICK)[0])
        posture = command.posture
    return worst


@pytest.mark.sampled(3)
@pytest.mark.parametrize("controller", ["hold_force", *CONTROL_SCHEMES])
def test_every_controller_returns_to_rest_within_the_impact_limit(controller):
    free = manager(controller)
    free.rest = arm().robot.home + 0.5
    assert fastest(free) > 30.0
    assert not any(limit.kind is LimitKind.APPROACH_SPEED for limit in free.why_limited)
    bounded = manager(controller, max_impact=10.0)
    bounded.rest = arm().robot.home + 0.5
    assert 9.0 < fastest(bounded) < 11.0, "the latency of readings of one tick"
    assert any(limit.kind is LimitKind.APPROACH_SPEED for limit in bounded.why_limited)


@pytest.mark.parametrize(("max_impact", "grows"), [(math.inf, True), (2.0, False)])
def test_integral_does_not_grow_while_an_approach_is_slowed_down(max_impact, grows):
    weak = touch_on(arm().map, 150, force=0.5)
    made = manager("hybrid", max_impact=max_impact, force_goal=20.0)
    posture = arm().robot.home
    for _ in range(100):
        posture = made.command(observed(posture, (weak,))).posture
    assert (made._controller._scheme._servo.integral((weak.id, ContactPresence.FELT)) > 0) == grows
