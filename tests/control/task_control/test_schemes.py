"""The force servo, and each control scheme by the errors it responds to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import (
    MAX_JOINT_SPEED,
    MAX_POINT_SPEED,
    PostureReference,
    joint_limits,
)
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.task_priority import (
    ArmState,
    ContactPresence,
    PriorityLevel,
    ShearGoal,
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
    PriorityScheme,
    ProjectionScheme,
    QuadraticProgramScheme,
)
from tactile_maps.core.errors import SimulationError
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK
from tests.support.limits import kinds
from tests.support.touch import arm, bar

ONE, TWO = ((number, ContactPresence.FELT) for number in (1, 2))
NO_INTEGRAL = float("inf")


class Servo(ForceServo):
    """A force servo with its settings."""

    def __init__(self, max_speed=1.0, integral_time=0.5):
        super().__init__(max_speed)
        self.settings = ControlSettings(force_gain=0.01, integral_time=integral_time)
        self.limits = ActiveLimits()

    def speeds(self, error, ticks=1, *, contact=ONE, feedforward=0.0):
        push = (
            self.push(self.settings, contact, error, TICK, self.limits, feedforward=feedforward) for _ in range(ticks)
        )
        return list(push)


def test_servo_is_proportional_until_the_goal_was_reached_then_also_integral():
    servo = Servo()
    assert servo.speeds(1.0, 3) == pytest.approx([0.01] * 3)
    assert servo.speeds(-1.0, 3) == pytest.approx([-0.01 * (1 + k * TICK / 0.5) for k in (1, 2, 3)])
    assert servo.integral(ONE) == pytest.approx(-3 * TICK)


def test_servo_has_an_integral_for_each_contact_until_it_is_lost():
    servo = Servo()
    servo.speeds(-1.0)
    servo.speeds(-2.0, contact=TWO)
    assert (servo.integral(ONE), servo.integral(TWO)) == pytest.approx((-TICK, -2 * TICK))
    servo.keep([TWO])
    assert (servo.integral(ONE), servo.integral(TWO)) == pytest.approx((0.0, -2 * TICK))
    assert servo.speeds(1.0) == pytest.approx([0.01]), "it has to reach its goal again"


@pytest.mark.parametrize(("held", "stuck"), [(True, frozenset()), (False, frozenset({1}))])
def test_integral_may_only_unwind_while_a_joint_or_the_contact_does_not_follow(held, stuck):
    servo = Servo()
    servo.speeds(-1.0)
    servo.held = held
    servo.stuck = stuck
    servo.speeds(-1.0, 10)
    assert servo.integral(ONE) == pytest.approx(-TICK)
    servo.speeds(0.5)
    assert servo.integral(ONE) == pytest.approx(-0.5 * TICK)


def test_saturated_servo_may_unwind_its_integral_but_not_wind_it_up():
    servo = Servo(0.02)
    servo.speeds(-1.0)
    assert servo.speeds(-50.0, 1000) == [-0.02] * 1000
    assert servo.integral(ONE) == pytest.approx(-TICK)
    assert kinds(servo.limits) == [LimitKind.POINT_SPEED]
    assert servo.speeds(1.0) == pytest.approx([0.01], rel=0.02), "free at once"
    servo.speeds(-1.0, 100)
    wound = servo.integral(ONE)
    servo.settings = replace(servo.settings, integral_time=0.05)
    assert servo.speeds(0.1) == [-0.02], "saturated by the integral alone"
    assert servo.integral(ONE) == pytest.approx(wound + 0.1 * TICK)
    servo.settings = replace(servo.settings, integral_time=0.5)
    assert servo.speeds(9.0, 20) == [0.02] * 20
    assert servo.integral(ONE) == 0.0, "not wound up again"


def test_servo_without_integral_keeps_the_previous_one():
    servo = Servo(0.02)
    servo.speeds(-1.0)
    servo.settings = replace(servo.settings, integral_time=NO_INTEGRAL)
    assert servo.speeds(-1.0, 4) == [-0.01] * 4
    assert servo.speeds(50.0, 100) == [0.02] * 100
    assert servo.integral(ONE) == pytest.approx(-TICK)


def test_servo_integrates_for_a_goal_that_the_proportional_part_does_not_reach():
    """Something opposes it: the error would stay."""
    servo = Servo()
    ticks = round(0.5 / TICK)
    for k in range(ticks):
        servo.speeds(2.0 * 0.97**k)
    assert servo.integral(ONE) == 0.0, "the error still decreases"
    servo.speeds(0.5, ticks - 2)
    assert servo.integral(ONE) == 0.0
    held = servo.speeds(0.5, 20)
    assert held[-1] > held[0]
    assert servo.integral(ONE) > 0
    servo.keep([])
    servo.speeds(0.5)
    assert servo.integral(ONE) == 0.0, "a new contact waits again"


def test_servo_saturates_the_sum_with_the_feedforward():
    """The integral cancels a feedforward above the bound, which keeps the force away from its goal."""
    servo = Servo(0.02)
    servo.speeds(-1.0)
    speeds = servo.speeds(-1.0, 2000, feedforward=0.06)
    assert (speeds[0], speeds[-1]) == (0.02, -0.02)
    assert kinds(servo.limits) == [LimitKind.POINT_SPEED]
    assert -0.01 * (1 - servo.integral(ONE) / 0.5) + 0.06 == pytest.approx(-0.02, abs=2e-4)


def program(levels, limits):
    """The solution of the quadratic program for three free joints."""
    reference = PostureReference(bar(), Configuration(bar()))
    reference.lower = np.full(3, -9.0)
    reference.upper = np.full(3, 9.0)
    reference.max_speed = np.full(3, MAX_JOINT_SPEED)
    rest = np.zeros(3)
    state = ArmState(rest, rest, rest, reference, (), 1.0)
    return QuadraticProgramScheme().solve(levels, ControlSettings(controller="qp"), (), state, limits)


@pytest.mark.parametrize("gain", [0.003, 0.01, 0.03, 0.04])
def test_quadratic_program_damps_weak_directions_as_least_squares_do(gain):
    """Undamped it would request 0.05 m/s over the gain: 5 rad/s at the weakest. The last one is strong enough."""
    outward, along = np.array([[gain, 0.0, 0.0]]), np.array([[0.0, 0.5, 0.0]])
    levels = [PriorityLevel(outward, np.array([0.05])), PriorityLevel(along, np.array([0.02]))]
    limits = ActiveLimits()
    expected, weak = solve_hierarchy(levels, np.zeros(3), np.full(3, MAX_JOINT_SPEED))
    found = program(levels, limits)
    assert found == pytest.approx(expected, rel=0.05, abs=1e-2)
    assert limits.found == (() if gain == 0.04 else (weak,))
    assert abs(found[0]) <= MAX_JOINT_SPEED


def test_quadratic_program_without_a_solution_is_reported_and_the_joints_slow_down():
    """Lever arms so long that rounding makes the costs concave."""
    limits = ActiveLimits()
    found = program([PriorityLevel(np.array([[1e20, 1e20 / 3, 0.0]]), np.array([0.05]))], limits)
    (limit,) = (one for one in limits.found if one.kind is LimitKind.NOT_SOLVED)
    assert limit_text(limit) == "slowing down: the quadratic program has no solution: the costs are not convex"
    assert not found.any()


def test_quadratic_program_rejects_numbers_that_are_not_finite():
    level = PriorityLevel(np.array([[0.3, 0.0, 0.0]]), np.array([np.nan]))
    with pytest.raises(SimulationError, match="not finite") as error:
        program([level], ActiveLimits())
    assert error.value.place == "costs"
    one = replace(sheared(2.0, error=None), force=np.nan)
    with pytest.raises(SimulationError, match="not finite") as error:
        Bench(QuadraticProgramScheme, replace(SETTINGS, friction_use=0.8, max_shear=1.0)).step(one)


SETTINGS = ControlSettings(force_gain=0.01, integral_time=NO_INTEGRAL, inertia_time=0.0, position_gain=5.0)
PLACE = np.array([0.003, -0.002])
SPEED = 5.0 * PLACE


def goal(*, error=PLACE, force_error=1.0, id_=1, **changed) -> TaskContact:
    """A contact on the forearm of the arm at home, by default with an error of position and of force."""
    prepared = arm()
    robot = Configuration(prepared.robot)
    at = prepared.skin.taxel_point(int(prepared.skin.first[1]) + 40)
    pose = robot.pose(prepared.skin.link(at))
    normal = pose.rotation @ prepared.skin.normal(at)
    to_map = MapKinematics(prepared.map).jacobian(at, "smoothed", robot)
    to_map = to_map - np.outer(to_map @ normal, normal)  # no part along the normal in the tests' arithmetic
    place = prepared.skin.position(at)
    move = robot.jacobian(prepared.skin.link(at), place)
    found = TaskContact(id_, 3.0, force_error, normal, pose.points(place), move, to_map, error, np.zeros(2))
    return replace(found, **changed)


class Bench:
    """A scheme on the arm: each step starts from the previous speed."""

    def __init__(self, kind, settings=SETTINGS, *, start=None, home=None):
        self.scheme = (CONTROL_SCHEMES[kind] if isinstance(kind, str) else kind)()
        self.settings = settings
        robot = arm().robot
        self.reference = PostureReference(robot, Configuration(robot))
        self.start = robot.home if start is None else start
        self.speed = np.zeros(7)
        self.home = self.speed if home is None else home

    def state(self, contacts):
        return ArmState(self.start, self.home, self.speed, self.reference, tuple(contacts), TICK)

    def step(self, *contacts, ticks=1, others=()):
        """The joint velocity after some ticks."""
        for _ in range(ticks):
            self.limits = ActiveLimits()
            state = self.state((*contacts, *others))
            levels = self.scheme.levels(self.settings, contacts, state, self.limits)
            self.speed = self.scheme.solve(levels, self.settings, contacts, state, self.limits)
        return self.speed

    def limits_of(self, contact):
        """The limits of a step."""
        self.step(contact)
        return self.limits

    def level(self, contact):
        """The speeds of the only level."""
        [level] = self.scheme.levels(self.settings, (contact,), self.state((contact,)), ActiveLimits())
        return level.speed


def slide(one, speed):
    """(2,) motion of the contact on the map."""
    return -one.to_map @ one.move @ speed


@pytest.mark.parametrize(
    ("kind", "within"),
    [
        (HybridScheme, 1e-6),
        (AdmittanceScheme, 1e-6),
        (ParallelScheme, 1e-6),
        (PriorityScheme, 1e-6),
        (QuadraticProgramScheme, 0.05),
    ],
)
def test_errors_of_force_and_position_are_both_corrected(kind, within):
    one = goal()
    bench = Bench(kind)
    speed = bench.step(one, ticks=20)
    assert one.outward @ speed == pytest.approx(0.01, rel=within)
    assert slide(one, speed) == pytest.approx(SPEED, rel=within)
    assert kinds(bench.limits) == []


@pytest.mark.parametrize("name", ["admittance", "hybrid", "parallel", "projection", "priority"])
@pytest.mark.parametrize("force_error", [1.0, 0.0, -1.0])
def test_force_is_corrected_where_a_weak_direction_is_oblique_to_the_skin(name, force_error):
    one = goal(force_error=force_error)
    along = one.normal @ one.move
    requested = one.along(SETTINGS, MAX_POINT_SPEED)
    oblique = (one.normal - requested / np.linalg.norm(requested)) / np.sqrt(2)
    weak = replace(one, move=one.move - 0.99 * np.outer(oblique, oblique @ one.move))
    assert np.linalg.norm(weak.outward) > 0.4 * np.linalg.norm(along), "the joints move the skin along its normal"
    bench = Bench(name)
    speed = bench.step(weak, ticks=20)
    assert LimitKind.WEAK_DIRECTION in kinds(bench.limits)
    assert weak.outward @ speed == pytest.approx(0.01 * force_error, abs=1e-9)


def test_projection_corrects_the_force_and_ignores_the_stretch_of_the_map():
    one = goal()
    speed = Bench(ProjectionScheme).step(one)
    assert one.outward @ speed == pytest.approx(0.01, rel=1e-6)
    assert np.linalg.norm(one.move @ speed) == pytest.approx(np.hypot(0.01, np.linalg.norm(SPEED)), rel=1e-6)
    double = replace(one, to_map=2 * one.to_map)
    assert Bench(ProjectionScheme).step(double) == pytest.approx(speed)
    assert Bench(HybridScheme).step(double) != pytest.approx(Bench(HybridScheme).step(one))


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_contact_that_may_slide_is_only_pushed(name):
    one = goal(error=None)
    speed = Bench(name).step(one, ticks=10)
    assert one.outward @ speed == pytest.approx(0.01, rel=0.02)
    assert speed == pytest.approx(one.outward / (one.outward @ one.outward) * 0.01, abs=1e-3)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_two_contacts_are_controlled_together(name):
    first = goal(error=None)
    other = goal(error=None, force_error=-1.0, id_=2, move=np.roll(first.move, 1, axis=1))
    speed = Bench(name).step(first, other, ticks=10)
    assert [first.outward @ speed, other.outward @ speed] == pytest.approx([0.01, -0.01], rel=0.05)


@pytest.mark.parametrize("kind", [HybridScheme, ProjectionScheme])
def test_contact_that_the_joints_hardly_move_does_not_drag_the_arm_along_the_skin_of_another(kind):
    """Its point would be moved straight along its normal, as fast as the joints can, with the other as the pivot."""
    first = goal(error=None, force_error=0.0)
    outward = np.outer(first.normal, first.outward)
    other = goal(error=None, force_error=-10.0, id_=2, move=np.roll(first.move - 0.99 * outward, 1, axis=1))
    other = replace(other, straight=True)
    bench = Bench(kind)
    speed = bench.step(first, other)
    assert LimitKind.WEAK_DIRECTION in kinds(bench.limits)
    levels = bench.scheme.levels(SETTINGS, (first, other), bench.state((first, other)), ActiveLimits())
    together, _ = solve_hierarchy(levels, np.zeros(7), bench.reference.max_speed)
    assert speed == pytest.approx(together)


def test_hybrid_motion_changes_the_force_only_if_the_normal_is_wrong():
    one = goal(force_error=0.0)
    assert one.outward @ Bench(HybridScheme).step(one) == pytest.approx(0, abs=1e-12)
    wrong = replace(one, normal=np.cos(0.5) * one.normal + np.sin(0.5) * one.map_axes[0])
    assert abs(one.normal @ one.move @ Bench(HybridScheme).step(wrong)) > 1e-4


@pytest.mark.parametrize("kind", [AdmittanceScheme, ParallelScheme])
def test_virtual_inertia_delays_the_speed_of_each_contact_by_its_time_constant(kind):
    bench = Bench(kind, replace(SETTINGS, inertia_time=0.1))
    one = goal(error=None)
    pushed = [float(one.outward @ bench.step(one)) for _ in range(100)]
    expected = 0.01 * (1 - (1 - TICK / 0.1) ** np.arange(1, 101))
    assert pushed == pytest.approx(list(expected), rel=1e-6)
    assert bench.level(replace(one, id=2)) == pytest.approx([0.05 * 0.01]), "a new contact starts at rest"
    assert bench.level(one) == pytest.approx([0.05 * 0.01]), "as does one that was lost"
    bench.settings = replace(SETTINGS, inertia_time=0.5 * TICK)
    assert bench.level(replace(one, id=3)) == pytest.approx([0.01]), "no lag below a tick"


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_soft_joint_compensation_is_not_delayed_by_virtual_inertia(name):
    """An observer of this velocity that sees it late alternates between its bounds from tick to tick."""
    one = goal()
    added = -0.01 * one.map_axes[0]
    with_added, without = (Bench(name, replace(SETTINGS, inertia_time=0.1)) for _ in range(2))
    for made_up in (added, added, np.zeros(3)):
        speeds = with_added.step(replace(one, made_up=made_up)), without.step(one)
        moved = one.map_axes @ one.move @ (speeds[0] - speeds[1])
        assert moved == pytest.approx(one.map_axes @ made_up, abs=5e-4 if name == "qp" else 1e-9)


def test_parallel_pulls_a_contact_back_to_its_start():
    bench = Bench(ParallelScheme)
    one = goal(error=None, force_error=0.0)
    bench.step(one)
    deeper = replace(one, point=one.point - 0.002 * one.normal)
    assert one.outward @ bench.step(deeper) == pytest.approx(5.0 * 0.002, rel=1e-6)
    bench.scheme.reset()
    assert not bench.step(deeper).any(), "it begins here"


def test_parallel_is_not_pulled_back_by_a_rotating_normal():
    """A contact moves a quarter of the way round a body of 30 mm: along the first normal it would be 9 mm off."""
    bench = Bench(ParallelScheme)
    one = goal(error=None, force_error=0.0)
    pulls = []
    for turn in np.linspace(0.0, np.pi / 4, 400):
        normal = np.cos(turn) * one.normal + np.sin(turn) * one.map_axes[0]
        here = replace(one, normal=normal, point=one.point + 0.03 * (normal - one.normal))
        pulls.append(float(bench.level(here)[0]))
    assert np.abs(pulls).max() < 5.0 * 3e-5
    deeper = replace(here, point=here.point - 0.002 * normal)
    assert bench.level(deeper) == pytest.approx([5.0 * 0.002], abs=5.0 * 3e-5), "motion along the normal still counts"


def test_parallel_corrects_errors_of_position_across_the_normal_only():
    one = goal(force_error=0.0)
    tilted = replace(one, normal=np.cos(0.2) * one.normal + np.sin(0.2) * one.map_axes[0])
    velocity = Bench(ParallelScheme).level(tilted)
    assert tilted.normal @ velocity == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(velocity) > 0.5 * np.linalg.norm(SPEED)


@pytest.mark.long
@pytest.mark.parametrize("position_gain", [4.0, 20.0])
@pytest.mark.parametrize("way", [-0.2, 0.2])
def test_parallel_force_error_converges_to_zero_wherever_the_contact_is_moved(way, position_gain):
    """A spring whose far end moves by 200 mm and stops: the integral leaves no error (Chiaverini and Sciavicco 1993),
    although position requests more speed than a point may have.
    """
    settings = replace(SETTINGS, position_gain=position_gain, integral_time=0.3, inertia_time=0.05)
    bench = Bench(ParallelScheme, settings)
    one = goal(error=None)
    moved = 0.0
    for tick in range(2000):
        end = way * min(tick * TICK / 5, 1.0)
        force = max(3.0 + 500.0 * (end + moved), 0.1)
        here = replace(one, force=force, force_error=3.0 - force, point=one.point + moved * one.normal)
        moved += TICK * float(bench.level(here)[0])
    assert moved == pytest.approx(-way, abs=1e-5)
    assert force == pytest.approx(3.0, abs=1e-3)


def test_priority_keeps_the_force_if_the_position_is_out_of_reach():
    """Only motion along one direction is left: force and position request different speeds of it."""
    one = goal()
    poor = replace(one, move=np.outer(one.normal + one.map_axes[0], np.eye(7)[0]))
    assert poor.outward @ Bench(PriorityScheme).step(poor) == pytest.approx(0.01, rel=1e-6)


def test_priority_returns_to_rest_with_the_remaining_freedom():
    home = np.full(7, 0.1)
    one = goal()
    speed = Bench(PriorityScheme, home=home).step(one)
    assert slide(one, speed) == pytest.approx(SPEED, rel=1e-6)
    assert home @ speed > home @ Bench(PriorityScheme).step(one)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_speeds_are_bounded_and_the_limit_is_reported(name):
    one = goal(force_error=-500.0, error=np.array([0.5, 0.5]))
    bench = Bench(name)
    for _ in range(100):
        assert np.abs(bench.step(one)).max() <= MAX_JOINT_SPEED * (1 + 1e-9)
    assert np.linalg.norm(one.move @ bench.speed) <= 2 * MAX_POINT_SPEED * (1 + 1e-6)
    assert LimitKind.POINT_SPEED in bench.limits


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_joints_at_their_limits_stay(name):
    lower, upper = joint_limits(arm().robot)
    for edge in (np.where(np.isfinite(upper), upper, 0.0), np.where(np.isfinite(lower), lower, 0.0)):
        bench = Bench(name, start=edge)
        speed = bench.step(goal(force_error=-3.0))
        assert (speed[edge >= upper] <= 1e-12).all()
        assert (speed[edge <= lower] >= -1e-12).all()
        assert bench.limits.found


def test_quadratic_program_bounds_acceleration_and_slows_down_before_a_joint_limit():
    _, upper = joint_limits(arm().robot)
    bench = Bench(QuadraticProgramScheme, start=np.where(np.isfinite(upper), upper - 0.02, 0.0))
    one = goal(force_error=-50.0)
    assert np.abs(bench.step(one)).max() <= MAX_ACCELERATION * TICK * (1 + 1e-6)
    assert LimitKind.JOINT_ACCELERATION in bench.limits
    assert bench.step(one, ticks=19).max() <= MAX_JOINT_SPEED * 0.02 / 0.2 * (1 + 1e-6)


def test_quadratic_program_keeps_every_contact_under_its_cap():
    one = goal(error=None, force_error=5.0)
    other = goal(error=None, id_=2, force=CAP_SHARE * SETTINGS.max_force + 1.0)
    assert one.outward @ Bench(QuadraticProgramScheme).step(one) > 0
    bench = Bench(QuadraticProgramScheme)
    assert other.outward @ bench.step(one, others=[other]) < 0, "it retreats"
    assert LimitKind.FORCE_CAP in bench.limits


def test_quadratic_program_keeps_caps_exactly_where_the_joints_can():
    """Both contacts are to be pressed harder than their caps allow."""
    near = CAP_SHARE * SETTINGS.max_force - 0.2
    first = goal(error=None, force=near, force_error=8.0)
    other = goal(error=None, id_=2, force=near, force_error=8.0, move=np.roll(first.move, 1, axis=1))
    bench = Bench(QuadraticProgramScheme)
    speed = bench.step(first, other, ticks=5)
    most = 0.2 / (CONTACT_STIFFNESS * TICK)
    assert [first.outward @ speed, other.outward @ speed] == pytest.approx([most, most], abs=1e-6)
    assert LimitKind.FORCE_CAP in bench.limits


def sheared(force, **changed) -> TaskContact:
    """A contact with a force along the first axis of the map [N] and a friction of 0.5."""
    one = goal(force_error=0.0, **changed)
    return replace(one, shear=force * one.map_axes[0], friction=0.5)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_skin_yields_to_force_above_the_shear_goal(name):
    one = replace(sheared(1.5, error=None), shear_goal=ShearGoal(np.array([0.5, -1.0])))
    moved = one.move @ Bench(name).step(one, ticks=10)
    assert one.map_axes @ moved == pytest.approx([0.01, 0.01], rel=0.05)
    assert one.normal @ moved == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(("force", "speed"), [(0.4, 0.0), (-1.5, -0.01)])
def test_force_within_the_slack_of_its_goal_does_not_move_the_skin(force, speed):
    one = replace(sheared(force, error=None), shear_goal=ShearGoal(np.zeros(2), slack=0.5))
    assert one.map_axes @ one.move @ Bench(HybridScheme).step(one) == pytest.approx([speed, 0.0], abs=1e-9)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_place_is_kept_perpendicular_to_the_shear_goal(name):
    one = replace(sheared(1.5), shear_goal=ShearGoal(np.array([0.5, 0.0])))
    still = replace(one, shear_goal=None)
    moved, usual = (one.map_axes @ c.move @ Bench(name).step(c, ticks=20) for c in (one, still))
    assert moved == pytest.approx([0.01, usual[1]], rel=0.05, abs=1e-4)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
@pytest.mark.parametrize("place", [None, np.array([0.003, -0.002])], ids=["free", "held"])
def test_contact_with_more_shear_than_the_limit_yields_and_the_limit_is_reported(name, place):
    one = sheared(2.0, error=place)
    bench = Bench(name, replace(SETTINGS, max_shear=1.2))
    speed = bench.step(one, ticks=10)
    assert one.map_axes[0] @ one.move @ speed >= 0.008 * (1 - 1e-3)
    assert Limit(LimitKind.SHEAR_CAP, value=pytest.approx(2.0), bound=1.2) in bench.limits.found
    below = Bench(name, replace(SETTINGS, max_shear=5.0))
    assert below.step(one) == pytest.approx(Bench(name).step(one), abs=1e-7)
    assert LimitKind.SHEAR_CAP not in below.limits


def test_quadratic_program_yields_along_the_skin_before_a_contact_slips():
    """2 N with a normal force of 3 N and a friction of 0.5 may use 0.8 of it, 1.2 N."""
    one = sheared(2.0, error=None)
    bench = Bench(QuadraticProgramScheme, replace(SETTINGS, friction_use=0.8))
    speed = bench.step(one, ticks=10)
    along = one.map_axes[0] @ one.move @ speed
    assert along + 0.4 * one.outward @ speed == pytest.approx(0.008, rel=1e-3)
    assert LimitKind.FRICTION_CAP in bench.limits
    assert LimitKind.FRICTION_CAP not in Bench(HybridScheme, bench.settings).limits_of(one)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_reset_discards_integrals_and_filter_states(name):
    bench = Bench(name, ControlSettings())
    one = goal(force_error=-1.0)
    first = bench.step(one)
    bench.step(one, ticks=10)
    bench.scheme.reset()
    bench.speed = np.zeros(7)
    assert np.array_equal(bench.step(one), first)
