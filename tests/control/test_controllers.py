"""Every controller answers the same question; each by what it does."""

from __future__ import annotations

import inspect
from dataclasses import asdict, replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.controller_registry import build_controller, effective_settings, has_task
from tactile_maps.control.controllers import (
    CONTROL_SCHEMES,
    LOST_SPEED,
    Controller,
    HoldForceController,
    ImpedanceController,
    TaskController,
)
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.joint_impedance import HOME_SPEED, MAX_JOINT_SPEED, MAX_LEAD, MAX_POINT_SPEED
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.task_priority import ContactPresence
from tactile_maps.control.task_control.schemes import HybridScheme, QuadraticProgramScheme
from tactile_maps.control.task_control.tasks import TaskManager
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts_by_hand import TICK, touch, touch_on
from tests.support.limits import kinds
from tests.support.touch import BAR_INERTIA, arm, bar, prepared_bar


def controller_of(name, prepared) -> Controller:
    return build_controller(name, prepared.robot, TaskManager(), MapKinematics(prepared.map))


@pytest.mark.parametrize("name", CHOICES["controller"])
def test_a_law_keeps_the_protocol(name):
    robot = arm().robot
    controller = controller_of(name, arm())
    for method in ("reset", "start", "command"):
        said, wanted = (inspect.signature(getattr(kind, method)).parameters for kind in (type(controller), Controller))
        assert list(said) == list(wanted)
    controller.reset()
    command = controller.command(ControlSettings(controller=name), Observation(robot.home, np.zeros(7), (), TICK))
    assert np.array_equal(command.posture, robot.home), "at home, untouched, it wants to stay"
    assert (command.stiffness > 0).all()
    assert (command.damping >= 0).all(), "the joints have damping of their own"
    assert {limit.kind for limit in controller.why_limited} <= {LimitKind.JOINT_RESPONSE}
    assert np.array_equal(controller.rest, robot.home)


@pytest.mark.parametrize("name", [controller for controller in CHOICES["controller"] if controller != "impedance"])
def test_too_much_force_moves_the_point_inwards_and_too_little_outwards(name):
    for force, sign in ((6.0, 1), (1.0, -1)):
        controller = controller_of(name, prepared_bar())
        for _ in range(20):
            command = controller.command(
                ControlSettings(controller=name), Observation(np.zeros(1), np.zeros(1), touch(force), TICK)
            )
        assert sign * command.posture[0] > 1e-4, "down, away from the finger, is positive about +y"


@pytest.mark.rotating
@pytest.mark.parametrize("task", CHOICES["task"])
@pytest.mark.parametrize("name", CHOICES["controller"])
def test_every_law_does_every_task_within_its_bounds(name, task):
    prepared = arm()
    settings = ControlSettings(controller=name, task=task, force_goal=3.0)
    controller = controller_of(name, prepared)
    posture = prepared.robot.home
    taxel = int(prepared.skin.first[1]) + 40
    for tick in range(60):
        regions = (touch_on(prepared.map, taxel, 1.0 + 0.2 * tick),) if tick < 50 else ()
        command = controller.command(settings, Observation(posture, np.zeros(7), regions, TICK))
        assert np.isfinite(command.torque_at(posture, np.zeros(7))).all()
        assert np.abs(command.posture - posture).max() < 0.31
    assert all(limit_text(limit) for limit in controller.why_limited)


@pytest.mark.parametrize("name", CHOICES["controller"])
def test_a_robot_without_joints_gets_an_empty_command(name):
    controller = controller_of(name, prepared_bar(hinged=False))
    empty = np.zeros(0)
    for regions in ((), touch(9.0), ()):
        assert controller.command(
            replace(ControlSettings(), controller=name), Observation(empty, empty, regions, TICK)
        ).posture.shape == (0,)


def test_it_holds_home_whatever_the_posture():
    robot = bar()
    controller = ImpedanceController(robot)
    settings = ControlSettings(stiffness=5.0, damping_ratio=0.5)
    for posture in (np.zeros(1), np.ones(1)):
        command = controller.command(settings, Observation(posture, posture, (), 0.005))
        assert np.array_equal(command.posture, robot.home)
        assert command.stiffness == pytest.approx(25 * BAR_INERTIA)
        assert command.damping == pytest.approx(2 * 0.5 * 5 * BAR_INERTIA)
    controller.reset()
    assert controller.why_limited == ()


def test_it_holds_the_rest_posture_it_is_given():
    controller = ImpedanceController(bar())
    controller.rest = np.array([0.4])
    assert controller.command(ControlSettings(), Observation(np.zeros(1), np.zeros(1), (), 0.005)).posture == [0.4]
    controller.reset()
    assert controller.rest == [0.4]


def test_impedance_of_a_robot_without_joints_is_an_empty_command():
    empty = np.zeros(0)
    assert ImpedanceController(bar(hinged=False)).command(
        ControlSettings(), Observation(empty, empty, (), 0.005)
    ).posture.shape == (0,)


SETTINGS = ControlSettings(controller="hold_force", force_goal=3.0, force_gain=0.01, integral_time=0.5)
NO_VELOCITY = np.zeros(1)
HOLD_TICK = 0.005


def touch_along_the_bar(force, *, x=0.3, id_=1, normal=(0, 0, 1)):
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    place = np.array([x, 0, 0.02])
    return (ContactRegion(id_, np.array([0]), force, 1e-4, 1e4, np.zeros(2), at, "bar", place, np.asarray(normal)),)


def moved(controller, regions, *, settings=SETTINGS, posture=NO_VELOCITY):
    """How far one command moves the wanted posture."""
    before = controller._reference.start_posture(posture)
    return float(
        (controller.command(settings, Observation(posture, NO_VELOCITY, regions, HOLD_TICK)).posture - before)[0]
    )


def test_it_retreats_from_too_much_and_advances_into_too_little():
    """Down, away from the finger, is positive about +y: one newton too much moves the point at the gain."""
    assert moved(HoldForceController(bar()), touch_along_the_bar(4.0)) * 0.3 == pytest.approx(
        0.01 * (1 + 1 * HOLD_TICK / 0.5) * HOLD_TICK, rel=1e-9
    )
    assert moved(HoldForceController(bar()), touch_along_the_bar(2.0)) * 0.3 == pytest.approx(
        -0.01 * HOLD_TICK, rel=1e-9
    ), "no integral yet"
    assert moved(HoldForceController(bar()), touch_along_the_bar(3.0)) == 0


def test_the_integral_grows_with_a_constant_error_once_the_goal_was_reached():
    controller = HoldForceController(bar())
    speeds = [moved(controller, touch_along_the_bar(4.0)) * 0.3 / HOLD_TICK for _ in range(20)]
    assert speeds == pytest.approx([0.01 * (1 + (k + 1) * HOLD_TICK / 0.5) for k in range(20)], rel=1e-9)
    assert moved(controller, touch_along_the_bar(2.0)) > -0.01 * HOLD_TICK / 0.3, "what was gathered still pushes back"
    assert moved(controller, touch_along_the_bar(2.0, id_=2)) == pytest.approx(-0.01 * HOLD_TICK / 0.3), (
        "a new contact starts without it"
    )


def test_it_retreats_from_every_contact_above_the_goal():
    """Both act on the one joint at the same lever: the mean of what both require."""
    both = (*touch_along_the_bar(7.0), *touch_along_the_bar(5.0, id_=2))
    alone, together = (moved(HoldForceController(bar()), regions) for regions in (touch_along_the_bar(6.0), both))
    assert together == pytest.approx(alone, rel=1e-9)
    first = touch_along_the_bar(7.0)
    light = touch_along_the_bar(2.0, id_=2)
    assert moved(HoldForceController(bar()), (*first, *light)) == moved(HoldForceController(bar()), first)


@pytest.mark.parametrize("name", ["hold_force", *CONTROL_SCHEMES])
def test_of_contacts_on_both_sides_of_a_joint_one_is_relieved_and_the_other_is_named(name):
    controller = controller_of(name, prepared_bar())
    both = (*touch(9.0), *touch(9.0, id_=2, normal=(0, 0, -1)))
    settings = ControlSettings(controller=name, jacobian="raw")  # the normals of the contacts
    for _ in range(400):
        command = controller.command(settings, Observation(STILL, STILL, both, TICK))
    (limit,) = (one for one in controller.why_limited if one.kind is LimitKind.CONTACTS_OPPOSED)
    assert (limit.names, limit.value, limit.bound) == (("bar",), 9.0, 3.0)
    assert command.posture[0] > 0.1, "away from the first"
    if controller.report is not None:
        assert controller.report.controlled == (1,)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_a_retreat_from_both_sides_of_a_joint_stays_between_them_and_no_integral_grows(name):
    controller = controller_of(name, prepared_bar())
    both = (*touch(9.0), *touch(9.0, id_=2, normal=(0, 0, -1)))
    settings = ControlSettings(controller=name, jacobian="raw", task="retreat")
    for _ in range(400):
        command = controller.command(settings, Observation(STILL, STILL, both, TICK))
    assert LimitKind.CONTACTS_OPPOSED in kinds(controller.why_limited)
    assert controller.report.controlled == ()
    assert np.abs(command.posture).max() < 1e-9
    gathered = [controller._scheme._servo.integral((contact, ContactPresence.FELT)) for contact in (1, 2)]
    assert min(gathered) >= -9.0 * 0.35, "nothing after they were named"


@pytest.mark.parametrize("name", ["hold_force", *CONTROL_SCHEMES])
def test_a_contact_that_no_joint_moves_is_named(name):
    controller = controller_of(name, prepared_bar())
    for _ in range(100):
        settings = ControlSettings(controller=name, jacobian="raw")
        controller.command(settings, Observation(STILL, STILL, touch(9.0, normal=(0, 1, 0)), TICK))
    assert Limit(LimitKind.CONTACT_IMMOBILE, ("bar",), value=9.0, bound=3.0) in controller.why_limited


def test_a_lost_contact_forgets_the_integral():
    controller = HoldForceController(bar())
    for _ in range(20):
        moved(controller, touch_along_the_bar(4.0))
    moved(controller, ())
    assert moved(controller, touch_along_the_bar(2.0)) * 0.3 == pytest.approx(-0.01 * HOLD_TICK, rel=1e-9)


def test_speed_is_bounded_without_windup_and_says_so():
    controller = HoldForceController(bar())
    step = moved(controller, touch_along_the_bar(200.0))
    assert step * 0.3 == pytest.approx(MAX_POINT_SPEED * HOLD_TICK)
    assert controller.why_limited == (Limit(LimitKind.POINT_SPEED),)
    assert controller._servo.integral((1, ContactPresence.FELT)) == 0


def test_no_joint_is_faster_than_its_limit():
    controller = HoldForceController(bar())
    for x in (0.001, 0.02, 0.05, 0.1, 0.2, 0.3):
        controller.reset()
        assert abs(moved(controller, touch_along_the_bar(200.0, x=x))) <= MAX_JOINT_SPEED * HOLD_TICK * (1 + 1e-9)
    controller.reset()
    moved(controller, touch_along_the_bar(4.0, x=0.02))
    assert controller.why_limited == (), "short levers are fast enough for small errors"
    moved(controller, touch_along_the_bar(12.0, x=0.02))
    assert kinds(controller.why_limited) == [LimitKind.WEAK_DIRECTION]
    [limit] = controller.why_limited
    assert limit.bound == pytest.approx(0.02 * MAX_JOINT_SPEED)
    assert limit.direction == pytest.approx((0.0, 0.0, -1.0)), "inward"


def test_a_push_along_the_axis_moves_nothing():
    controller = HoldForceController(bar())
    assert moved(controller, touch_along_the_bar(9.0, normal=(0, 1, 0))) == 0
    assert kinds(controller.why_limited) == [LimitKind.WEAK_DIRECTION]


def test_a_joint_at_its_limit_stays_and_says_so():
    controller = HoldForceController(bar())
    edge = np.array([1.5])
    assert moved(controller, touch_along_the_bar(9.0), posture=edge) == 0
    assert LimitKind.JOINT_LIMIT in kinds(controller.why_limited)
    controller.reset()
    assert moved(controller, touch_along_the_bar(1.0), posture=edge) < 0, "away from the limit it is free"


def test_it_does_not_run_ahead_of_an_arm_that_is_held_back():
    controller = HoldForceController(bar())
    for _ in range(500):
        controller.command(SETTINGS, Observation(NO_VELOCITY, NO_VELOCITY, touch_along_the_bar(9.0), HOLD_TICK))
    assert controller._reference.desired[0] == pytest.approx(MAX_LEAD)
    assert LimitKind.HELD_BACK in kinds(controller.why_limited)


def test_it_starts_from_the_posture_it_finds_and_goes_home_gently():
    controller = HoldForceController(bar())
    posture = np.array([1.0])
    postures = [float(controller.command(SETTINGS, Observation(posture, NO_VELOCITY, (), HOLD_TICK)).posture[0])]
    assert postures[0] == pytest.approx(1.0, abs=1e-3), "no jolt"
    for _ in range(2000):
        posture = np.array([postures[-1]])
        postures.append(
            float(controller.command(SETTINGS, Observation(posture, NO_VELOCITY, (), HOLD_TICK)).posture[0])
        )
    speed = np.diff(postures) / HOLD_TICK
    assert np.abs(speed).max() <= HOME_SPEED * (1 + 1e-9)
    assert np.abs(np.diff(speed)).max() / HOLD_TICK < HOME_SPEED / 0.15, "smooth start and end"
    assert postures[-1] == pytest.approx(0, abs=1e-4)


def test_a_reading_that_is_no_number_moves_nothing_and_is_said():
    controller = HoldForceController(bar())
    moved(controller, touch_along_the_bar(4.0))
    assert moved(controller, touch_along_the_bar(float("nan"))) == 0
    assert controller.why_limited == (Limit(LimitKind.SKIN_UNREADABLE),)
    assert np.isfinite(moved(controller, touch_along_the_bar(4.0)))


def test_a_skin_that_cannot_be_read_moves_nothing_and_is_said():
    controller = HoldForceController(bar())
    moved(controller, touch_along_the_bar(4.0))
    start = controller._reference.desired.copy()
    command = controller.command(SETTINGS, Observation(NO_VELOCITY, NO_VELOCITY, (), HOLD_TICK, readable=False))
    assert command.posture == pytest.approx(start, abs=1e-12)
    assert controller.why_limited == (Limit(LimitKind.SKIN_UNREADABLE),)


def test_no_integral_at_all_can_be_asked_for():
    endless = ControlSettings(controller="hold_force", force_gain=0.01, integral_time=float("inf"))
    controller = HoldForceController(bar())
    assert [moved(controller, touch_along_the_bar(4.0), settings=endless) for _ in range(5)] == pytest.approx(
        [0.01 * HOLD_TICK / 0.3] * 5
    )


def test_hold_force_of_a_robot_without_joints_is_an_empty_command():
    controller = HoldForceController(bar(hinged=False))
    empty = np.zeros(0)
    for regions in ((), touch_along_the_bar(9.0), ()):
        assert controller.command(SETTINGS, Observation(empty, empty, regions, HOLD_TICK)).posture.shape == (0,)


BAR = prepared_bar()
STILL = np.zeros(1)
BENT = np.array([0.5])


def controller_on(prepared=BAR) -> TaskController:
    return TaskController(prepared.robot, HybridScheme(), TaskManager(), MapKinematics(prepared.map))


def test_too_much_force_stops_it_softly_where_it_is():
    settings = ControlSettings(controller="hybrid", max_force=30.0)
    manager = ControllerManager(BAR.robot, BAR.map, settings)
    before = manager.command(Observation(BENT, STILL, touch(10.0), TICK))
    command = manager.command(Observation(BENT, STILL, touch(31.0), TICK))
    assert manager.why_limited == (Limit(LimitKind.STOPPED_BY_FORCE, value=31.0, bound=30.0),)
    assert command.posture == BENT
    assert (command.stiffness < 0.1 * before.stiffness).all()
    for _ in range(600):
        manager.command(Observation(STILL, STILL, touch(1.0), TICK))  # it gives way
    for _ in range(210):
        command = manager.command(Observation(STILL, STILL, (), TICK))
    assert manager.why_limited == ()
    assert abs(command.posture[0]) < 0.01, "it goes on from where it is"


@pytest.mark.parametrize(("task", "stays"), [("keep_force", False), ("guide", True), ("retreat", True)])
def test_after_the_touch_it_goes_home_or_stays(task, stays):
    controller = controller_on()
    posture = BENT
    for tick in range(800):
        posture = controller.command(
            ControlSettings(controller="hybrid", task=task), Observation(posture, STILL, (), TICK)
        ).posture
        assert tick or posture == pytest.approx(BENT, abs=1e-3)
    assert (abs(posture[0]) > 0.4) == stays


def test_after_a_contact_was_lost_for_good_it_comes_home_slowly_and_says_so():
    """What it lost may stand in the way."""
    controller = controller_on()
    settings = ControlSettings(controller="hybrid")
    posture = BENT
    controller.command(settings, Observation(posture, STILL, touch(3.0), TICK))
    steps = []
    for _ in range(1600):
        before = posture
        posture = controller.command(settings, Observation(posture, STILL, (), TICK)).posture
        steps.append(abs(posture[0] - before[0]) / TICK)
        told = set(kinds(controller.why_limited)) & {LimitKind.SLOW_HOMING, LimitKind.CONTACT_LOST}
        assert told or abs(posture[0]) < 0.011
    assert max(steps[100:]) == pytest.approx(LOST_SPEED, rel=0.01)


def test_giving_energy_for_long_is_slowed_to_nothing_and_said():
    """Something gives way for ever under the goal force."""
    controller = controller_on()
    settings = ControlSettings(controller="hybrid", force_goal=20.0, force_gain=0.015)
    posture = STILL
    speeds = []
    velocity = np.array([-0.25 / 0.3])  # outward
    for _ in range(200):
        command = controller.command(settings, Observation(posture, velocity, touch(15.0), TICK))
        speeds.append(float(controller._speed[0]))
    assert speeds[0] == pytest.approx(-0.25, abs=0.01), "0.015 m/s per newton at 0.3 m"
    assert speeds[-1] == pytest.approx(0.0, abs=1e-6)
    assert LimitKind.ENERGY_TANK in kinds(controller.why_limited)
    assert controller.tank.given == pytest.approx(15.0 * 0.25 * 1.0, rel=0.05)
    controller.command(settings, Observation(posture, STILL, touch(25.0), TICK))
    assert controller._speed[0] > 0, "it may always retreat"
    for _ in range(200):
        controller.command(settings, Observation(posture, STILL, (), TICK))
    assert controller.tank.given == 0.0, "a new contact starts with a full tank"
    assert command.posture.shape == (1,)


def test_a_contact_that_goes_along_with_the_skin_is_let_slide():
    prepared = arm()
    controller = controller_on(prepared)
    posture = prepared.robot.home
    pairs = prepared.skin.neighbours
    here, there = (int(taxel) for taxel in pairs[pairs[:, 0] > prepared.skin.first[1] + 40][0])
    settings = ControlSettings(controller="hybrid", task="hold_point")
    controller.command(settings, Observation(posture, np.zeros(7), (touch_on(prepared.map, here, 3.0),), TICK))
    speeds = []
    for _ in range(400):
        posture = controller.command(
            settings, Observation(posture, np.zeros(7), (touch_on(prepared.map, there, 3.0),), TICK)
        ).posture
        speeds.append(np.abs(controller._speed).max())
    assert speeds[10] > 0.01
    assert speeds[-1] == pytest.approx(0, abs=1e-9)
    assert controller.why_limited == (Limit(LimitKind.CONTACT_STICKS),)


@pytest.mark.parametrize(("pitch", "share"), [(0.01, 1.0), (0.015, 0.0)], ids=["fine taxels", "coarse taxels"])
def test_a_contact_that_falls_short_on_a_path_is_led_faster_on_fine_taxels(pitch, share):
    """It does not move for 0.2 s: the arm makes more than the speed of the path and the gain times the error."""
    prepared = arm()
    controller = controller_on(prepared)
    posture = prepared.robot.home
    still = np.zeros(7)
    controller.map_kinematics.pitch = pitch
    touched = touch_on(prepared.map, int(prepared.skin.first[1]) + 40, 3.0)
    start = touched.map_point
    path = (tuple(start), tuple(start + [0.03, 0.0]))
    settings = ControlSettings(controller="hybrid", task="follow_path", path_kind="polyline", path=path)
    for _ in range(40):
        controller.command(settings, Observation(posture, still, (touched,), TICK))
    configuration = Configuration(prepared.robot)
    configuration.update(posture)
    move = configuration.jacobian(touched.link, touched.link_position)
    to_map = MapKinematics(prepared.map).jacobian(touched.at, settings.jacobian, configuration)
    made = -to_map @ (move @ controller._speed)
    asked = settings.path_speed + settings.position_gain * controller.report.error
    assert (made[0] - asked) / settings.path_speed == pytest.approx(share, abs=0.7 * share + 0.05)
    controller.command(settings, Observation(posture, still, (), TICK))
    assert controller._slide.missing == pytest.approx([0.0, 0.0]), "forgotten with the contact"


def test_a_rule_is_told_of_contacts_that_the_task_is_not_about():
    """The program keeps the second one under its cap, though the first should be pressed more."""
    controller = TaskController(BAR.robot, QuadraticProgramScheme(), TaskManager(), MapKinematics(BAR.map))
    settings = ControlSettings(controller="qp", max_force=40.0, force_goal=20.0)
    controller.command(settings, Observation(STILL, STILL, touch(1.0), TICK))
    for _ in range(3):  # accelerations are bounded too
        controller.command(settings, Observation(STILL, STILL, (*touch(33.0, id_=2), *touch(1.0)), TICK))
    assert LimitKind.FORCE_CAP in kinds(controller.why_limited)
    assert controller._speed[0] > 0, "away from it"


def test_every_limit_is_said_once():
    controller = controller_on()
    for _ in range(5):
        controller.command(
            ControlSettings(controller="hybrid", max_force=200.0), Observation(STILL, STILL, touch(100.0), TICK)
        )
        assert len(set(kinds(controller.why_limited))) == len(controller.why_limited) > 0


OTHER = {
    "stiffness": 20.0, "damping_ratio": 0.3, "force_goal": 2.0, "force_gain": 0.03, "integral_time": 0.1,
    "position_gain": 9.0, "inertia_time": 0.3, "jacobian": "raw", "path_kind": "raster", "path_size": 0.1,
    "path_speed": 0.1, "max_force": 3.5,
}  # fmt: skip


def answers(settings: ControlSettings) -> np.ndarray:
    """What a controller asks of the joints while a contact wanders to and fro and presses, and once it is lost."""
    prepared = arm()
    controller = build_controller(settings.controller, prepared.robot, TaskManager(), MapKinematics(prepared.map))
    pairs = prepared.skin.neighbours
    posture = prepared.robot.home + 0.02
    rows = []
    here, there = (int(taxel) for taxel in pairs[pairs[:, 0] > prepared.skin.first[1] + 40][0])
    for tick in range(40):
        regions = (touch_on(prepared.map, here if tick < 20 else there, 1.0 + 0.1 * tick),)
        command = controller.command(settings, Observation(posture, np.full(7, 0.01), regions, TICK))
        rows.append(np.concatenate([command.posture, command.stiffness, command.damping]))
    return np.array(rows)


@pytest.mark.rotating
@pytest.mark.parametrize("task", CHOICES["task"])
@pytest.mark.parametrize("controller", CHOICES["controller"])
def test_what_is_heeded_makes_a_difference_and_nothing_else_does(controller, task):
    settings = ControlSettings(controller=controller, task=task)
    assert {*OTHER, "controller", "task", "path", "starts", "gains"} == set(
        asdict(settings)
    )  # gains: the controller's matter
    usual = answers(settings)
    # The monitor of a controller without a task is around it, see the controller manager.
    for name, value in OTHER.items():
        if name == "max_force" and not has_task(controller):
            continue
        same = np.array_equal(answers(replace(settings, **{name: value})), usual)
        assert same == (name not in effective_settings(settings)), f"{name} under {controller}, {task}"


def test_the_size_of_a_path_counts_until_one_is_drawn():
    settings = ControlSettings(controller="qp", task="follow_path")
    assert "path_size" in effective_settings(settings)
    assert "path_size" not in effective_settings(replace(settings, path=((0.0, 0.0), (0.1, 0.0))))


def test_laws_with_a_task_are_choices():
    assert set(CONTROL_SCHEMES) < set(CHOICES["controller"])
    assert all("task" in effective_settings(ControlSettings(controller=controller)) for controller in CONTROL_SCHEMES)


@pytest.mark.parametrize("name", [controller for controller in CHOICES["controller"] if controller != "impedance"])
def test_joint_gains_follow_the_posture(name):
    robot = arm().robot
    controller = controller_of(name, arm())
    configuration = Configuration(robot)
    for posture in (robot.home, robot.home + 0.5):
        configuration.update(posture)
        command = controller.command(ControlSettings(controller=name), Observation(posture, np.zeros(7), (), TICK))
        assert np.sqrt(command.stiffness / configuration.inertia()) == pytest.approx(np.full(7, 40.0))
