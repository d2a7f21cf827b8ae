"""Blocks with a hollow in their skin: a bowl, a groove with walls at right angles, a saddle; and a flat one."""

from __future__ import annotations

from functools import cache

import numpy as np
import trimesh

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly

HALF = 0.06
BASE = -0.03
"""Half the width of a block, and the height of its bottom [m]."""
BOWL_RADIUS = 0.068
BOWL_RIM = 0.05
BOWL_DEPTH = BOWL_RADIUS - np.sqrt(BOWL_RADIUS**2 - BOWL_RIM**2)
GROOVE_DEPTH = 0.02
SADDLE_RADIUS = 0.08
_BLOCK = """<mujoco model="block"><worldbody><body name="block">
<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<geom type="box" size="0.06 0.06 0.01" pos="0 0 -0.02"/></body></worldbody></mujoco>"""


def _bowl(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    below = np.sqrt(np.maximum(BOWL_RADIUS**2 - x**2 - y**2, 0.0)) - np.sqrt(BOWL_RADIUS**2 - BOWL_RIM**2)
    return -np.maximum(below, 0.0)


HEIGHTS = {
    "bowl": _bowl,
    "groove": lambda x, y: -np.maximum(GROOVE_DEPTH - np.abs(x), 0.0) + 0 * y,
    "saddle": lambda x, y: (x**2 - y**2) / (2 * SADDLE_RADIUS),
    "flat": lambda x, y: 0 * x * y,
}


@cache
def hollow(shape: str, *, cells: int = 24, taxels: int = 200, solid: bool = True) -> tuple[Robot, Skin]:
    """Return a fixed block whose top has skin; without ``solid`` its mesh is missing, so that only skin is known."""
    top, block = block_meshes(shape, cells)
    link = Link("block", block, missing=() if solid else ("block.stl",))
    robot = Robot(shape, "by hand", _BLOCK, {}, (link,), (), np.zeros(0))
    return robot, Skin((Patch("top", "block", top, place_evenly(top, taxels, seed=0)),))


@cache
def raised(height: float = 3e-3) -> tuple[Robot, Skin]:
    """Return a fixed flat block with skin above the half of its top at positive x."""
    top, block = block_meshes("flat", 24)
    half = top.faces[top.vertices[top.faces].mean(axis=1)[:, 0] > 0]
    used, corner = np.unique(half, return_inverse=True)
    surface = Mesh(top.vertices[used] + [0, 0, height], corner.reshape(-1, 3))
    robot = Robot("raised", "by hand", _BLOCK, {}, (Link("block", block),), (), np.zeros(0))
    return robot, Skin((Patch("top", "block", surface, place_evenly(surface, 200, seed=0)),))


def block_meshes(shape: str, cells: int) -> tuple[Mesh, Mesh]:
    """Return the top of a block, and the whole block, whose first faces are the top."""
    steps = np.linspace(-HALF, HALF, cells + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    top = np.stack([x, y, HEIGHTS[shape](x, y)], axis=1)
    count = len(top)
    numbers = np.arange(count).reshape(cells + 1, cells + 1)
    a, b, c, d = (corner.ravel() for corner in (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    border = np.concatenate([numbers[:-1, 0], numbers[-1, :-1], numbers[:0:-1, -1], numbers[0, :0:-1]])
    after = np.roll(border, -1)
    sides = np.concatenate(
        [np.stack([border, border + count, after + count], 1), np.stack([border, after + count, after], 1)]
    )
    bottom = top * [1, 1, 0] + [0, 0, BASE]
    whole = Mesh(np.concatenate([top, bottom]), np.concatenate([faces, faces[:, ::-1] + count, sides]))
    return Mesh(top, faces), whole


_BALL = """<mujoco model="bowl and ball"><worldbody><body name="block">
<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<geom type="box" size="0.06 0.06 0.01" pos="0 0 -0.02"/></body>
<body name="ball" pos="0 0 {height}"><joint name="slide" type="slide" axis="0 0 1" range="-0.1 0.1"/>
<inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>
<geom type="sphere" size="0.02"/></body></worldbody></mujoco>"""


@cache
def bowl_and_ball(height: float, *, first: str = "block") -> tuple[Robot, Skin]:
    """Return a fixed block with a bowl, and a link above it that slides down: a ball of 20 mm, with skin all over.

    Args:
        height: Height of the ball's middle at home; it touches the bowl at 20 mm less ``BOWL_DEPTH`` [m].
        first: The link whose patch is the first one.
    """
    top, block = block_meshes("bowl", 24)
    shape = trimesh.creation.icosphere(3, 0.02)
    ball = Mesh(np.asarray(shape.vertices), np.asarray(shape.faces))
    joint = Joint("slide", -0.1, 0.1, slide=True)
    links = (Link("block", block), Link("ball", ball))
    robot = Robot("bowl and ball", "by hand", _BALL.format(height=height), {}, links, (joint,), np.zeros(1))
    patches = {
        "block": Patch("bowl", "block", top, place_evenly(top, 200, seed=0)),
        "ball": Patch("ball", "ball", ball, place_evenly(ball, 200, seed=0)),
    }
    other = "ball" if first == "block" else "block"
    return robot, Skin((patches[first], patches[other]))
