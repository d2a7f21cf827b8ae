"""The manager a session asks: settings are checked, controllers switch without a jump."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.task_control.monitors import QUIET
from tactile_maps.core.errors import SceneError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tests.control.contacts_by_hand import TICK, touch
from tests.support.limits import kinds
from tests.support.touch import arm, prepared_bar

BENT = np.array([0.7])
STILL = np.zeros(1)


def manager(**settings) -> ControllerManager:
    prepared = prepared_bar()
    return ControllerManager(prepared.robot, prepared.map, ControlSettings(**settings))


def test_refused_settings_leave_the_last_good_ones():
    mine = manager()
    with pytest.raises(SceneError, match=r"control\.stiffness"):
        mine.settings = replace(ControlSettings(), stiffness=-1.0)
    with pytest.raises(SceneError, match=r"control\.controller"):
        manager(controller="magic")
    assert mine.settings == ControlSettings()


def test_other_gains_do_not_start_a_law_afresh():
    mine = manager(controller="hold_force")
    first = mine.command(Observation(BENT, STILL, (), TICK)).posture
    mine.settings = ControlSettings(controller="hold_force", force_goal=5.0)
    second = mine.command(Observation(BENT, STILL, (), TICK)).posture
    assert 0 < first - second < 0.01, "on its way home"
    mine.reset()
    assert mine.settings.force_goal == 5.0
    assert mine.why_limited == ()


@pytest.mark.rotating
@pytest.mark.parametrize("before", CHOICES["controller"])
@pytest.mark.parametrize("after", CHOICES["controller"])
def test_a_law_switched_in_mid_contact_does_not_jump(before, after):
    """The torque goes on, and changes as slowly afterwards as the controllers themselves do."""
    mine = manager(controller=before)
    posture = np.array([0.1])
    velocity = np.array([0.05])
    for _ in range(50):
        last = mine.command(Observation(posture, velocity, touch(4.0), TICK))
    mine.settings = replace(mine.settings, controller=after)
    torques = [last.torque_at(posture, velocity)[0]]
    torques += [
        mine.command(Observation(posture, velocity, touch(4.0), TICK)).torque_at(posture, velocity)[0]
        for _ in range(20)
    ]
    steady = abs(torques[0]) * TICK / 0.2 + 0.6
    assert np.abs(np.diff(torques)).max() < steady
    if before != after and "impedance" in (before, after):
        assert abs(torques[1] - torques[0]) < 0.5


def test_a_law_taken_up_again_starts_from_the_torque_asked_for_not_from_what_it_remembers():
    mine = manager(controller="hybrid")
    posture = np.array([0.1])
    for _ in range(50):
        mine.command(Observation(posture, STILL, touch(9.0), TICK))
    mine.settings = ControlSettings()
    for _ in range(400):
        asked = mine.command(Observation(posture, STILL, touch(3.0), TICK)).torque_at(posture, STILL)
    mine.settings = ControlSettings(controller="hybrid")
    command = mine.command(Observation(posture, STILL, touch(3.0), TICK))
    assert command.torque_at(posture, STILL) == pytest.approx(asked)
    assert abs(command.torque[0]) < 0.01 * abs(asked[0]), "its wanted posture gives it, nothing is left to fade"


def test_what_is_left_of_another_law_fades():
    mine = manager(controller="hybrid")
    for _ in range(20):
        mine.command(Observation(BENT, STILL, touch(9.0), TICK))
    mine.settings = ControlSettings()
    for _ in range(800):
        command = mine.command(Observation(BENT, STILL, (), TICK))
    assert np.array_equal(command.torque, [0.0])


def test_a_rest_posture_holds_under_every_law():
    mine = manager()
    posture = np.zeros(1)
    still = np.zeros(1)
    assert mine.rest == [0.0], "the robot's home, until it is set"
    mine.rest = np.array([0.3])
    assert mine.command(Observation(posture, still, (), TICK)).posture == [0.3]
    for controller in ("hold_force", "hybrid"):
        mine.settings = ControlSettings(controller=controller)
        assert mine.rest == [0.3]
        posture = np.zeros(1)
        mine.reset()
        for _ in range(800):
            posture = mine.command(Observation(posture, still, (), TICK)).posture
        assert posture == pytest.approx([0.3], abs=1e-2), "it comes back to rest, not home"


def test_another_map_is_taken_and_the_point_to_hold_with_it():
    """The place held is one of the body: where it is drawn does not matter."""
    prepared = arm()
    mine = ControllerManager(prepared.robot, prepared.map, ControlSettings(controller="priority", task="hold_point"))
    moved = move(MapDocument.of(prepared.map), [0], (0.2, 0.1)).map
    assert mine.command(Observation(prepared.robot.home, np.zeros(7), (), TICK)).posture.shape == (7,)
    mine.use(moved)
    assert mine._controller.map_kinematics.map is moved


@pytest.mark.parametrize(
    "controller", [controller for controller in CHOICES["controller"] if controller != "impedance"]
)
def test_a_skin_that_cannot_be_read_stops_every_law_that_reads(controller):
    """Nothing touches any more, it seems: without a word the arm would seek it, and press."""
    mine = manager(controller=controller)
    for _ in range(20):
        before = mine.command(Observation(BENT, STILL, touch(2.0), TICK))
    for _ in range(50):
        command = mine.command(Observation(BENT, STILL, (), TICK, readable=False))
        assert np.isfinite(command.torque_at(BENT, STILL)).all()
        assert mine.why_limited[0].kind in (LimitKind.SKIN_UNREADABLE, LimitKind.STOPPED_UNREADABLE)
    assert abs(command.posture[0] - before.posture[0]) < 0.05, "it stands"


def test_what_the_skin_cannot_hold_is_said_beside_what_limits_the_law():
    mine = manager(controller="hybrid", force_gain=0.05)
    seldom = SensorTiming(0.2)
    mine.command(Observation(BENT, STILL, touch(2.0), TICK))
    assert mine.why_limited == ()
    mine.readings = seldom
    assert mine.readings == seldom
    mine.command(Observation(BENT, STILL, touch(2.0), TICK))
    assert mine.why_limited[0].kind is LimitKind.FORCE_GAIN_HELD
    mine.settings = replace(mine.settings, gains="as_given")
    mine.command(Observation(BENT, STILL, touch(2.0), TICK))
    assert mine.why_limited[0].kind is LimitKind.FORCE_GAIN_UNSTABLE
    mine.reset()
    assert mine.why_limited == ()


def test_a_law_moves_by_the_gain_that_the_skin_can_hold():
    """What is said to be held is what the joint's speed goes by."""
    speeds = []
    for kind in ("as_given", "limited"):
        mine = manager(controller="hybrid", force_gain=0.05, gains=kind, integral_time=float("inf"))
        mine.readings = SensorTiming(0.2)
        before, after = (mine.command(Observation(BENT, STILL, touch(2.0), TICK)).posture[0] for _ in range(2))
        speeds.append(abs(after - before) / TICK)
        limit = mine.why_limited[0]
    assert speeds[1] / speeds[0] == pytest.approx(limit.value / 0.05, rel=0.05)


@pytest.mark.parametrize("controller", ["hold_force", "hybrid", "admittance", "qp"])
def test_a_reading_at_its_end_is_not_pressed_for_more(controller):
    mine = manager(controller=controller)
    mine.readings = SensorTiming(TICK, highest=1e4)
    start = mine.command(Observation(BENT, STILL, touch(1.0), TICK)).posture[0]
    for _ in range(20):
        command = mine.command(Observation(BENT, STILL, touch(1.0), TICK))
    assert LimitKind.SKIN_SATURATED in kinds(mine.why_limited)
    assert abs(command.posture[0] - start) < 1e-4
    mine.readings = SensorTiming(TICK)
    assert mine.command(Observation(BENT, STILL, touch(1.0), TICK)).posture[0] < start, (
        "outward: the bar's top is above"
    )


@pytest.mark.parametrize(("gains", "reduced"), [("limited", True), ("as_given", False)])
def test_a_force_that_oscillates_is_reported_and_its_gain_reduced(gains, reduced):
    mine = manager(controller="hybrid", gains=gains)
    for k in range(400):
        swing = np.sin(30 * k * TICK)
        mine.command(Observation(BENT - 1e-4 * swing, STILL, touch(3.0 + 2.5 * swing), TICK))
    (limit,) = [one for one in mine.why_limited if one.kind is LimitKind.OSCILLATION]
    assert (limit.value is not None and limit.value <= mine.settings.force_gain / 2) == reduced


def test_a_force_that_something_else_makes_swing_is_no_oscillation_of_the_loop():
    mine = manager(controller="hybrid")
    for k in range(400):
        mine.command(Observation(BENT, STILL, touch(3.0 + 2.5 * np.sin(30 * k * TICK)), TICK))
    assert LimitKind.OSCILLATION not in kinds(mine.why_limited)


def limited(controller: str, **joint) -> ControllerManager:
    """The bar's controller, where the model states limits of the hinge."""
    prepared = prepared_bar()
    robot = replace(prepared.robot, joints=(replace(prepared.robot.joints[0], **joint),))
    return ControllerManager(robot, prepared.map, ControlSettings(controller=controller))


@pytest.mark.parametrize("controller", CHOICES["controller"])
def test_torque_limit_of_a_joint_is_respected_and_named(controller):
    mine = limited(controller, max_effort=1.0)
    posture = np.array([0.6])
    said = set()
    for _ in range(200):  # too weak a touch, to which an arm that something blocks presses on
        command = mine.command(Observation(posture, STILL, touch(0.5), TICK))
        assert abs(command.torque_at(posture, STILL)[0]) <= 1.0 + 1e-9
        said |= {limit.kind for limit in mine.why_limited}
    assert LimitKind.TORQUE_LIMIT in said
    (limit,) = [limit for limit in mine.why_limited if limit.kind is LimitKind.TORQUE_LIMIT]
    assert limit.names == ("hinge",)
    mine.reset()
    assert mine.why_limited == ()


def test_torque_limit_holds_while_another_controller_fades():
    mine = limited("impedance", max_effort=1.0)
    posture = np.array([0.6])
    for controller in ("impedance", "hybrid", "impedance", "hold_force"):
        mine.settings = ControlSettings(controller=controller)
        for _ in range(20):
            command = mine.command(Observation(posture, STILL, touch(0.5), TICK))
            assert abs(command.torque_at(posture, STILL)[0]) <= 1.0 + 1e-9


@pytest.mark.parametrize(
    "controller", [name for name in CHOICES["controller"] if name not in ("impedance", "admittance")]
)
def test_integral_does_not_wind_up_at_the_torque_limit(controller):
    """After ten seconds of a blocked arm the torque turns as soon as after one, when the force is too high."""
    turned = []
    for blocked in (200, 2000):
        mine = limited(controller, max_effort=1.0)
        posture = np.array([0.6])
        for _ in range(40):
            mine.command(Observation(posture, STILL, touch(4.0), TICK))  # above the goal, so that the integral works
        for _ in range(blocked):
            mine.command(Observation(posture, STILL, touch(0.5), TICK))
        before = mine.command(Observation(posture, STILL, touch(0.5), TICK)).torque_at(posture, STILL)[0]
        ticks = 0
        while (
            abs(mine.command(Observation(posture, STILL, touch(6.0), TICK)).torque_at(posture, STILL)[0] - before)
            < 0.05
        ):
            ticks += 1
            assert ticks < 100
        turned.append(ticks)
    assert turned[0] == turned[1] < 50


@pytest.mark.parametrize("controller", ["hold_force", "hybrid", "parallel", "projection", "priority", "qp"])
def test_integral_does_not_grow_while_the_arm_is_wedged_below_its_torque_limit(controller):
    """A bare link rests on the object: the point does not move, and the skin reads less than the goal for 1 or 3 s."""
    turned = []
    for wedged in (200, 600):
        mine = manager(controller=controller, force_gain=0.001)
        posture = np.array([0.6])
        mine.readings = SensorTiming(TICK)
        for _ in range(40):
            mine.command(Observation(posture, STILL, touch(4.0), TICK))  # above the goal, so that the integral works
        for _ in range(wedged):
            mine.command(Observation(posture, STILL, touch(2.5), TICK))
        wanted = mine.command(Observation(posture, STILL, touch(3.2), TICK)).posture[0]
        ticks = 0
        while (
            now := mine.command(Observation(posture, STILL, touch(3.2), TICK)).posture[0]
        ) <= wanted:  # outward is negative
            wanted = now
            ticks += 1
            assert ticks < 100
        turned.append(ticks)
    assert turned[0] == turned[1] < 50


@pytest.mark.parametrize("controller", [name for name in CHOICES["controller"] if name != "impedance"])
@pytest.mark.parametrize("force", [0.1, 20.0])
def test_speed_limit_of_the_model_is_respected(controller, force):
    mine = limited(controller, max_speed=0.05)
    posture = np.array([0.1])
    fastest = 0.0
    for number in range(300):
        regions = touch(force) if number < 150 else ()  # and on the way back to rest
        after = mine.command(Observation(posture, STILL, regions, TICK)).posture
        fastest = max(fastest, abs(float(after[0] - posture[0])) / TICK)
        posture = after
    assert 0.01 < fastest <= 0.05 * (1 + 1e-6)


@pytest.mark.parametrize("controller", CHOICES["controller"])
@pytest.mark.parametrize(
    ("force", "velocity", "kind"), [(41.0, 0.0, LimitKind.STOPPED_BY_FORCE), (3.0, 3.2, LimitKind.STOPPED_BY_SPEED)]
)
def test_every_controller_is_stopped_yields_and_continues(controller, force, velocity, kind):
    mine = manager(controller=controller, stiffness=40.0)
    mine.command(Observation(BENT, STILL, touch(3.0), TICK))
    mine.command(Observation(BENT, np.array([velocity]), touch(force), TICK))
    assert kinds(mine.why_limited) == [kind]
    pushed = BENT + 0.1
    for _ in range(600):
        stopped = mine.command(Observation(pushed, STILL, touch(20.0), TICK))
        assert kinds(mine.why_limited) == [kind], "while something touches"
    assert stopped.posture == pytest.approx(pushed, abs=1e-3), "it gives way"
    assert not stopped.torque.any()
    ticks = 0
    while kind in kinds(mine.why_limited):
        last = stopped
        command = mine.command(Observation(pushed, STILL, (), TICK))
        assert command.torque_at(pushed, STILL) == pytest.approx(last.torque_at(pushed, STILL), abs=0.1), "no jump"
        stopped = command
        ticks = ticks + 1
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)


@pytest.mark.parametrize("before", ["impedance", "hold_force", "hybrid"])
@pytest.mark.parametrize("after", ["impedance", "hold_force", "hybrid", "qp"])
def test_a_stop_outlasts_a_change_of_the_controller(before, after):
    """The contact presses on below the greatest force: the new controller would go on against it."""
    mine = manager(controller=before, stiffness=40.0)
    mine.command(Observation(BENT, STILL, touch(41.0), TICK))
    stopped = kinds(mine.why_limited)
    assert stopped == [LimitKind.STOPPED_BY_FORCE]
    pushed = BENT + 0.05
    last = mine.command(Observation(BENT, STILL, touch(20.0), TICK))
    mine.settings = replace(mine.settings, controller=after)
    for _ in range(300):
        command = mine.command(Observation(pushed, STILL, touch(20.0), TICK))
        assert kinds(mine.why_limited) == stopped
        assert command.torque_at(pushed, STILL) == pytest.approx(last.torque_at(pushed, STILL), abs=0.1), "no jump"
        last = command
    assert command.posture == pytest.approx(pushed, abs=1e-2), "it still gives way"
    ticks = 0
    while stopped == kinds(mine.why_limited):
        mine.command(Observation(pushed, STILL, (), TICK))
        ticks += 1
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)


def test_a_stop_of_an_unreadable_skin_outlasts_a_change_to_a_controller_that_does_not_read_it():
    mine = manager(controller="hybrid")
    mine.command(Observation(BENT, STILL, (), TICK, readable=False))
    mine.settings = replace(mine.settings, controller="impedance")
    for _ in range(300):
        mine.command(Observation(BENT, STILL, (), TICK, readable=False))
        assert kinds(mine.why_limited) == [LimitKind.STOPPED_UNREADABLE]


def test_an_unreadable_skin_stops_neither_impedance_nor_hold_force_but_keeps_them_stopped():
    for controller in ("impedance", "hold_force"):
        mine = manager(controller=controller)
        mine.command(Observation(BENT, STILL, (), TICK, readable=False))
        assert not any(limit.kind.stops for limit in mine.why_limited)
        mine.command(Observation(BENT, STILL, touch(41.0), TICK))
        for _ in range(300):
            mine.command(Observation(BENT, STILL, (), TICK, readable=False))
        assert kinds(mine.why_limited) == [LimitKind.STOPPED_BY_FORCE]
