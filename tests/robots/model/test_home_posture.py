"""Home postures of robots whose file states none."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.home_posture import LEAST_MARGIN, motion_tilts, point_motion
from tactile_maps.robots.model.robot import Robot
from tests.support.generated_robots import ROBOTS, arm, chain, load, model

OUTERMOST = {
    "small arm": ["link6"],
    "arm": ["link6"],
    "large arm": ["link6"],
    "leg": ["link3"],
    "hand": [f"finger{number}_link4" for number in range(3)],
}


def evenness(robot: Robot, link: str, posture: np.ndarray) -> float:
    configuration = Configuration(robot)
    configuration.update(posture)
    mesh = robot.link(link).mesh
    assert mesh is not None
    middle = mesh.vertices.mean(axis=0)
    gains = np.linalg.svd(configuration.jacobian(link, middle), compute_uv=False)
    return gains[-1] / gains[0]


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_straight_limb_gets_a_posture_away_from_limits_and_singularities(name, tmp_path):
    robot = load(ROBOTS[name], tmp_path)
    finding = next(finding for finding in robot.findings if finding.kind == "home-chosen")
    moved = [joint.name for joint, home in zip(robot.joints, robot.home, strict=True) if home != 0]
    assert finding.count == len(moved) > 0
    assert finding.where == ", ".join(moved)
    assert "State home" in finding.action
    for joint, home in zip(robot.joints, robot.home, strict=True):
        assert joint.lower + LEAST_MARGIN * (joint.upper - joint.lower) <= home
        assert home <= joint.upper - LEAST_MARGIN * (joint.upper - joint.lower)
    for link in OUTERMOST[name]:
        assert evenness(robot, link, np.zeros(len(robot.joints))) < 0.02
        assert evenness(robot, link, robot.home) > 0.1


@pytest.mark.long
def test_choice_is_repeated_exactly_and_independent_of_size(tmp_path):
    robots = [load(ROBOTS[name], tmp_path) for name in ("arm", "arm", "small arm", "large arm")]
    assert np.array_equal(robots[0].home, robots[1].home)
    for robot in robots[2:]:
        assert robot.home == pytest.approx(robots[0].home, abs=1e-6)


@pytest.mark.long
def test_irrelevant_joints_stay_at_zero(tmp_path):
    assert load(ROBOTS["arm"], tmp_path).home[0] == 0.0  # the first turns the whole arm


def test_arm_above_the_ground_bends_upwards(tmp_path):
    side = f'<body name="side" euler="0 1.5707963 0">{chain("zyyzyz", 0.2)}</body>'
    homes = []
    for height in (0.3, 5.0):
        robot = load(model(side, height=height), tmp_path)
        homes.append(robot.home)
        configuration = Configuration(robot)
        lowest = [
            configuration.pose(link.name).points(link.mesh.vertices)[:, 2].min() for link in robot.links if link.mesh
        ]
        assert min(lowest) > 0
    assert not np.array_equal(*homes), "far from the ground it bends downwards"


def test_chosen_home_lets_no_other_links_touch(tmp_path):
    robot = load(ROBOTS["leg"], tmp_path)
    assert robot.home.any()
    assert not [finding for finding in robot.findings if finding.kind == "touching-links"]


KEY = '<keyframe><key name="home" qpos="0 0 0 0 0 0"/></keyframe>'
COUPLED = '<equality><joint joint1="joint2" joint2="joint3"/></equality>'


def test_stated_home_is_kept(tmp_path):
    assert not load(arm(1.0, extra=KEY), tmp_path).home.any()
    requested = load(arm(1.0), tmp_path, home={"joint3": 0.5})
    assert requested.home.tolist() == [0, 0, 0.5, 0, 0, 0]
    assert not any(finding.kind == "home-chosen" for finding in requested.findings)
    both = load(arm(1.0, extra=KEY.replace("0 0 0 0 0 0", "0.1 0 0 0 0 0")), tmp_path, home={"joint3": 0.5})
    assert both.home.tolist() == [0.1, 0, 0.5, 0, 0, 0]


@pytest.mark.long
def test_coupled_joints_keep_their_posture(tmp_path):
    robot = load(arm(1.0, extra=COUPLED), tmp_path)
    assert robot.home[1] == robot.home[2] == 0.0
    assert robot.home.any()


@pytest.mark.parametrize(
    ("home", "words"),
    [
        ({"joint9": 0.1}, r"home\.joint9: the robot has no such joint .*Did you mean joint"),
        ({"joint2": 2.1}, r"home\.joint2: the home position of a joint is out of range .*2\.1.*-2 to 2 rad"),
        ({"joint2": float("nan")}, r"home\.joint2: .*out of range"),
    ],
)
def test_impossible_home_is_rejected(home, words, tmp_path):
    with pytest.raises(RobotError, match=words):
        load(arm(1.0), tmp_path, home=home)


@pytest.mark.long
def test_motion_of_points_matches_the_configuration(tmp_path):
    robot = load(ROBOTS["arm"], tmp_path)
    configuration = Configuration(robot)
    points = np.array([[0.0, 0.0, 0.0], [0.02, -0.01, 0.1]])
    pose = configuration.pose("link6")
    move = np.array([configuration.jacobian("link6", point) for point in points])
    angular = np.array([move[1, :, joint] - move[0, :, joint] for joint in range(6)])
    arms = pose.points(points) - pose.translation
    axes = configuration.joint_axes()[1]
    assert np.cross(axes, arms[1]) == pytest.approx(angular, abs=1e-9)
    assert point_motion(move[0], axes.T, arms) == pytest.approx(move, abs=1e-9)


def test_tilt_is_the_angle_between_motion_and_skin():
    move = np.zeros((3, 3, 1))
    move[:, :, 0] = [[0, 0, 1], [np.cos(0.3), 0, np.sin(0.3)], [1, 0, 0]]
    assert motion_tilts(move[:, 2], move) == pytest.approx([np.pi / 2, 0.3, 0.0])
