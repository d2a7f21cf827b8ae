"""A mesh alone: one fixed link above the ground, whatever shape the mesh is in."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from app.errors import MeshError
from app.robots.bare_mesh import CLEARANCE, load_bare_mesh
from app.robots.compile import compile_spec, robot_spec
from app.robots.configuration import Configuration


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply"])
def test_one_link_no_joints_just_above_the_ground(tmp_path: Path, suffix: str) -> None:
    trimesh.creation.icosphere(2, radius=0.2).export(tmp_path / f"ball.{suffix}")
    robot = load_bare_mesh(tmp_path / f"ball.{suffix}")
    assert ([link.name for link in robot.links], robot.joints, robot.home.shape) == (["mesh"], (), (0,))
    mesh = robot.links[0].mesh
    assert mesh is not None
    assert len(mesh.faces) == 320
    lowest = Configuration(robot).pose("mesh").points(mesh.vertices)[:, 2].min()
    assert lowest == pytest.approx(CLEARANCE, abs=1e-5)
    assert mesh.area == pytest.approx(4 * np.pi * 0.04, rel=0.02)


def test_millimetres_are_guessed_and_said(tmp_path: Path) -> None:
    trimesh.creation.box((100, 200, 300)).export(tmp_path / "box.stl")
    robot = load_bare_mesh(tmp_path / "box.stl")
    assert [finding.kind for finding in robot.findings] == ["units"]
    assert robot.links[0].mesh is not None
    assert np.ptp(robot.links[0].mesh.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3], rel=1e-5)


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
def test_meshes_in_bad_shape_load_and_simulate(tmp_path: Path, shape: object) -> None:
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


def test_a_mesh_without_area_is_refused(tmp_path: Path) -> None:
    (tmp_path / "line.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match="no area"):
        load_bare_mesh(tmp_path / "line.obj")
