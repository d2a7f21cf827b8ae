"""Any robot file through one door; a mesh alone is a robot of one link."""

from __future__ import annotations

import pickle

import mujoco
import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import MeshError, RobotError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.load import CLEARANCE, load_bare_mesh, load_robot_file
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply"])
def test_mesh_is_a_robot_of_one_link_just_above_the_ground(tmp_path, suffix):
    trimesh.creation.icosphere(2, radius=0.2).export(tmp_path / f"ball.{suffix}")
    robot = load_bare_mesh(tmp_path / f"ball.{suffix}")
    assert ([link.name for link in robot.links], robot.joints, robot.home.shape) == (["mesh"], (), (0,))
    mesh = robot.links[0].mesh
    assert mesh is not None
    assert len(mesh.faces) == 320
    lowest = Configuration(robot).pose("mesh").points(mesh.vertices)[:, 2].min()
    assert lowest == pytest.approx(CLEARANCE, abs=1e-5)
    assert mesh.area == pytest.approx(4 * np.pi * 0.04, rel=0.02)


def open_shell() -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere(2, radius=0.2)
    return trimesh.Trimesh(ball.vertices, ball.faces[:200], process=False)


def inside_out() -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere(2, radius=0.2)
    return trimesh.Trimesh(ball.vertices, ball.faces[:, ::-1], process=False)


def flat() -> trimesh.Trimesh:
    return trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]], process=False)


def single() -> trimesh.Trimesh:
    return trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], [[0, 1, 2]], process=False)


def with_slivers() -> trimesh.Trimesh:
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    return trimesh.Trimesh(box.vertices, np.vstack([box.faces, [[0, 0, 1], [2, 2, 2]]]), process=False)


@pytest.mark.parametrize("shape", [open_shell, inside_out, flat, single, with_slivers])
def test_degenerate_meshes_load_and_simulate(tmp_path, shape):
    mesh = shape()
    mesh.export(tmp_path / "bad.obj")
    robot = load_bare_mesh(tmp_path / "bad.obj")
    assert robot.links[0].mesh is not None
    assert len(robot.links[0].mesh.faces) == len(mesh.faces)
    model = compile_spec(robot_spec(robot), source=robot.source)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 5)
    assert data.time > 0
    if shape in (flat, single):
        assert "flat-mesh" in {finding.kind for finding in robot.findings}


def test_mesh_without_area_is_rejected(tmp_path):
    (tmp_path / "line.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match="no area"):
        load_bare_mesh(tmp_path / "line.obj")


def test_each_kind_of_file_has_its_reader(tiny, urdf):
    assert load_robot_file(tiny).name == "tiny"
    assert load_robot_file(str(urdf("rod.stl"))).name == "two"
    assert load_robot_file(tiny.parent / "meshes" / "rod.stl").links[0].name == "mesh"


def test_urdf_under_the_name_of_xml_is_still_urdf(urdf):
    path = urdf("rod.stl").rename(urdf("rod.stl").with_name("two.xml"))
    assert load_robot_file(path).name == "two"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("absent.xml", "no such file"),
        ("absent.stl", "no such file"),
        ("", "folder, not a file"),
        ("notes.txt", "a robot file"),
    ],
)
def test_other_files_are_rejected_with_their_path(tmp_path, name, problem):
    (tmp_path / "notes.txt").write_text("notes")
    with pytest.raises(RobotError, match=problem) as caught:
        load_robot_file(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_pickled_robot_is_unchanged(tiny):
    robot = load_robot_file(tiny)
    again = pickle.loads(pickle.dumps(robot))
    assert (again.mjcf, again.assets, again.joints) == (robot.mjcf, robot.assets, robot.joints)
    assert np.array_equal(again.home, robot.home)
    assert all(np.array_equal(a.mesh.vertices, b.mesh.vertices) for a, b in zip(again.links, robot.links, strict=True))
