"""Force that the skin does not measure, found from joint torques: against forces that the test applies by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tactile_maps.control.motion.unmeasured_force import (
    FILTER_TIME,
    FRICTION,
    PERSISTENCE,
    DriveTorques,
    UnmeasuredForce,
    UnmeasuredForceMonitor,
    _unexplained,
)
from tactile_maps.robots.kinematics import Configuration, kinematic_model
from tactile_maps.robots.model.robot import Joint, Robot
from tests.control.contacts import TICK, touch, touch_on
from tests.support.touch import arm, bar

HINGE_LIMIT = 1.5


def seen(
    robot: Robot, torque: np.ndarray, *, regions=(), posture=None, ticks: int = 60, latency: float = 0.0, **drives
) -> UnmeasuredForce:
    """Return what is found at rest where drives hold the joints against the torque (n,) of external forces.

    The first tick of the force is the second of ``ticks``.
    """
    monitor = UnmeasuredForceMonitor(robot)
    configuration = Configuration(robot)
    if posture is not None:
        configuration.update(posture)
    still = np.zeros(len(robot.joints))
    for _ in range(ticks):
        drive = DriveTorques(-torque, **drives)
        found = monitor.look(configuration, still, regions, drive, TICK, latency=latency)
    return found


def force_torque(robot: Robot, link: str, point, force) -> np.ndarray:
    """Joint torques (n,) of a force (3,) in the world at a point (3,) of a link frame, at home, by MuJoCo alone."""
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    body = model.body(link).id
    jacobian = np.zeros((3, model.nv))
    place = data.xmat[body].reshape(3, 3) @ point + data.xpos[body]
    mujoco.mj_jac(model, data, jacobian, None, place, body)
    return jacobian.T @ force


def test_force_at_the_end_of_the_bar_is_found_and_one_nearer_to_the_hinge_is_a_lower_bound():
    for x in (0.4, 0.2):
        found = seen(bar(), force_torque(bar(), "bar", (x, 0, -0.02), (0, 0, 60.0)))
        assert found.link == "bar"
        assert found.force == pytest.approx(0.98 * 60 * x / 0.4, rel=0.02), "its lever is at most 0.4 m"


def test_torques_whose_squares_vanish_have_a_force():
    """A finger may begin at a speed of 1e-252 m/s."""
    torque = force_torque(bar(), "bar", (0.4, 0, -0.02), (0, 0, 60.0))
    assert seen(bar(), 1e-200 * torque).force == pytest.approx(1e-200 * seen(bar(), torque).force)


def test_force_counts_as_measured_from_zero_to_the_reading():
    pressed = force_torque(bar(), "bar", (0.3, 0, 0.02), (0, 0, -20.0))
    assert seen(bar(), pressed, regions=touch(20.0)).force == 0
    assert seen(bar(), 0.3 * pressed, regions=touch(20.0)).force == 0, "the reading may be too high"
    assert seen(bar(), 1.2 * pressed, regions=touch(20.0)).force == 0, "and somewhat too low"
    assert seen(bar(), 4.0 * pressed, regions=touch(20.0)).force == pytest.approx(60 * 0.3 / 0.4, rel=0.15)


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.0, 4.0])
def test_friction_of_a_measured_contact_does_not_count(turn):
    """Friction turns the arm about its long axis, about which the measured normal force has no lever."""
    skin = arm().skin
    taxel = next(k for k in range(len(skin)) if skin.link(skin.taxel_point(k)) == "upper_arm")
    pressed = touch_on(arm().map, taxel, 12.0)
    normal = Configuration(arm().robot).pose("upper_arm").rotation @ pressed.link_normal
    along = np.cross(normal, [0.3, 0.5, 0.8])
    along /= np.linalg.norm(along)
    along = np.cos(turn) * along + np.sin(turn) * np.cross(normal, along)
    torque = force_torque(arm().robot, "upper_arm", pressed.link_position, 12.0 * (FRICTION * along - normal))
    assert seen(arm().robot, torque, regions=(pressed,)).force == 0
    hand = force_torque(arm().robot, "hand", np.zeros(3), (60.0, 0.0, 0.0))
    assert seen(arm().robot, torque + hand, regions=(pressed,)).force > 30, "60 N elsewhere still count"


@pytest.mark.parametrize("contacts", [1, 2, 4])
@pytest.mark.parametrize("joints", [1, 3, 7])
def test_part_left_by_contacts_is_that_of_bounded_least_squares(joints, contacts):
    """By ``scipy.optimize.lsq_linear``; some contacts have the same torques, and joints cannot tell all apart."""
    generator = np.random.default_rng(100 * joints + contacts)
    bounds = (np.tile([0.0, -1.0, -1.0], contacts), 1.0)
    for number in range(20):
        read = [10.0 ** generator.uniform(-2, 2) * generator.normal(size=(3, joints)) for _ in range(contacts)]
        read[-1] = read[0] if number % 4 == 0 else read[-1]
        external = 10.0 ** generator.uniform(-2, 2) * generator.normal(size=joints)
        columns = np.concatenate(read).T
        least = external - columns @ lsq_linear(columns, external, bounds=bounds, method="bvls").x
        left = _unexplained(external, read, np.zeros(joints))
        assert left == pytest.approx(least, abs=1e-6 * np.abs(external).max())


def test_force_counts_after_the_time_of_readings():
    torque = force_torque(bar(), "bar", (0.39, 0, -0.02), (0, 0, 60.0))
    for latency in (0.0, 0.05):
        first = next(n for n in range(2, 60) if seen(bar(), torque, ticks=n, latency=latency).force > 0)
        assert (first - 1) * TICK == pytest.approx(PERSISTENCE + 2 * latency, abs=TICK)


def found_in(forces: Sequence[float], *, latency: float = 0.0) -> list[float]:
    """Return what is found in each tick in which this force acts on the end of the bar [N]."""
    monitor = UnmeasuredForceMonitor(bar())
    configuration = Configuration(bar())
    torque = force_torque(bar(), "bar", (0.4, 0, -0.02), (0, 0, 1.0))
    drives = [DriveTorques(-force * torque) for force in forces]
    return [monitor.look(configuration, np.zeros(1), (), one, TICK, latency=latency).force for one in drives]


@pytest.mark.parametrize("latency", [0.0, 0.005, 0.04])
def test_rising_force_is_detected_within_the_delay_of_the_filter(latency):
    rate = 300.0
    forces = [rate * TICK * tick for tick in range(100)]
    late = [force - found for force, found in zip(forces, found_in(forces, latency=latency), strict=True)]
    assert max(late[60:]) < rate * (FILTER_TIME + TICK) + 0.02 * forces[-1]
    assert min(late) >= 0


def test_peak_on_a_lasting_force_adds_at_most_a_third():
    """The peak is that of an impact on the skin that is read ``latency`` later; the filter lengthens it."""
    latency = 0.02
    forces = [10.0] * 60 + [60.0] * round(latency / TICK) + [10.0] * 30
    found = found_in(forces, latency=latency)
    assert max(found) < 10.0 + 50.0 / 3
    assert found[50] == pytest.approx(9.8, rel=0.02)


def test_gravity_and_dry_friction_do_not_count():
    weight = 9.81 * 0.2
    drives = {"gravity": True}
    torque = force_torque(bar(), "bar", (0.2, 0, 0), (0, 0, -9.81))
    assert abs(torque[0]) == pytest.approx(weight)
    assert seen(bar(), torque, **drives).force == 0
    assert seen(bar(), torque).force > 4
    rough = replace(bar(), mjcf=bar().mjcf.replace('name="hinge"', 'name="hinge" frictionloss="2.5"'))
    assert seen(rough, torque, dry_friction=True).force == 0
    assert seen(rough, torque).force > 4


def test_joint_at_its_limit_is_excluded():
    torque = force_torque(bar(), "bar", (0.39, 0, -0.02), (0, 0, 60.0))
    assert seen(bar(), torque, posture=np.array([HINGE_LIMIT - 0.01])).force > 50
    assert seen(bar(), torque, posture=np.array([HINGE_LIMIT])).force == 0


def test_torque_of_a_joint_without_surface_does_not_count():
    joint = (
        '<body name="axle"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="spin" axis="1 0 0"/></body>'
    )
    text = bar().mjcf
    body = text.rindex("</body>")
    joints = (*bar().joints, Joint("spin", -np.inf, np.inf))
    robot = replace(bar(), mjcf=text[:body] + joint + text[body:], joints=joints, home=np.zeros(2))
    assert seen(robot, np.array([0.0, 1.0])).force == 0
    pressed = np.append(force_torque(bar(), "bar", (0.39, 0, -0.02), (0, 0, 60.0)), 1.0)
    assert seen(robot, pressed).force > 50, "the other joint still counts"


def test_coupled_joints_are_excluded():
    robot = arm().robot
    coupling = f'<equality><joint joint1="{robot.joints[0].name}" joint2="{robot.joints[3].name}"/></equality>'
    coupled = replace(robot, mjcf=robot.mjcf.replace("</mujoco>", f"{coupling}</mujoco>"))
    torque = np.zeros(len(robot.joints))
    torque[[0, 3]] = 40.0
    assert seen(robot, torque).force > 10
    assert seen(coupled, torque).force == 0


@pytest.mark.sampled(1)
@pytest.mark.parametrize("link", ["forearm", "wrist", "hand"])
def test_smallest_force_is_near_the_true_one_and_on_a_nearby_link(link):
    """Over points of the link's own mesh, where joints feel the force: the hull of the monitor is its own."""
    robot = arm().robot
    rng = np.random.default_rng(0)
    mesh = robot.link(link).mesh
    links = [one.name for one in robot.links]
    ratios = []
    for face in rng.choice(len(mesh.faces), 60, p=mesh.face_areas / mesh.face_areas.sum()):
        point = mesh.vertices[mesh.faces[face]].mean(axis=0)
        normal = mesh.face_normals[face]
        pose = Configuration(robot).pose(link)
        torque = force_torque(robot, link, point, -60.0 * (pose.rotation @ normal))
        if np.abs(torque).max() < 6.0:
            continue
        found = seen(robot, torque, ticks=30)
        assert abs(links.index(found.link) - links.index(link)) <= 2
        ratios.append(found.force / 60.0)
    assert len(ratios) > 30
    assert max(ratios) < 1.2
    assert np.median(ratios) > 0.8


def test_robot_without_joints_has_no_unmeasured_force():
    assert seen(bar(hinged=False), np.zeros(0)).force == 0


def test_reset_discards_the_force():
    monitor = UnmeasuredForceMonitor(bar())
    configuration = Configuration(bar())
    torque = force_torque(bar(), "bar", (0.39, 0, -0.02), (0, 0, 60.0))
    for _ in range(20):
        found = monitor.look(configuration, np.zeros(1), (), DriveTorques(-torque), TICK)
    assert found.force > 50
    monitor.reset()
    assert monitor.look(configuration, np.zeros(1), (), DriveTorques(-torque), TICK).force == 0
