"""Each control scheme by the errors it serves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import (
    MAX_JOINT_SPEED,
    MAX_POINT_SPEED,
    PostureReference,
    joint_limits,
)
from tactile_maps.control.motion.limits import ActiveLimits, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.task_priority import (
    ArmState,
    ContactPresence,
    PriorityLevel,
    TaskContact,
    solve_hierarchy,
)
from tactile_maps.control.task_control.schemes import (
    CAP_SHARE,
    MAX_ACCELERATION,
    AdmittanceScheme,
    ForceServo,
    HybridScheme,
    ParallelScheme,
    PointVelocityScheme,
    PriorityScheme,
    ProjectionScheme,
    QuadraticProgramScheme,
    limit_point_speed,
)
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts_by_hand import contact
from tests.support.limits import kinds
from tests.support.touch import arm, bar

SETTINGS = ControlSettings(force_gain=0.01, integral_time=0.5)
DT = 0.005
ONE, TWO = ((number, ContactPresence.FELT) for number in (1, 2))


def push(servo, error, *, contact=ONE, limits=None, settings=SETTINGS):
    return servo.push(settings, contact, error, DT, ActiveLimits() if limits is None else limits)


def test_proportional_until_the_goal_was_reached_then_integral_too():
    servo = ForceServo(1.0)
    assert [push(servo, 1.0) for _ in range(3)] == pytest.approx([0.01] * 3)
    assert [push(servo, -1.0) for _ in range(3)] == pytest.approx([-0.01 * (1 + k * DT / 0.5) for k in (1, 2, 3)])
    assert servo.integral(ONE) == pytest.approx(-3 * DT)


def test_each_contact_has_its_own_memory_and_takes_it_along():
    servo = ForceServo(1.0)
    push(servo, -1.0)
    push(servo, -2.0, contact=TWO)
    assert (servo.integral(ONE), servo.integral(TWO)) == pytest.approx((-DT, -2 * DT))
    servo.keep([TWO])
    assert (servo.integral(ONE), servo.integral(TWO)) == pytest.approx((0.0, -2 * DT))
    assert push(servo, 1.0) == pytest.approx(0.01), "it has to reach its goal again"


def test_the_integral_stands_while_the_answer_is_bounded():
    servo = ForceServo(0.02)
    limits = ActiveLimits()
    push(servo, -1.0)
    gathered = servo.integral(ONE)
    for _ in range(1000):
        assert push(servo, -50.0, limits=limits) == -0.02
    assert servo.integral(ONE) == pytest.approx(gathered)
    assert kinds(limits) == [LimitKind.POINT_SPEED]
    assert push(servo, 1.0) == pytest.approx(0.01, rel=0.02), "free at once"


def test_no_integral_at_all():
    servo = ForceServo(1.0)
    endless = ControlSettings(force_gain=0.01, integral_time=float("inf"))
    assert [push(servo, -1.0, settings=endless) for _ in range(4)] == [-0.01] * 4
    assert servo.integral(ONE) == 0.0
    push(servo, -1.0)
    push(servo, -1.0, settings=endless)
    assert servo.integral(ONE) == pytest.approx(-DT), "what was gathered stands"


def test_what_was_gathered_stands_without_an_integral_even_while_the_speed_is_bounded():
    servo = ForceServo(0.02)
    endless = replace(SETTINGS, integral_time=float("inf"))
    push(servo, -1.0)
    for _ in range(100):
        assert push(servo, 50.0, settings=endless) == 0.02
    assert servo.integral(ONE) == -DT


def test_an_error_that_unwinds_the_integral_is_gathered_while_the_speed_is_bounded():
    servo = ForceServo(0.02)
    quick = replace(SETTINGS, integral_time=0.05)
    for _ in range(100):
        push(servo, -1.0)
    wound = servo.integral(ONE)
    assert wound < -0.4
    assert push(servo, 0.1, settings=quick) == -0.02, "bounded by the integral alone"
    assert servo.integral(ONE) == pytest.approx(wound + 0.1 * DT)
    for _ in range(10):
        assert push(servo, 9.0) == 0.02, "bounded the other way, by the error"
    assert servo.integral(ONE) == pytest.approx(wound + (0.1 + 10 * 9.0) * DT)
    for _ in range(10):
        push(servo, 9.0)
    assert servo.integral(ONE) == 0.0, "and not wound up again"


def test_a_goal_that_is_not_reached_alone_is_integrated_for_after_a_while():
    """Something holds against it: the proportional part comes no nearer, and would stand for ever."""
    servo = ForceServo(1.0)
    ticks = round(SETTINGS.integral_time / DT)
    nearing = [push(servo, 2.0 * 0.97**k) for k in range(ticks)]
    assert servo.integral(ONE) == 0.0, "it still comes nearer"
    assert nearing[-1] < 0.2 * nearing[0]
    for _ in range(ticks - 2):
        push(servo, 0.5)
    assert servo.integral(ONE) == 0.0
    held = [push(servo, 0.5) for _ in range(20)]
    assert held[-1] > held[0]
    assert servo.integral(ONE) > 0
    servo.keep([])
    push(servo, 0.5)
    assert servo.integral(ONE) == 0.0, "a new contact waits again"


def test_only_the_sum_with_what_is_wanted_besides_is_bounded():
    """A pull that alone asks for more than the bound holds the force off its goal until the integral outgrows it."""
    servo = ForceServo(0.02)
    limits = ActiveLimits()
    servo.push(SETTINGS, ONE, -1.0, DT, ActiveLimits())
    answers = [servo.push(SETTINGS, ONE, -1.0, DT, limits, feedforward=0.06) for _ in range(2000)]
    assert answers[0] == 0.02
    assert kinds(limits) == [LimitKind.POINT_SPEED]
    assert answers[-1] == -0.02
    held = servo.integral(ONE)
    assert -0.01 * (1 - held / 0.5) + 0.06 == pytest.approx(-0.02, abs=2e-4), "and stands at the other bound"


AIM = np.array([0.1, 0.0, -0.2])
POINT_DT = 0.005
POINT_SETTINGS = ControlSettings(force_gain=0.01, integral_time=1.0)


class Slow(PointVelocityScheme):
    """Nears a velocity in ten ticks' time, and presses."""

    def velocity(self, settings, contact, dt, limits):
        return self.lagged(contact, AIM, 10 * POINT_DT, dt)


def levels(rule, *contacts):
    zero = np.zeros(4)
    arm = ArmState(zero, zero, zero, PostureReference(bar(), Configuration(bar())), contacts, POINT_DT)
    return rule.levels(POINT_SETTINGS, contacts, arm, ActiveLimits())


def test_all_contacts_are_wanted_alike():
    free = contact()
    held = replace(contact(np.zeros(2)), id=2)
    [level] = levels(Slow(), free, held)
    assert np.array_equal(level.rows, np.concatenate([free.outward[None], held.move]))
    assert level.speed == pytest.approx(0.1 * np.array([AIM[2], *AIM])), "a tenth of the way in the first tick"


def test_the_velocity_wanted_is_remembered_by_contact_and_forgotten_with_it():
    rule = Slow()
    one = contact(np.zeros(2))
    for tick in range(1, 5):
        [level] = levels(rule, one)
        assert level.speed == pytest.approx((1 - 0.9**tick) * AIM)
    other = replace(one, id=2)
    [level] = levels(rule, other)
    assert level.speed == pytest.approx(0.1 * AIM), "another one starts at rest"
    [level] = levels(rule, one)
    assert level.speed == pytest.approx(0.1 * AIM), "and so does one that was lost"
    rule.reset()
    [level] = levels(rule, one)
    assert level.speed == pytest.approx(0.1 * AIM)


def test_a_time_constant_shorter_than_a_tick_is_none():
    assert Slow().lagged(contact(), AIM, 0.5 * POINT_DT, POINT_DT) is AIM


def test_the_force_s_integral_goes_with_its_contact():
    rule = Slow()
    one = replace(contact(), force_error=-1.0)
    pushes = []
    for _ in range(3):
        levels(rule, one)
        pushes.append(rule.push(POINT_SETTINGS, one, POINT_DT, ActiveLimits()))
    assert pushes == pytest.approx([-0.01 * (1 + POINT_DT * k) for k in (1, 2, 3)])
    levels(rule, replace(one, id=2))
    assert rule.push(POINT_SETTINGS, one, POINT_DT, ActiveLimits()) == pytest.approx(pushes[0])


def test_a_point_that_is_too_fast_is_slowed_and_that_is_said():
    limits = ActiveLimits()
    assert limit_point_speed(AIM, limits) is AIM
    assert kinds(limits) == []
    assert limit_point_speed(10 * AIM, limits) == pytest.approx(MAX_POINT_SPEED * AIM / np.linalg.norm(AIM))
    assert kinds(limits) == [LimitKind.POINT_SPEED]


REST = np.zeros(3)


def answer(levels: list[PriorityLevel], limits: ActiveLimits | None = None) -> np.ndarray:
    reference = PostureReference(bar(), Configuration(bar()))
    reference.lower = np.full(3, -9.0)
    reference.upper = np.full(3, 9.0)
    reference.max_speed = np.full(3, MAX_JOINT_SPEED)
    limits = ActiveLimits() if limits is None else limits
    arm = ArmState(REST, REST, REST, reference, (), 1.0)
    return QuadraticProgramScheme().solve(levels, ControlSettings(controller="qp"), (), arm, limits)


@pytest.mark.parametrize("gain", [0.003, 0.01, 0.03])
def test_a_weak_direction_is_damped_as_in_least_squares(gain):
    """Undamped it would ask for 0.05 m/s over the gain: 5 rad/s at the weakest."""
    outward = np.array([[gain, 0.0, 0.0]])
    along = np.array([[0.0, 0.5, 0.0]])
    levels = [PriorityLevel(outward, np.array([0.05])), PriorityLevel(along, np.array([0.02]))]
    limits = ActiveLimits()
    wanted, weak = solve_hierarchy(levels, REST, np.full(3, MAX_JOINT_SPEED))
    assert answer(levels, limits) == pytest.approx(wanted, rel=0.05, abs=1e-2)
    assert weak is not None
    assert weak in limits.found
    assert abs(answer(levels)[0]) <= MAX_JOINT_SPEED


def test_a_strong_one_is_not():
    levels = [PriorityLevel(np.array([[0.04, 0.0, 0.0]]), np.array([0.05]))]
    limits = ActiveLimits()
    assert answer(levels, limits)[0] == pytest.approx(0.05 / 0.04, rel=0.01)
    assert limits.found == ()


SCHEME_DT = 0.005
SCHEME_SETTINGS = ControlSettings(force_gain=0.01, integral_time=float("inf"), inertia_time=0.0, position_gain=5.0)
PLACE = np.array([0.003, -0.002])
SPEED = 5.0 * PLACE


def contact_with_goal(*, error=PLACE, force_error=1.0, id_=1, **changed) -> TaskContact:
    """On the forearm of our arm at home."""
    prepared = arm()
    robot = Configuration(prepared.robot)
    at = prepared.skin.taxel_point(int(prepared.skin.first[1]) + 40)
    pose = robot.pose(prepared.skin.link(at))
    normal = pose.rotation @ prepared.skin.normal(at)
    to_map = MapKinematics(prepared.map).jacobian(at, "smoothed", robot)
    to_map = to_map - np.outer(to_map @ normal, normal)  # so that nothing of the normal is in the tests' arithmetic
    return replace(
        TaskContact(
            id_, 3.0, force_error, normal, pose.points(prepared.skin.position(at)),
            robot.jacobian(prepared.skin.link(at), prepared.skin.position(at)), to_map, error, np.zeros(2),
        ),
        **changed,
    )  # fmt: skip


def state(contacts, *, start=None, speed=None, home=None) -> ArmState:
    robot = arm().robot
    zero = np.zeros(7)
    reference = PostureReference(robot, Configuration(robot))
    given = [zero if value is None else value for value in (home, speed)]
    return ArmState(robot.home if start is None else start, *given, reference, tuple(contacts), SCHEME_DT)


def scheme_answer(rule, *contacts, settings=SCHEME_SETTINGS, **said):
    limits = ActiveLimits()
    arm_state = state(contacts, **said)
    levels = rule.levels(settings, contacts, arm_state, limits)
    return rule.solve(levels, settings, contacts, arm_state, limits), limits


def slide(one, speed):
    """(2,) how the contact moves on the map."""
    return -one.to_map @ one.move @ speed


@pytest.mark.parametrize("kind", [HybridScheme, AdmittanceScheme, ParallelScheme, PriorityScheme])
def test_force_and_place_are_both_served(kind):
    speed, limits = scheme_answer(kind(), one := contact_with_goal())
    assert one.outward @ speed == pytest.approx(0.01, rel=1e-6)
    assert slide(one, speed) == pytest.approx(SPEED, rel=1e-6)
    assert kinds(limits) == []


def test_the_program_serves_both_nearly_and_accelerates_towards_it():
    one = contact_with_goal()
    speed = np.zeros(7)
    for _ in range(20):
        speed, _ = scheme_answer(QuadraticProgramScheme(), one, speed=speed)
    assert one.outward @ speed == pytest.approx(0.01, rel=0.02)
    assert slide(one, speed) == pytest.approx(SPEED, rel=0.05)


def test_projection_serves_the_force_and_takes_the_map_for_unstretched():
    one = contact_with_goal()
    speed, _ = scheme_answer(ProjectionScheme(), one)
    assert one.outward @ speed == pytest.approx(0.01, rel=1e-6)
    assert np.linalg.norm(one.move @ speed) == pytest.approx(np.hypot(0.01, np.linalg.norm(SPEED)), rel=1e-6)
    double = replace(one, to_map=2 * one.to_map)
    assert scheme_answer(ProjectionScheme(), double)[0] == pytest.approx(speed), "it knows no scale"
    assert scheme_answer(HybridScheme(), double)[0] != pytest.approx(scheme_answer(HybridScheme(), one)[0])


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_a_contact_that_may_slide_is_pushed_only(name):
    one = contact_with_goal(error=None)
    speed = np.zeros(7)
    for _ in range(10):
        speed, _ = scheme_answer(CONTROL_SCHEMES[name](), one, speed=speed)
    assert one.outward @ speed == pytest.approx(0.01, rel=0.02)
    least = one.outward / (one.outward @ one.outward) * 0.01
    assert speed == pytest.approx(least, abs=1e-3)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_two_contacts_are_served_together(name):
    other = contact_with_goal(error=None, force_error=-1.0, id_=2)
    other = replace(other, move=np.roll(other.move, 1, axis=1))
    first = contact_with_goal(error=None)
    speed = np.zeros(7)
    for _ in range(10):
        speed, _ = scheme_answer(CONTROL_SCHEMES[name](), first, other, speed=speed)
    assert [first.outward @ speed, other.outward @ speed] == pytest.approx([0.01, -0.01], rel=0.05)


def test_hybrid_keeps_position_out_of_force_and_a_wrong_normal_leaks():
    one = contact_with_goal(force_error=0.0)
    assert one.outward @ scheme_answer(HybridScheme(), one)[0] == pytest.approx(0, abs=1e-12)
    across = one.map_axes[0]
    wrong = replace(one, normal=np.cos(0.5) * one.normal + np.sin(0.5) * across)
    assert abs(one.normal @ one.move @ scheme_answer(HybridScheme(), wrong)[0]) > 1e-4


def test_admittance_and_parallel_take_up_a_speed_with_their_time_constant():
    settings = replace(SCHEME_SETTINGS, inertia_time=0.1)
    for kind in (AdmittanceScheme, ParallelScheme):
        rule = kind()
        one = contact_with_goal(error=None)
        pushed = [float(one.outward @ scheme_answer(rule, one, settings=settings)[0]) for _ in range(100)]
        expected = 0.01 * (1 - (1 - SCHEME_DT / 0.1) ** np.arange(1, 101))
        assert pushed == pytest.approx(list(expected), rel=1e-6)


def test_parallel_is_drawn_back_to_where_the_contact_began():
    rule = ParallelScheme()
    one = contact_with_goal(error=None, force_error=0.0)
    scheme_answer(rule, one)
    deeper = replace(one, point=one.point - 0.002 * one.normal)
    assert one.outward @ scheme_answer(rule, deeper)[0] == pytest.approx(5.0 * 0.002, rel=1e-6)
    rule.reset()
    assert not scheme_answer(rule, deeper)[0].any(), "it begins here"


def test_in_parallel_a_normal_that_turns_on_the_way_does_not_pull():
    """A contact led a quarter of the way round a body of 30 mm: along the first normal it would be 9 mm off."""
    rule = ParallelScheme()
    one = contact_with_goal(error=None, force_error=0.0)
    across = one.map_axes[0]
    pulls = []
    for turn in np.linspace(0.0, np.pi / 4, 400):
        normal = np.cos(turn) * one.normal + np.sin(turn) * across
        here = replace(one, normal=normal, point=one.point + 0.03 * (normal - one.normal))
        [level] = rule.levels(SCHEME_SETTINGS, (here,), state((here,)), ActiveLimits())
        pulls.append(float(level.speed[0]))
    assert np.abs(pulls).max() < 5.0 * 3e-5
    deeper = replace(here, point=here.point - 0.002 * normal)
    [level] = rule.levels(SCHEME_SETTINGS, (deeper,), state((deeper,)), ActiveLimits())
    assert float(level.speed[0]) == pytest.approx(5.0 * 0.002, abs=5.0 * 3e-5), "what goes along the normal still does"


def test_in_parallel_the_error_of_place_acts_across_the_normal_alone():
    one = contact_with_goal(force_error=0.0)
    tilted = replace(one, normal=np.cos(0.2) * one.normal + np.sin(0.2) * one.map_axes[0])
    [level] = ParallelScheme().levels(SCHEME_SETTINGS, (tilted,), state((tilted,)), ActiveLimits())
    assert tilted.normal @ level.speed == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(level.speed) > 0.5 * np.linalg.norm(SPEED)


@pytest.mark.parametrize("place_gain", [4.0, 20.0])
@pytest.mark.parametrize("way", [-0.2, 0.2])
def test_in_parallel_the_force_comes_to_its_goal_wherever_it_is_pressed_to(way, place_gain):
    """A spring whose far end goes 200 mm and then stands still: the integral leaves no error (Chiaverini and Sciavicco
    1993), although position asks for more speed than a point may have.
    """
    settings = replace(SCHEME_SETTINGS, position_gain=place_gain, integral_time=0.3, inertia_time=0.05)
    rule = ParallelScheme()
    one = contact_with_goal(error=None)
    goal = 3.0
    spring = 500.0
    moved = 0.0
    force = 3.0
    for tick in range(2000):
        ball = way * min(tick * SCHEME_DT / 5, 1.0)
        force = max(goal + spring * (ball + moved), 0.1)
        here = replace(one, force=force, force_error=goal - force, point=one.point + moved * one.normal)
        [level] = rule.levels(settings, (here,), state((here,)), ActiveLimits())
        moved += SCHEME_DT * float(level.speed[0])
    assert moved == pytest.approx(-way, abs=1e-5)
    assert force == pytest.approx(goal, abs=1e-3)


def test_priority_keeps_the_force_where_the_place_cannot_be_served():
    """Only motion along one direction is left: force and place want different speeds of it."""
    one = contact_with_goal()
    poor = replace(one, move=np.outer(one.normal + one.map_axes[0], np.eye(7)[0]))
    speed, _ = scheme_answer(PriorityScheme(), poor)
    assert poor.outward @ speed == pytest.approx(0.01, rel=1e-6)


def test_priority_goes_to_rest_with_what_is_left():
    home = np.full(7, 0.1)
    speed, _ = scheme_answer(PriorityScheme(), one := contact_with_goal(), home=home)
    assert slide(one, speed) == pytest.approx(SPEED, rel=1e-6)
    assert home @ speed > home @ scheme_answer(PriorityScheme(), one)[0]


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_speeds_are_bounded_and_it_is_said(name):
    one = contact_with_goal(force_error=-500.0, error=np.array([0.5, 0.5]))
    speed = np.zeros(7)
    for _ in range(100):
        speed, limits = scheme_answer(CONTROL_SCHEMES[name](), one, speed=speed)
        assert np.abs(speed).max() <= MAX_JOINT_SPEED * (1 + 1e-9)
    assert np.linalg.norm(one.move @ speed) <= 2 * MAX_POINT_SPEED * (1 + 1e-6)
    assert LimitKind.POINT_SPEED in limits


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_joints_at_their_limits_stay(name):
    lower, upper = joint_limits(arm().robot)
    one = contact_with_goal(force_error=-3.0)
    for edge in (np.where(np.isfinite(upper), upper, 0.0), np.where(np.isfinite(lower), lower, 0.0)):
        speed, limits = scheme_answer(CONTROL_SCHEMES[name](), one, start=edge)
        assert (speed[edge >= upper] <= 1e-12).all()
        assert (speed[edge <= lower] >= -1e-12).all()
        assert limits.found


def test_the_program_bounds_acceleration():
    speed, limits = scheme_answer(QuadraticProgramScheme(), contact_with_goal(force_error=-50.0))
    assert np.abs(speed).max() <= MAX_ACCELERATION * SCHEME_DT * (1 + 1e-6)
    assert LimitKind.JOINT_ACCELERATION in limits


def test_the_program_slows_down_before_a_limit():
    _, upper = joint_limits(arm().robot)
    one = contact_with_goal(force_error=-50.0)
    near = np.where(np.isfinite(upper), upper - 0.02, 0.0)
    speed = np.zeros(7)
    for _ in range(20):
        speed, _ = scheme_answer(QuadraticProgramScheme(), one, start=near, speed=speed)
    assert speed.max() <= MAX_JOINT_SPEED * 0.02 / 0.2 * (1 + 1e-6)


def test_the_program_keeps_every_contact_under_its_cap_whatever_the_task_wants():
    cap = CAP_SHARE * SCHEME_SETTINGS.max_force
    wanted = contact_with_goal(error=None, force_error=5.0)
    other = replace(contact_with_goal(error=None, id_=2), force=cap + 1.0)
    free, _ = scheme_answer(QuadraticProgramScheme(), wanted)
    limits = ActiveLimits()
    arm_state = state((wanted, other))
    rule = QuadraticProgramScheme()
    levels = rule.levels(SCHEME_SETTINGS, (wanted,), arm_state, limits)
    capped = rule.solve(levels, SCHEME_SETTINGS, (wanted,), arm_state, limits)
    assert wanted.outward @ free > 0
    assert other.outward @ capped < 0, "it backs off"
    assert LimitKind.FORCE_CAP in limits


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_a_reset_forgets_everything(name):
    settings = ControlSettings()
    rule = CONTROL_SCHEMES[name]()
    one = contact_with_goal(force_error=-1.0)
    first, _ = scheme_answer(rule, one, settings=settings)
    for _ in range(10):
        scheme_answer(rule, one, settings=settings)
    rule.reset()
    assert np.array_equal(scheme_answer(rule, one, settings=settings)[0], first)
