"""Each controller by what it does, without a simulation."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.control.controller_registry import build_controller, effective_settings, has_task
from tactile_maps.control.controllers import CONTROL_SCHEMES, LOST_SPEED, Controller
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.task_priority import ContactPresence
from tactile_maps.control.path_following import slide_observer
from tactile_maps.control.task_control.tasks import SHEAR_TASKS, TaskManager
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, observed, touch, touch_on
from tests.support.limits import kinds
from tests.support.touch import BAR_INERTIA, arm, prepared_bar

FORCE_CONTROLLERS = ["hold_force", *CONTROL_SCHEMES]
TWO_SIDES = (*touch(9.0), *touch(9.0, id_=2, normal=(0, 0, -1)))


class Bench:
    """A controller with its settings; the posture stays unless ``follows``."""

    def __init__(self, name, posture=(0.0,), *, prepared=None, follows=False, **settings):
        self.prepared = prepared or prepared_bar()
        map_kinematics = MapKinematics(self.prepared.map)
        self.controller: Controller = build_controller(name, self.prepared.robot, TaskManager(), map_kinematics)
        self.settings = ControlSettings(name, **settings)
        self.posture = np.array(posture)
        self.follows = follows

    def step(self, contacts=(), *, ticks=1, velocity=0.0, readable=True):
        """The last command."""
        for _ in range(ticks):
            seen = observed(self.posture, contacts, velocity=velocity, readable=readable)
            command = self.controller.command(self.settings, seen)
            self.posture = command.posture if self.follows else self.posture
        return command

    def moved(self, contacts):
        """Outward speed of the point of contact by one command [m/s]."""
        before = self.controller._reference.start_posture(self.posture)
        return float((before - self.step(contacts).posture)[0]) * 0.3 / TICK

    @property
    def limits(self):
        return self.controller.why_limited


@pytest.mark.parametrize("name", CHOICES["controller"])
def test_untouched_arm_at_home_stays_there(name):
    robot = arm().robot
    bench = Bench(name, robot.home, prepared=arm())
    bench.controller.reset()
    command = bench.step()
    assert np.array_equal(command.posture, robot.home)
    assert (command.stiffness > 0).all()
    assert (command.damping >= 0).all(), "the joints have damping of their own"
    assert {limit.kind for limit in bench.limits} <= {LimitKind.JOINT_RESPONSE}
    assert np.array_equal(bench.controller.rest, robot.home)


@pytest.mark.parametrize("name", CHOICES["controller"])
def test_robot_without_joints_gets_an_empty_command(name):
    bench = Bench(name, (), prepared=prepared_bar(hinged=False))
    assert [bench.step(contacts).posture.shape for contacts in ((), touch(9.0), ())] == [(0,)] * 3


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_too_much_force_moves_the_point_inward_and_too_little_outward(name):
    for force, sign in ((6.0, 1), (1.0, -1)):
        assert sign * Bench(name).step(touch(force), ticks=20).posture[0] > 1e-4, "inward is positive about +y"


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_joint_gains_follow_the_posture(name):
    robot = arm().robot
    configuration = Configuration(robot)
    for posture in (robot.home, robot.home + 0.5):
        configuration.update(posture)
        command = Bench(name, posture, prepared=arm()).step()
        assert np.sqrt(command.stiffness / configuration.inertia()) == pytest.approx(np.full(7, 40.0))


def test_impedance_holds_the_rest_posture_with_its_gains():
    bench = Bench("impedance", stiffness=5.0, damping_ratio=0.5)
    for rest in (0.0, 0.4):
        bench.controller.rest = np.array([rest])
        for posture in (0.0, 0.3):
            bench.posture = np.array([posture])
            command = bench.step()
            assert command.posture == [rest]
            assert command.stiffness == pytest.approx(25 * BAR_INERTIA)
            assert command.damping == pytest.approx(2 * 0.5 * 5 * BAR_INERTIA)
        bench.controller.reset()
        assert (bench.controller.rest, bench.limits) == ([rest], ())


def hold_force(**settings):
    return Bench("hold_force", **{"force_goal": 3.0, "force_gain": 0.01, "integral_time": 0.5, **settings})


def test_hold_force_is_proportional_and_after_the_goal_was_reached_integral():
    bench = hold_force()
    assert hold_force().moved(touch(3.0)) == 0
    assert hold_force().moved(touch(2.0)) == pytest.approx(0.01), "no integral yet"
    speeds = [bench.moved(touch(4.0)) for _ in range(20)]
    assert speeds == pytest.approx([-0.01 * (1 + (k + 1) * TICK / 0.5) for k in range(20)], rel=1e-9)
    assert bench.moved(touch(2.0)) < 0.01, "the integral still pushes back"
    assert bench.moved(touch(2.0, id_=2)) == pytest.approx(0.01), "a new contact starts without it"


def test_hold_force_retreats_from_every_contact_above_the_goal():
    """Both act on the one joint at the same lever: the mean of what both require."""
    first = touch(7.0)
    together = hold_force().moved((*first, *touch(5.0, id_=2)))
    assert together == pytest.approx(hold_force().moved(touch(6.0)), rel=1e-9)
    assert hold_force().moved((*first, *touch(2.0, id_=2))) == hold_force().moved(first)


def test_hold_force_moves_no_joint_faster_than_its_limit():
    for x in (0.001, 0.02, 0.05, 0.1, 0.2, 0.3):
        assert abs(hold_force().moved(touch(200.0, x=x))) <= 0.3 * MAX_JOINT_SPEED * (1 + 1e-9)
    bench = hold_force()
    bench.step(touch(4.0, x=0.02))
    assert bench.limits == (), "short levers are fast enough for small errors"
    bench.step(touch(12.0, x=0.02))
    [limit] = bench.limits
    assert limit.kind is LimitKind.WEAK_DIRECTION
    assert limit.bound == pytest.approx(0.02 * MAX_JOINT_SPEED)
    assert limit.direction == pytest.approx((0.0, 0.0, -1.0)), "inward"


@pytest.mark.parametrize(("contacts", "readable"), [(touch(float("nan")), True), ((), False)])
def test_hold_force_does_not_move_on_unreadable_skin(contacts, readable):
    bench = hold_force()
    before = bench.step(touch(4.0)).posture
    assert bench.step(contacts, readable=readable).posture == pytest.approx(before, abs=1e-12)
    assert bench.limits == (Limit(LimitKind.SKIN_UNREADABLE),)
    assert np.isfinite(bench.moved(touch(4.0)))


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_one_of_two_opposed_contacts_is_relieved_and_the_other_is_reported(name):
    bench = Bench(name, jacobian="raw")  # the normals of the contacts
    command = bench.step(TWO_SIDES, ticks=400)
    (limit,) = (one for one in bench.limits if one.kind is LimitKind.CONTACTS_OPPOSED)
    assert (limit.names, limit.value, limit.bound) == (("bar",), 9.0, 3.0)
    assert command.posture[0] > 0.1, "away from the first"
    if bench.controller.report is not None:
        assert bench.controller.report.controlled == (1,)


@pytest.mark.parametrize("name", CONTROL_SCHEMES)
def test_retreat_from_opposed_contacts_stays_between_them_and_no_integral_grows(name):
    bench = Bench(name, jacobian="raw", task="retreat")
    command = bench.step(TWO_SIDES, ticks=400)
    assert LimitKind.CONTACTS_OPPOSED in kinds(bench.limits)
    assert bench.controller.report.controlled == ()
    assert np.abs(command.posture).max() < 1e-9
    integrals = [bench.controller._scheme._servo.integral((id_, ContactPresence.FELT)) for id_ in (1, 2)]
    assert min(integrals) >= -9.0 * 0.35, "no growth after the report"


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_contact_that_joints_move_too_slowly_is_reported(name):
    bench = Bench(name, jacobian="raw")
    bench.step(touch(9.0, normal=(0, 1, 0)), ticks=100)
    assert Limit(LimitKind.CONTACT_IMMOBILE, ("bar",), value=9.0, bound=3.0) in bench.limits


@pytest.mark.long
@pytest.mark.parametrize(("task", "stays"), [("keep_force", False), ("guide", True), ("retreat", True)])
def test_untouched_arm_returns_to_rest_or_stays_by_task(task, stays):
    bench = Bench("hybrid", [0.5], follows=True, task=task)
    assert bench.step().posture == pytest.approx(0.5, abs=1e-3)
    assert (abs(bench.step(ticks=800).posture[0]) > 0.4) == stays


@pytest.mark.long
def test_return_after_a_lost_contact_is_slow_and_reported():
    """The lost contact may be in the way."""
    bench = Bench("hybrid", [0.5], follows=True)
    bench.step(touch(3.0))
    speeds = []
    for _ in range(1600):
        before = bench.posture
        posture = bench.step().posture
        speeds.append(abs(posture[0] - before[0]) / TICK)
        assert {LimitKind.SLOW_HOMING, LimitKind.CONTACT_LOST} & set(kinds(bench.limits)) or abs(posture[0]) < 0.011
    assert max(speeds[100:]) == pytest.approx(LOST_SPEED, rel=0.01)


def test_energy_tank_slows_down_an_arm_that_gives_energy():
    """An object yields without end under the goal force."""
    bench = Bench("hybrid", force_goal=20.0, force_gain=0.015)
    speeds = []
    for _ in range(200):
        bench.step(touch(15.0), velocity=-0.25 / 0.3)  # outward
        speeds.append(float(bench.controller._speed[0]))
    assert speeds[0] == pytest.approx(-0.25, abs=0.01), "0.015 m/s per newton at 0.3 m"
    assert speeds[-1] == pytest.approx(0.0, abs=1e-6)
    assert LimitKind.ENERGY_TANK in kinds(bench.limits)
    assert bench.controller.tank.given == pytest.approx(15.0 * 0.25 * 1.0, rel=0.05)
    bench.step(touch(25.0))
    assert bench.controller._speed[0] > 0, "it may always retreat"
    bench.step(ticks=200)
    assert bench.controller.tank.given == 0.0, "a new contact starts with a full tank"


def arm_bench(name="hybrid", **settings):
    """The arm at home, and contacts of 3 N on two neighbouring taxels of its forearm."""
    prepared = arm()
    pairs = prepared.skin.neighbours
    taxels = pairs[pairs[:, 0] > prepared.skin.first[1] + 40][0]
    bench = Bench(name, prepared.robot.home, prepared=prepared, **settings)
    return bench, *(touch_on(prepared.map, int(taxel), 3.0) for taxel in taxels)


@pytest.mark.parametrize(
    ("skin", "slides", "share"),
    [(1, False, -1), (0, True, -1), (1, True, 0)],
    ids=["drags the skin", "slides", "rests"],
)
def test_energy_given_along_the_skin_equals_the_work_on_the_touching_body(skin, slides, share):
    """A hand with 2 N along the skin: it moves with the skin, over skin at rest, or rests while the skin moves."""
    bench, one, _ = arm_bench(task="guide")
    configuration = Configuration(bench.prepared.robot)
    pose = configuration.pose(one.link)
    axis = np.cross(one.link_normal, [0.3, 0.5, 0.8])
    axis /= np.linalg.norm(axis)
    shear = ContactShear(tuple(2.0 * axis), 0.0, 0.0, 1.0, Slip.STICKING, 0.5, estimated=False)
    one = replace(one, shear=shear)
    bench.step((one,))
    before = bench.controller.tank.given
    way = 1e-4 * pose.rotation @ axis
    posture = bench.posture + skin * np.linalg.pinv(configuration.jacobian(one.link, one.link_position)) @ way
    on_skin = 1e-4 * axis * (slides * (1 - 2 * skin))
    bench.posture = posture
    bench.step((replace(one, link_position=one.link_position + on_skin),))
    given = bench.controller.tank.given - before
    assert given == pytest.approx(share * 2.0 * 1e-4, abs=2e-7)


def test_empty_tank_slows_down_motion_against_a_force_along_the_skin():
    """The arm leads a contact along a path, against 2 N of an object that it moves."""
    shares = []
    for sign in (1, -1):
        bench, one, _ = arm_bench(task="hold_point")
        target = bench.prepared.map.to_map(one.at) + [0.005, 0.0]
        bench.settings = replace(bench.settings, path=(tuple(map(float, target)),))
        bench.step((one,))
        speed = bench.controller._speed
        move = Configuration(bench.prepared.robot).jacobian(one.link, one.link_position) @ speed
        local = Configuration(bench.prepared.robot).pose(one.link).rotation.T @ move
        local -= one.link_normal * (one.link_normal @ local)
        force = tuple(-sign * 2.0 * local / np.linalg.norm(local))
        bench.controller.tank.level = 0.0
        bench.step((replace(one, shear=ContactShear(force, 0.0, 0.0, 1.0, Slip.STICKING, 0.5, estimated=False)),))
        shares.append(np.abs(bench.controller._speed).max() / np.abs(speed).max())
    assert shares[0] == 0.0, "the object resists"
    assert shares[1] > 0.5, "the object pulls"


@pytest.mark.parametrize(("friction", "limited"), [(0.5, True), (0.9, False)])
def test_force_along_the_skin_is_limited_by_the_friction_of_its_contact(friction, limited):
    """With 3 N and 0.8 of the friction, 2 N along the skin need a friction of 0.83."""
    bench, one, _ = arm_bench("qp", friction_use=0.8)
    along = np.cross(one.link_normal, [0.3, 0.5, 0.8])
    force = tuple(2.0 * along / np.linalg.norm(along))
    bench.step((replace(one, shear=ContactShear(force, 0.0, 0.0, 1.0, Slip.STICKING, friction, estimated=False)),))
    assert (LimitKind.FRICTION_CAP in kinds(bench.limits)) == limited


def test_contact_that_moves_along_with_the_skin_may_slide():
    bench, here, there = arm_bench(task="hold_point", follows=True)
    bench.step((here,))
    bench.step((there,), ticks=11)
    assert np.abs(bench.controller._speed).max() > 0.01
    bench.step((there,), ticks=389)
    assert bench.controller._speed == pytest.approx(np.zeros(7), abs=1e-9)
    assert bench.limits == (Limit(LimitKind.CONTACT_STICKS),)


@pytest.mark.parametrize(("pitch", "share"), [(0.01, 1.0), (0.015, 0.0)], ids=["fine taxels", "coarse taxels"])
def test_contact_that_lags_on_a_path_is_moved_faster_on_fine_taxels(pitch, share):
    """It does not move for 0.2 s: the arm makes more than the speed of the path and the gain times the error."""
    bench, touched, _ = arm_bench(task="follow_path", path_kind="polyline")
    bench.controller.map_kinematics.pitch = pitch
    start = touched.map_point
    bench.settings = replace(bench.settings, path=(tuple(start), tuple(start + [0.03, 0.0])))
    bench.step((touched,), ticks=40)
    configuration = Configuration(bench.prepared.robot)
    move = configuration.jacobian(touched.link, touched.link_position)
    to_map = bench.controller.map_kinematics.jacobian(touched.at, bench.settings.jacobian, configuration)
    made = -to_map @ (move @ bench.controller._speed)
    requested = bench.settings.path_speed + bench.settings.position_gain * bench.controller.report.error
    assert (made[0] - requested) / bench.settings.path_speed == pytest.approx(share, abs=0.7 * share + 0.05)
    bench.step()
    assert bench.controller._slide.missing == pytest.approx([0.0, 0.0]), "discarded with the contact"


@pytest.mark.parametrize("step", [(0.03, 0.0), (0.0, 0.03)])
def test_contact_that_lags_is_moved_faster_on_strongly_curved_skin(monkeypatch, step):
    """The bound grows with the curvature of the skin along the path; the arm's smallest radius is 36 mm."""
    radius = 0.06
    monkeypatch.setattr(slide_observer, "ROLLING_RADIUS", radius)
    bench, touched, _ = arm_bench(task="follow_path", path_kind="polyline")
    bench.controller.map_kinematics.pitch = 0.01
    start = touched.map_point
    bench.settings = replace(bench.settings, path=(tuple(start), tuple(start + step)))
    bench.step((touched,), ticks=160)
    kinematics = bench.controller.map_kinematics
    to_map = kinematics.jacobian(touched.at, bench.settings.jacobian, Configuration(bench.prepared.robot))
    factor = max(1.0, radius * kinematics.curvature(touched, np.array(step), to_map))
    assert np.linalg.norm(bench.controller._slide.missing) == pytest.approx(bench.settings.path_speed * factor)


def test_quadratic_program_caps_contacts_without_a_goal():
    """The second contact stays under its cap, although the first should be pressed harder."""
    bench = Bench("qp", max_force=40.0, force_goal=20.0)
    bench.step(touch(1.0))
    bench.step((*touch(33.0, id_=2), *touch(1.0)), ticks=3)  # accelerations are bounded too
    assert LimitKind.FORCE_CAP in kinds(bench.limits)
    assert bench.controller._speed[0] > 0, "away from it"


OTHER = {
    "stiffness": 20.0,
    "damping_ratio": 0.3,
    "force_goal": 2.0,
    "force_gain": 0.03,
    "integral_time": 0.1,
    "position_gain": 9.0,
    "inertia_time": 0.3,
    "jacobian": "raw",
    "path_kind": "raster",
    "path_size": 0.1,
    "path_speed": 0.1,
    "max_force": 3.5,
    "max_impact": 5.0,
    "friction_use": 0.5,
    "shear_goal": 0.5,
    "shear_direction": 1.0,
    "shear_threshold": 0.1,
    "max_shear": 0.2,
}
SHEAR = ("shear_goal", "shear_direction", "shear_threshold", "max_shear")
"""Controllers that require taxels with three axes."""


def commands(settings: ControlSettings, *, sheared: bool) -> np.ndarray:
    """The commands of a controller while a contact wanders and presses, and is pulled to and fro."""
    pulls = [ContactShear((x, 0.7 * x, 0.1), 0.0, 0.5, 1.0, Slip.STICKING, 0.5, estimated=False) for x in (0.3, -0.3)]
    bench, here, there = arm_bench(settings.controller)
    bench.settings = settings
    bench.posture = bench.posture + 0.02
    rows = []
    for tick in range(40):
        touched = replace(
            here if tick < 20 else there, force=1.0 + 0.1 * tick, shear=pulls[tick % 2] if sheared else None
        )
        command = bench.step((touched,), velocity=0.01)
        rows.append(np.concatenate([command.posture, command.stiffness, command.damping]))
    return np.array(rows)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("task", CHOICES["task"])
@pytest.mark.parametrize("controller", CHOICES["controller"])
def test_exactly_the_effective_settings_change_the_commands(controller, task):
    settings = ControlSettings(controller=controller, task=task)
    apart = {"controller", "task", "path", "starts", "gains"}  # the controller manager uses the gains mode
    assert {*OTHER, *apart} == set(asdict(settings))
    if has_task(controller) and task in SHEAR_TASKS:
        settings = replace(settings, shear_goal=1.0)
    usual = {sheared: commands(settings, sheared=sheared) for sheared in (False, True)}
    for name, value in OTHER.items():
        if name in ("max_force", "max_impact", "friction_use"):  # the controller manager uses them
            continue
        sheared = name in SHEAR
        same = np.array_equal(commands(replace(settings, **{name: value}), sheared=sheared), usual[sheared])
        assert same == (name not in effective_settings(settings)), f"{name} under {controller}, {task}"


def test_path_size_is_effective_until_a_path_is_drawn():
    settings = ControlSettings(controller="qp", task="follow_path")
    assert "path_size" in effective_settings(settings)
    assert "path_size" not in effective_settings(replace(settings, path=((0.0, 0.0), (0.1, 0.0))))
