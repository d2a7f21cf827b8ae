"""The controller manager: checked settings, changes of controller without a jump, effective gains and safety stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.gain_limits import ENDED
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.control.task_control.monitors import QUIET
from tactile_maps.core.errors import SceneError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tests.control.contacts import TICK, observed, touch
from tests.support.limits import kinds
from tests.support.touch import arm, prepared_bar

BENT = 0.7
ALL = CHOICES["controller"]
READING = [name for name in ALL if name != "impedance"]
INTEGRAL = [name for name in READING if name != "admittance"]


class Bench:
    """The manager of a bar with one hinge, which may have limits of its own."""

    def __init__(self, controller="impedance", posture=BENT, *, joint=None, **settings):
        prepared = prepared_bar()
        robot = replace(prepared.robot, joints=(replace(prepared.robot.joints[0], **(joint or {})),))
        self.manager = ControllerManager(robot, prepared.map, ControlSettings(controller, **settings))
        self.posture = posture

    def step(self, force=None, *, ticks=1, velocity=0.0, readable=True):
        """The last command; without a force nothing touches."""
        contacts = () if force is None else touch(force)
        self.velocity = velocity
        for _ in range(ticks):
            seen = observed([self.posture], contacts, velocity=velocity, readable=readable)
            self.command = self.manager.command(seen)
        return self.command

    def torque(self, force=None, **how):
        """The commanded torque after one more tick [N m]."""
        return float(self.step(force, **how).torque_at(np.array([self.posture]), self.velocity)[0])

    def change(self, **settings):
        self.manager.settings = replace(self.manager.settings, **settings)

    @property
    def limits(self):
        return kinds(self.manager.why_limited)


def test_invalid_settings_raise_and_the_previous_ones_stay():
    bench = Bench()
    with pytest.raises(SceneError, match=r"control\.stiffness"):
        bench.change(stiffness=-1.0)
    with pytest.raises(SceneError, match=r"control\.controller"):
        Bench("magic")
    assert bench.manager.settings == ControlSettings()


def test_new_gains_do_not_restart_a_controller():
    bench = Bench("hold_force")
    first = bench.step().posture
    bench.change(force_goal=5.0)
    assert 0 < first - bench.step().posture < 0.01, "on its way home"
    bench.manager.reset()
    assert (bench.manager.settings.force_goal, bench.limits) == (5.0, [])


@pytest.mark.rotating
@pytest.mark.parametrize("before", ALL)
@pytest.mark.parametrize("after", ALL)
def test_change_of_the_controller_in_contact_does_not_jump(before, after):
    """The torque continues, and changes as slowly afterwards as the controllers themselves do."""
    bench = Bench(before, 0.1)
    last = bench.torque(4.0, ticks=50, velocity=0.05)
    bench.change(controller=after)
    torques = [last, *(bench.torque(4.0, velocity=0.05) for _ in range(20))]
    assert np.abs(np.diff(torques)).max() < abs(last) * TICK / 0.2 + 0.6
    if before != after and "impedance" in (before, after):
        assert abs(torques[1] - torques[0]) < 0.5


def test_controller_selected_again_starts_from_the_current_torque():
    bench = Bench("hybrid", 0.1)
    bench.step(9.0, ticks=50)
    bench.change(controller="impedance")
    before = bench.torque(3.0, ticks=400)
    bench.change(controller="hybrid")
    assert bench.torque(3.0) == pytest.approx(before)
    assert abs(bench.command.torque[0]) < 0.01 * abs(before), "from its desired posture; nothing is left to fade"


def test_remaining_torque_of_the_previous_controller_fades():
    bench = Bench("hybrid")
    bench.step(9.0, ticks=20)
    bench.change(controller="impedance")
    assert bench.step(ticks=800).torque == [0.0]


@pytest.mark.long
def test_rest_posture_is_used_by_every_controller():
    bench = Bench(posture=0.0)
    assert bench.manager.rest == [0.0], "the robot's home, until it is set"
    bench.manager.rest = np.array([0.3])
    assert bench.step().posture == [0.3]
    for controller in ("hold_force", "hybrid"):
        bench.change(controller=controller)
        bench.manager.reset()
        bench.posture = 0.0
        for _ in range(800):
            bench.posture = float(bench.step().posture[0])
        assert bench.posture == pytest.approx(0.3, abs=1e-2)


def test_map_can_be_replaced():
    prepared = arm()
    manager = ControllerManager(prepared.robot, prepared.map, ControlSettings("priority", task="hold_point"))
    moved = move(MapDocument.of(prepared.map), [0], (0.2, 0.1)).map
    manager.command(observed(prepared.robot.home))
    manager.use(moved)
    assert manager._controller.map_kinematics.map is moved


@pytest.mark.sampled(4)
@pytest.mark.parametrize("controller", READING)
def test_unreadable_skin_holds_controllers_that_read_contacts(controller):
    """A controller that is not held would search for the contact that seems lost, and press."""
    bench = Bench(controller)
    before = bench.step(2.0, ticks=20).posture
    for _ in range(50):
        assert np.isfinite(bench.torque(readable=False))
        assert bench.limits[0] in (LimitKind.SKIN_UNREADABLE, LimitKind.STOPPED_UNREADABLE)
    assert abs(bench.command.posture - before) < 0.05


def test_gain_limits_are_reported_and_applied():
    bench = Bench("hybrid", force_gain=0.05, integral_time=float("inf"))
    bench.step(2.0)
    assert bench.limits == []
    speeds = {}
    for gains, kind in (("as_given", LimitKind.FORCE_GAIN_UNSTABLE), ("limited", LimitKind.FORCE_GAIN_HELD)):
        bench.manager.reset()
        bench.change(gains=gains)
        bench.manager.readings = SensorTiming(0.2)
        assert bench.manager.readings == SensorTiming(0.2)
        before = bench.step(2.0).posture
        speeds[gains] = float(abs(bench.step(2.0).posture - before)[0])
        assert bench.limits[0] is kind
    gain = bench.manager.why_limited[0].value
    assert speeds["limited"] / speeds["as_given"] == pytest.approx(gain / 0.05, rel=0.05)
    bench.manager.reset()
    assert bench.limits == []


@pytest.mark.parametrize("controller", ["hold_force", "hybrid", "admittance", "qp"])
def test_saturated_taxel_is_not_pressed_harder(controller):
    bench = Bench(controller)
    bench.manager.readings = SensorTiming(TICK, highest=1e4)
    start = bench.step(1.0).posture
    assert abs(bench.step(1.0, ticks=20).posture - start) < 1e-4
    assert LimitKind.SKIN_SATURATED in bench.limits
    bench.manager.readings = SensorTiming(TICK)
    assert bench.step(1.0).posture < start, "outward is up"


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("gains", "way", "reduced"), [("limited", 1e-4, True), ("as_given", 1e-4, False), ("limited", 0.0, None)]
)
def test_oscillation_of_the_loop_is_reported_and_its_gain_reduced(gains, way, reduced):
    """If the arm does not move, something else makes the force swing."""
    bench = Bench("hybrid", gains=gains)
    for k in range(400):
        swing = np.sin(30 * k * TICK)
        bench.posture = BENT - way * swing
        bench.step(3.0 + 2.5 * swing)
    found = [one.value for one in bench.manager.why_limited if one.kind is LimitKind.OSCILLATION]
    if reduced is None:
        assert not found
    else:
        assert (found[0] is not None and found[0] <= bench.manager.settings.force_gain / 2) == reduced


@pytest.mark.parametrize("gains", ["limited", "as_given"])
def test_oscillation_is_reported_until_the_force_has_been_calm_for_two_seconds(gains):
    bench = Bench("hybrid", gains=gains)
    reported = []
    for k in range(round(7.0 / TICK)):
        swing = np.sin(30 * k * TICK) if k * TICK < 2.0 else 0.0
        bench.posture = BENT - 1e-4 * swing
        bench.step(3.0 + 2.5 * swing)
        reported.append(LimitKind.OSCILLATION in bench.limits)
    begins = reported.index(True)
    ends = begins + reported[begins:].index(False)
    assert not any(reported[ends:])
    assert ends * TICK == pytest.approx(2.0 + ENDED, abs=0.2), "without a gap before"
    held = [limit.value for limit in bench.manager.why_limited if limit.kind is LimitKind.FORCE_GAIN_HELD]
    assert len(held) == (gains == "limited"), "the gain is still reduced"
    assert all(value < bench.manager.settings.force_gain for value in held)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("controller", ALL)
def test_torque_limit_of_a_joint_is_respected_and_named(controller):
    bench = Bench(controller, 0.6, joint={"max_effort": 1.0})
    for _ in range(200):  # a blocked arm presses against a contact that is too weak
        assert abs(bench.torque(0.5)) <= 1.0 + 1e-9
    (limit,) = [limit for limit in bench.manager.why_limited if limit.kind is LimitKind.TORQUE_LIMIT]
    assert limit.names == ("hinge",)
    bench.manager.reset()
    assert bench.limits == []


def test_torque_limit_is_respected_while_the_previous_torque_fades():
    bench = Bench(posture=0.6, joint={"max_effort": 1.0})
    for controller in ("impedance", "hybrid", "impedance", "hold_force"):
        bench.change(controller=controller)
        for _ in range(20):
            assert abs(bench.torque(0.5)) <= 1.0 + 1e-9


def ticks_until(turned) -> int:
    """Number of ticks until ``turned`` returns true."""
    for tick in range(100):
        if turned():
            return tick
    raise AssertionError("it does not turn")


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", INTEGRAL)
def test_integral_does_not_wind_up_at_the_torque_limit(controller):
    """The torque of a blocked arm turns as soon after 10 s as after 1 s, when the force is too high."""
    turned = []
    for blocked in (200, 2000):
        bench = Bench(controller, 0.6, joint={"max_effort": 1.0})
        bench.step(4.0, ticks=40)  # above the goal, so that the integral starts
        before = bench.torque(0.5, ticks=blocked + 1)
        turned.append(ticks_until(lambda bench=bench, before=before: abs(bench.torque(6.0) - before) >= 0.05))
    assert turned[0] == turned[1] < 50


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", INTEGRAL)
def test_integral_does_not_grow_while_the_arm_is_wedged_below_its_torque_limit(controller):
    """A bare link rests on the object: the point does not move, and the skin reads less than the goal for 1 or 3 s."""
    turned = []
    for wedged in (200, 600):
        bench = Bench(controller, 0.6, force_gain=0.001)
        bench.manager.readings = SensorTiming(TICK)
        bench.step(4.0, ticks=40)  # above the goal, so that the integral starts
        bench.step(2.5, ticks=wedged)
        postures = bench.step(3.2).posture, *(bench.step(3.2).posture for _ in range(50))
        inward = (np.diff(np.ravel(postures)) > 0).tolist()  # outward is negative
        turned.append(inward.index(True))
    assert turned[0] == turned[1] < 50


@pytest.mark.sampled(3)
@pytest.mark.parametrize("controller", READING)
@pytest.mark.parametrize("force", [0.1, 20.0])
def test_speed_limit_of_the_model_is_respected(controller, force):
    bench = Bench(controller, 0.1, joint={"max_speed": 0.05})
    speeds = []
    for number in range(300):
        after = float(bench.step(force if number < 150 else None).posture[0])  # and on the way back to rest
        speeds.append(abs(after - bench.posture) / TICK)
        bench.posture = after
    assert 0.01 < max(speeds) <= 0.05 * (1 + 1e-6)


def continues_after_quiet(bench):
    """The stop ends ``QUIET`` after the last contact, without a jump of the torque."""
    torques = [bench.torque()]
    stopped = bench.limits
    while bench.limits == stopped:
        torques.append(bench.torque())
    assert np.abs(np.diff(torques)).max() < 0.1
    ticks = len(torques)
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("controller", ALL)
@pytest.mark.parametrize(
    ("force", "velocity", "kind"), [(41.0, 0.0, LimitKind.STOPPED_BY_FORCE), (3.0, 3.2, LimitKind.STOPPED_BY_SPEED)]
)
def test_every_controller_is_stopped_yields_and_continues(controller, force, velocity, kind):
    bench = Bench(controller, stiffness=40.0)
    free = bench.step(3.0).stiffness
    assert (bench.step(force, velocity=velocity).stiffness < free).all()
    assert bench.limits == [kind]
    bench.posture = BENT + 0.1
    assert bench.step(20.0, ticks=600).posture == pytest.approx(bench.posture, abs=1e-3), "it yields"
    assert bench.limits == [kind], "while something touches"
    assert not bench.command.torque.any()
    continues_after_quiet(bench)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("before", ["impedance", "hold_force", "hybrid"])
@pytest.mark.parametrize("after", ["impedance", "hold_force", "hybrid", "qp"])
def test_stop_continues_when_the_controller_changes(before, after):
    """A contact below the largest force remains, and the new controller would press against it."""
    bench = Bench(before, stiffness=40.0)
    bench.step(41.0)
    bench.posture = BENT + 0.05
    last = bench.torque(20.0)
    bench.change(controller=after)
    for _ in range(300):
        torque = bench.torque(20.0)
        assert bench.limits == [LimitKind.STOPPED_BY_FORCE]
        assert torque == pytest.approx(last, abs=0.1), "no jump"
        last = torque
    assert bench.command.posture == pytest.approx(bench.posture, abs=1e-2), "it still yields"
    continues_after_quiet(bench)


@pytest.mark.parametrize("controller", ["impedance", "hold_force"])
def test_unreadable_skin_does_not_stop_controllers_without_need_of_it_but_keeps_them_stopped(controller):
    bench = Bench(controller)
    bench.step(readable=False)
    assert not any(kind.stops for kind in bench.limits)
    bench.step(41.0)
    bench.step(readable=False, ticks=300)
    assert bench.limits == [LimitKind.STOPPED_BY_FORCE]
    bench = Bench("hybrid")
    bench.step(readable=False)
    bench.change(controller=controller)
    bench.step(readable=False, ticks=300)
    assert bench.limits == [LimitKind.STOPPED_UNREADABLE]
