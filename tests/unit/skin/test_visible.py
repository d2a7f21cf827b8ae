from __future__ import annotations

import numpy as np

from app.geometry.mesh import Mesh
from app.geometry.wrap import wrap
from app.skin.visible import visible_from_outside
from tests.numerics.hard_meshes import HARD_MESHES

VOXEL = 0.008


def test_a_ball_alone_is_seen_everywhere() -> None:
    ball = wrap(HARD_MESHES["sphere"], thickness=0.01, voxel=VOXEL).surface
    assert visible_from_outside(ball, [], voxel=VOXEL).all()


def test_the_middle_of_a_long_tube_is_seen_outside_only() -> None:
    tube = Mesh(HARD_MESHES["open tube"].vertices * [0.6, 0.6, 1], HARD_MESHES["open tube"].faces)
    surface = wrap(tube, thickness=0.004, voxel=0.006).surface
    seen = visible_from_outside(surface, [], voxel=0.006)
    radius, middle = np.linalg.norm(surface.vertices[:, :2], axis=1), np.abs(surface.vertices[:, 2] - 0.15) < 0.03
    inside, outside = middle & (radius < 0.028), middle & (radius > 0.032)
    assert inside.any()
    assert outside.any()
    assert not seen[inside].any()
    assert seen[outside].all()


def test_what_another_link_hides_is_not_seen() -> None:
    ball = wrap(HARD_MESHES["sphere"], thickness=0.01, voxel=VOXEL).surface
    shell = wrap(HARD_MESHES["sphere"], thickness=0.1, voxel=VOXEL).surface
    half = Mesh(shell.vertices, shell.faces[shell.vertices[shell.faces].mean(axis=1)[:, 2] > 0])
    seen = visible_from_outside(ball, [half], voxel=VOXEL)
    assert not seen[ball.vertices[:, 2] > 0.1].any()
    assert seen[ball.vertices[:, 2] < -0.03].all()
