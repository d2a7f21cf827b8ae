"""Small robots with flat skin whose results can be computed by hand, and our own arm.

All objects are immutable and cached.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.recordings import small_arm

BAR_INERTIA = 0.0135 + 0.2**2
"""Inertia of the bar about its hinge [kg m²]."""
_BAR = """<mujoco model="bar"><compiler angle="radian"/><worldbody><body name="bar">
<inertial pos="0.2 0 0" mass="1" diaginertia="0.001 0.0135 0.0135"/>{joint}
<geom type="box" pos="0.2 0 0" size="0.2 0.05 0.02"/></body></worldbody></mujoco>"""
_PAIR = """<mujoco model="pair"><compiler angle="radian"/><worldbody>
<body name="left" pos="-0.065 0 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<joint name="slide" type="slide" axis="1 0 0" range="-0.05 0.05" limited="true"/>
<geom type="box" size="0.05 0.05 0.05"/></body>
<body name="right" pos="0.065 0 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<geom type="box" size="0.05 0.05 0.05"/></body></worldbody></mujoco>"""


@cache
def bar(*, hinged: bool = True) -> Robot:
    """Return a bar of 0.4 m and 1 kg from the origin along x, fixed or on a hinge about y at the origin."""
    joint = '<joint name="hinge" axis="0 1 0" range="-1.5 1.5" limited="true"/>' if hinged else ""
    joints = (Joint("hinge", -1.5, 1.5),) if hinged else ()
    text = _BAR.format(joint=joint)
    return Robot(
        "bar", "by hand", text, {}, (Link("bar", _box(0.2, 0.05, 0.02, x=0.2)),), joints, np.zeros(len(joints))
    )


@cache
def bar_skin(taxels: int = 60, *, finer: int = 1, length: float = 0.38) -> Skin:
    """Return skin on the top of the bar, 20 mm above the hinge's axis, on all or the middle part of its length [m]."""
    steps = round(48 * finer * length / 0.38), 12 * finer
    top = plate((0.01 + (0.38 - length) / 2, -0.05, 0.02), (length, 0, 0), (0, 0.1, 0), steps=steps)
    return Skin((Patch("top", "bar", top, place_evenly(top, taxels, seed=0)),))


def each_point_a_taxel(skin: Skin) -> Skin:
    """Return a skin with one point and one taxel in each face, so that readings equal the points' loads."""
    patches = []
    for patch in skin.patches:
        surface = patch.surface
        count = len(patch.surface.faces)
        middles = surface.vertices[surface.faces].mean(axis=1)
        points = Quadrature(middles, surface.face_normals, surface.face_areas, np.arange(count))
        weights = np.full((count, 3), 1 / 3)
        alone = np.zeros((0, 2), dtype=np.int64)
        taxels = Taxels(middles, points.normals, points.taxel, weights, points.areas, alone, points)
        patches.append(Patch(patch.name, patch.link, surface, taxels))
    return Skin(tuple(patches))


def pair() -> tuple[Robot, Skin]:
    """Return a block that slides along x towards a fixed one 30 mm away, with skin on the faces that meet."""
    box = _box(0.05, 0.05, 0.05)
    robot = Robot(
        "pair",
        "by hand",
        _PAIR,
        {},
        (Link("left", box), Link("right", box)),
        (Joint("slide", -0.05, 0.05, slide=True),),
        np.zeros(1),
    )
    faces = {
        "left": plate((0.05, -0.05, -0.05), (0, 0.1, 0), (0, 0, 0.1)),
        "right": plate((-0.05, -0.05, -0.05), (0, 0, 0.1), (0, 0.1, 0)),
    }
    return robot, Skin(tuple(Patch(n, n, plate, place_evenly(plate, 40, seed=0)) for n, plate in faces.items()))


def prepared_bar(*, hinged: bool = True, **scene) -> PreparedScene:
    """Return the bar as a prepared scene."""
    return PreparedScene(Scene(name="bar", robot="bar", **scene), bar(hinged=hinged), bar_skin(), bar_map())


@cache
def bar_map(taxels: int = 60, *, finer: int = 1) -> TactileMap:
    """Return the map of the bar's skin."""
    return build_map(bar_skin(taxels, finer=finer))


@cache
def arm() -> PreparedScene:
    """Return our own arm with 300 taxels."""
    return small_arm(300, thickness=0.003)


def no_command(robot: Robot) -> JointCommand:
    """Return a command that leaves the joints free."""
    return hold(robot, 0.0, 0.0)


def hold(robot: Robot, stiffness: float, damping: float) -> JointCommand:
    """Return a command with the same impedance about home at every joint."""
    ones = np.ones(len(robot.joints))
    return JointCommand(robot.home, stiffness * ones, damping * ones, 0 * ones)


def taxel_near(skin: Skin, patch: int, point) -> int:
    """Return the taxel of a patch nearest to a point of its link."""
    away = np.linalg.norm(skin.patches[patch].taxels.positions - np.asarray(point), axis=1)
    return int(skin.first[patch] + away.argmin())


def plate(corner, along, across, *, steps: tuple[int, int] = (16, 16)) -> Mesh:
    """Return a flat rectangle with normal ``along`` x ``across``."""
    m, n = steps
    i, j = (k.ravel() for k in np.meshgrid(np.arange(m + 1), np.arange(n + 1), indexing="ij"))
    vertices = np.asarray(corner) + np.outer(i / m, along) + np.outer(j / n, across)
    a = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel()
    b = a + n + 1
    c = a + n + 2
    d = a + 1
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def _box(dx: float, dy: float, dz: float, *, x: float = 0.0) -> Mesh:
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * [dx, dy, dz] + [x, 0, 0]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]))
