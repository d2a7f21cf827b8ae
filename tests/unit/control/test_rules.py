"""How the laws with a task turn errors into joint velocities, one contact at a time, on our arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.admittance import Admittance
from app.control.command import ControlSettings
from app.control.gains import joint_limits
from app.control.hybrid import Hybrid
from app.control.laws import RULES
from app.control.map_sight import MapSight
from app.control.parallel import Parallel
from app.control.priority import Priority
from app.control.projection import Projection
from app.control.quadratic_program import CAP_SHARE, MAX_ACCELERATION, QuadraticProgram
from app.control.reference import MAX_JOINT_SPEED, MAX_SPEED, PostureReference
from app.control.rule import ArmState
from app.control.task_contact import TaskContact
from app.robots.configuration import Configuration
from tests.touch import arm

DT, SETTINGS = 0.005, ControlSettings(force_gain=0.01, integral_time=float("inf"), inertia_time=0.0, position_gain=5.0)
PLACE = np.array([0.003, -0.002])
SPEED = 5.0 * PLACE


def contact(*, error=PLACE, force_error=1.0, id_=1, **changed) -> TaskContact:
    """On the forearm of our arm at home."""
    prepared = arm()
    robot, at = Configuration(prepared.robot), prepared.skin.taxel_point(int(prepared.skin.first[1]) + 40)
    pose = robot.pose(prepared.skin.link(at))
    normal = pose.rotation @ prepared.skin.normal(at)
    to_map = MapSight(prepared.map).jacobian(at, "smoothed", robot)
    to_map = to_map - np.outer(to_map @ normal, normal)  # so that nothing of the normal is in the tests' arithmetic
    return replace(
        TaskContact(
            id_, 3.0, force_error, normal, pose.points(prepared.skin.position(at)),
            robot.jacobian(prepared.skin.link(at), prepared.skin.position(at)), to_map, error, np.zeros(2),
        ),
        **changed,
    )  # fmt: skip


def state(contacts, *, start=None, speed=None, home=None) -> ArmState:
    robot, zero = arm().robot, np.zeros(7)
    reference = PostureReference(robot, np.ones(7))
    given = [zero if value is None else value for value in (home, speed)]
    return ArmState(robot.home if start is None else start, *given, reference, tuple(contacts), DT)


def answer(rule, *contacts, settings=SETTINGS, **said):
    limits: list[str] = []
    arm_state = state(contacts, **said)
    levels = rule.levels(settings, contacts, arm_state, limits)
    return rule.solve(levels, settings, contacts, arm_state, limits), limits


def slide(one, speed):
    """(2,) how the contact moves on the map."""
    return -one.to_map @ one.move @ speed


@pytest.mark.parametrize("kind", [Hybrid, Admittance, Parallel, Priority])
def test_force_and_place_are_both_served(kind):
    speed, limits = answer(kind(), one := contact())
    assert one.outward @ speed == pytest.approx(0.01, rel=1e-6)
    assert slide(one, speed) == pytest.approx(SPEED, rel=1e-6)
    assert limits == []


def test_the_program_serves_both_nearly_and_accelerates_towards_it():
    one, speed = contact(), np.zeros(7)
    for _ in range(20):
        speed, _ = answer(QuadraticProgram(), one, speed=speed)
    assert one.outward @ speed == pytest.approx(0.01, rel=0.02)
    assert slide(one, speed) == pytest.approx(SPEED, rel=0.05)


def test_projection_serves_the_force_and_takes_the_map_for_unstretched():
    one = contact()
    speed, _ = answer(Projection(), one)
    assert one.outward @ speed == pytest.approx(0.01, rel=1e-6)
    assert np.linalg.norm(one.move @ speed) == pytest.approx(np.hypot(0.01, np.linalg.norm(SPEED)), rel=1e-6)
    double = replace(one, to_map=2 * one.to_map)
    assert answer(Projection(), double)[0] == pytest.approx(speed), "it knows no scale"
    assert answer(Hybrid(), double)[0] != pytest.approx(answer(Hybrid(), one)[0])


@pytest.mark.parametrize("name", RULES)
def test_a_contact_that_may_slide_is_pushed_only(name):
    one, speed = contact(error=None), np.zeros(7)
    for _ in range(10):
        speed, _ = answer(RULES[name](), one, speed=speed)
    assert one.outward @ speed == pytest.approx(0.01, rel=0.02)
    least = one.outward / (one.outward @ one.outward) * 0.01
    assert speed == pytest.approx(least, abs=1e-3)


@pytest.mark.parametrize("name", RULES)
def test_two_contacts_are_served_together(name):
    other = contact(error=None, force_error=-1.0, id_=2)
    other = replace(other, move=np.roll(other.move, 1, axis=1))
    first, speed = contact(error=None), np.zeros(7)
    for _ in range(10):
        speed, _ = answer(RULES[name](), first, other, speed=speed)
    assert [first.outward @ speed, other.outward @ speed] == pytest.approx([0.01, -0.01], rel=0.05)


def test_hybrid_keeps_position_out_of_force_and_a_wrong_normal_leaks():
    one = contact(force_error=0.0)
    assert one.outward @ answer(Hybrid(), one)[0] == pytest.approx(0, abs=1e-12)
    across = one.map_axes[0]
    wrong = replace(one, normal=np.cos(0.5) * one.normal + np.sin(0.5) * across)
    assert abs(one.normal @ one.move @ answer(Hybrid(), wrong)[0]) > 1e-4


def test_admittance_and_parallel_take_up_a_speed_with_their_time_constant():
    settings = replace(SETTINGS, inertia_time=0.1)
    for kind in (Admittance, Parallel):
        rule, one = kind(), contact(error=None)
        pushed = [float(one.outward @ answer(rule, one, settings=settings)[0]) for _ in range(100)]
        expected = 0.01 * (1 - (1 - DT / 0.1) ** np.arange(1, 101))
        assert pushed == pytest.approx(list(expected), rel=1e-6)


def test_parallel_is_drawn_back_to_where_the_contact_began():
    rule, one = Parallel(), contact(error=None, force_error=0.0)
    answer(rule, one)
    deeper = replace(one, point=one.point - 0.002 * one.normal)
    assert one.outward @ answer(rule, deeper)[0] == pytest.approx(5.0 * 0.002, rel=1e-6)
    rule.reset()
    assert not answer(rule, deeper)[0].any(), "it begins here"


def test_priority_keeps_the_force_where_the_place_cannot_be_served():
    """Only motion along one direction is left: force and place want different speeds of it."""
    one = contact()
    poor = replace(one, move=np.outer(one.normal + one.map_axes[0], np.eye(7)[0]))
    speed, _ = answer(Priority(), poor)
    assert poor.outward @ speed == pytest.approx(0.01, rel=1e-6)


def test_priority_goes_to_rest_with_what_is_left():
    home = np.full(7, 0.1)
    speed, _ = answer(Priority(), one := contact(), home=home)
    assert slide(one, speed) == pytest.approx(SPEED, rel=1e-6)
    assert home @ speed > home @ answer(Priority(), one)[0]


@pytest.mark.parametrize("name", RULES)
def test_speeds_are_bounded_and_it_is_said(name):
    one, speed = contact(force_error=-500.0, error=np.array([0.5, 0.5])), np.zeros(7)
    for _ in range(100):
        speed, limits = answer(RULES[name](), one, speed=speed)
        assert np.abs(speed).max() <= MAX_JOINT_SPEED * (1 + 1e-9)
    assert np.linalg.norm(one.move @ speed) <= 2 * MAX_SPEED * (1 + 1e-6)
    assert "speed of the touched point" in limits


@pytest.mark.parametrize("name", RULES)
def test_joints_at_their_limits_stay(name):
    lower, upper = joint_limits(arm().robot)
    one = contact(force_error=-3.0)
    for edge in (np.where(np.isfinite(upper), upper, 0.0), np.where(np.isfinite(lower), lower, 0.0)):
        speed, limits = answer(RULES[name](), one, start=edge)
        assert (speed[edge >= upper] <= 1e-12).all()
        assert (speed[edge <= lower] >= -1e-12).all()
        assert limits


def test_the_program_bounds_acceleration():
    speed, limits = answer(QuadraticProgram(), contact(force_error=-50.0))
    assert np.abs(speed).max() <= MAX_ACCELERATION * DT * (1 + 1e-6)
    assert "joint acceleration" in limits


def test_the_program_slows_down_before_a_limit():
    _, upper = joint_limits(arm().robot)
    one, near = contact(force_error=-50.0), np.where(np.isfinite(upper), upper - 0.02, 0.0)
    speed = np.zeros(7)
    for _ in range(20):
        speed, _ = answer(QuadraticProgram(), one, start=near, speed=speed)
    assert speed.max() <= MAX_JOINT_SPEED * 0.02 / 0.2 * (1 + 1e-6)


def test_the_program_keeps_every_contact_under_its_cap_whatever_the_task_wants():
    cap = CAP_SHARE * SETTINGS.max_force
    wanted = contact(error=None, force_error=5.0)
    other = replace(contact(error=None, id_=2), force=cap + 1.0)
    free, _ = answer(QuadraticProgram(), wanted)
    limits: list[str] = []
    arm_state = state((wanted, other))
    rule = QuadraticProgram()
    levels = rule.levels(SETTINGS, (wanted,), arm_state, limits)
    capped = rule.solve(levels, SETTINGS, (wanted,), arm_state, limits)
    assert wanted.outward @ free > 0
    assert other.outward @ capped < 0, "it backs off"
    assert "force cap" in limits


@pytest.mark.parametrize("name", RULES)
def test_a_reset_forgets_everything(name):
    settings, rule, one = ControlSettings(), RULES[name](), contact(force_error=-1.0)
    first, _ = answer(rule, one, settings=settings)
    for _ in range(10):
        answer(rule, one, settings=settings)
    rule.reset()
    assert np.array_equal(answer(rule, one, settings=settings)[0], first)
