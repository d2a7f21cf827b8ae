"""Sheets in a robot file load, are drawn, and do not pretend to be solid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from app.geometry.mesh import Mesh
from app.robots.mjcf import load_mjcf

SQUARE = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), np.array([[0, 1, 2], [1, 3, 2]]))


def export(path: Path, vertices: object, faces: object) -> None:
    trimesh.Trimesh(vertices, faces, process=False).export(path)


def test_a_flat_mesh_is_drawn_but_does_not_collide_and_this_is_said(tiny: Path) -> None:
    export(tiny.parent / "meshes" / "rod.stl", SQUARE.vertices, SQUARE.faces)
    robot = load_mjcf(tiny)
    mesh = robot.link("rod").mesh
    assert mesh is not None
    assert mesh.area == pytest.approx(1.0)
    assert {finding.kind: finding.where for finding in robot.findings}["flat-mesh"] == "rod"


@pytest.mark.parametrize("cut", [20, 100, 200, 320])
@pytest.mark.parametrize("turn", [1, -1])
def test_open_and_inside_out_meshes_load(tiny: Path, cut: int, turn: int) -> None:
    ball = trimesh.creation.icosphere(2)
    export(tiny.parent / "meshes" / "rod.stl", ball.vertices, ball.faces[:cut, ::turn])
    mesh = load_mjcf(tiny).link("rod").mesh
    assert mesh is not None
    assert len(mesh.faces) == cut


def test_a_sheet_folded_so_that_its_volumes_cancel_loads(tiny: Path) -> None:
    ball = trimesh.creation.icosphere(1)
    other = ball.vertices + np.array([3.0, 0, 0])
    faces = np.vstack([ball.faces, ball.faces[:, ::-1] + len(ball.vertices)])
    export(tiny.parent / "meshes" / "rod.stl", np.vstack([ball.vertices, other]), faces)
    assert load_mjcf(tiny).link("rod").mesh is not None
