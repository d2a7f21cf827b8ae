"""Skins and bodies for the table of contacts, for which statics gives the result.

A skin covers the upper side of a fixed block, or a part of it. Bodies are placed so that their reading is known: the
weight, centred below the centre of mass.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectKind, ObjectSpec, SceneObject
from tactile_maps.skin.model.skin import Patch, Skin, Taxels
from tactile_maps.skin.taxel_placement.sampling import taxels_at_barycentric, taxels_at_points

GRAVITY = 9.81
"""[m/s²]."""
MASS = 0.5
"""Mass of a body [kg]."""
STIFFNESS = 2e4
"""Stiffness of the cover [N/m]."""
FRICTION = 0.5
PITCH = 0.008
"""Spacing of the taxels [m]: four squares of the surface."""
CONVEX = 0.06
CONCAVE = 0.08
"""Radius of the convex skin, a part of a cylinder along y, and of the concave one, a part of a sphere [m]."""
LINK = "block"
_TAXELS = (13, 8)
"""Along x and y: the middle of the skin is the middle of a taxel along x and a border along y."""
_SHIFT = np.array([0.5 * (count % 2) for count in _TAXELS])
_SQUARES = 4
"""Squares of the surface along a taxel."""
_BASE = 0.02
"""Thickness of the block below the lowest point of its upper side [m]."""
_BARE = 0.024
"""Smallest x that is covered on the block called ``bare`` [m]."""


@dataclass(frozen=True, eq=False)
class Bench:
    """A fixed block with skin on its upper side.

    Attributes:
        robot: The block.
        points: Its skin with a taxel for each quadrature point: these read what the cover bears.
        taxels: The same skin with a regular grid of taxels.
    """

    robot: Robot
    points: Skin
    taxels: Skin


def _flat(x: FloatArray, y: FloatArray) -> FloatArray:
    return 0 * x


def _convex(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(CONVEX**2 - x**2) - CONVEX)


def _concave(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(CONCAVE - np.sqrt(CONCAVE**2 - x**2 - y**2))


SKINS: Mapping[str, tuple[Callable[[FloatArray, FloatArray], FloatArray], float]] = {
    "flat": (_flat, -math.inf),
    "convex": (_convex, -math.inf),
    "concave": (_concave, -math.inf),
    "border": (_flat, 0.0),
    "bare": (_flat, _BARE),
}
"""Height of the block over (x, y), and the smallest covered x [m]. Bodies are placed near the origin."""


@cache
def bench(skin: str, slope: float = 0.0) -> Bench:
    """Return the block with a skin, turned by ``slope`` [rad] about y: downhill is along its x axis.

    Cost: 30 ms, kept.
    """
    height, covered_from = SKINS[skin]
    top = upper_side(height)
    text = (
        f'<mujoco model="block"><compiler angle="radian"/><worldbody><body name="{LINK}" euler="0 {slope!r} 0"/>'
        "</worldbody></mujoco>"
    )
    robot = Robot("block", "by formula", text, {}, (Link(LINK, _solid(top)),), (), np.zeros(0))
    kept = top.faces[top.vertices[top.faces].mean(axis=1)[:, 0] > covered_from]
    used, renumbered = np.unique(kept, return_inverse=True)
    surface = Mesh(top.vertices[used], renumbered.reshape(-1, 3))
    points, taxels = (
        Skin((Patch("skin", LINK, surface, cells),)) for cells in (_point_taxels(surface), _grid_taxels(surface))
    )
    return Bench(robot, points, taxels)


_PAIR = """<mujoco model="pair"><compiler angle="radian"/><worldbody>
<body name="left" pos="0 0 -0.005"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<joint name="slide" type="slide" axis="0 0 1" range="-0.1 0.1" limited="true"/></body>
<body name="right" pos="0 0 0.005" euler="3.141592653589793 0 0"><inertial pos="0 0 0" mass="1"
diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>"""


@cache
def facing_skins(skin: str) -> tuple[Robot, Skin]:
    """Return two blocks with skin that face each other; the lower one slides up towards a fixed flat one."""
    tops = {"left": upper_side(SKINS[skin][0]), "right": upper_side(_flat)}
    links = tuple(Link(name, _solid(top)) for name, top in tops.items())
    robot = Robot("pair", "by formula", _PAIR, {}, links, (Joint("slide", -0.1, 0.1, slide=True),), np.zeros(1))
    return robot, Skin(tuple(Patch(name, name, top, _point_taxels(top)) for name, top in tops.items()))


def upper_side(height: Callable[[FloatArray, FloatArray], FloatArray]) -> Mesh:
    """Return a grid of squares over x and y, symmetric about both axes, each cut in two."""
    counts = [_SQUARES * count for count in _TAXELS]
    x, y = (PITCH / _SQUARES * (np.arange(count + 1) - count / 2) for count in counts)
    across, along = np.meshgrid(x, y, indexing="ij")
    row, column = (k.ravel() for k in np.meshgrid(*map(np.arange, counts), indexing="ij"))
    a = row * len(y) + column
    b = a + len(y)
    c = b + 1
    d = a + 1
    # Diagonals are mirrored about both axes, so that a mirrored load has mirrored points.
    turned = (2 * row < counts[0]) == (2 * column < counts[1])
    first = np.where(turned[:, None], np.stack([a, b, d], 1), np.stack([a, b, c], 1))
    second = np.where(turned[:, None], np.stack([b, c, d], 1), np.stack([a, c, d], 1))
    vertices = np.stack([across, along, height(across, along)], axis=-1).reshape(-1, 3)
    return Mesh(vertices, np.concatenate([first, second]))


def _point_taxels(surface: Mesh) -> Taxels:
    faces = np.arange(len(surface.faces))
    return taxels_at_barycentric(surface, faces, np.full((len(faces), 3), 1 / 3), faces)


def _grid_taxels(surface: Mesh) -> Taxels:
    centres = surface.vertices[surface.faces].mean(axis=1)
    cells, owner = np.unique(np.floor(centres[:, :2] / PITCH + _SHIFT), axis=0, return_inverse=True)
    owner = owner.ravel()
    heights = np.bincount(owner, centres[:, 2]) / np.bincount(owner)
    return taxels_at_points(surface, np.column_stack([(cells + 0.5 - _SHIFT) * PITCH, heights]), owner)


def _solid(top: Mesh) -> Mesh:
    """Return the closed block under an upper side."""
    count = len(top.vertices)
    floor = top.vertices.copy()
    floor[:, 2] = top.vertices[:, 2].min() - _BASE
    edges = np.sort(top.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, times = np.unique(edges, axis=0, return_counts=True)
    border = {tuple(pair) for pair in keys[times == 1].tolist()}
    directed = top.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()
    walls = []
    for a, b in directed:
        if (min(a, b), max(a, b)) in border:
            walls += [(b, a, a + count), (b, a + count, b + count)]
    faces = np.concatenate([top.faces, top.faces[:, ::-1] + count, np.array(walls)])
    return Mesh(np.concatenate([top.vertices, floor]), faces)


@dataclass(frozen=True)
class Body:
    """A shape that rests on skin.

    Attributes:
        kind: Kind of the scene object.
        size: Its size [m]; of a mesh empty.
        turn: Turns about x, y and z at rest [deg].
        height: Height of its origin above a level surface [m].
        reach: Half the length along x and y of what touches a level surface [m]: zero for a point.
        aside: Distance of the centre of mass from the middle of what touches, along x [m].
        guided: Whether it would topple without a guide.
    """

    kind: ObjectKind
    size: tuple[float, ...]
    turn: tuple[float, float, float]
    height: float
    reach: tuple[float, float] = (0.0, 0.0)
    aside: float = 0.0
    guided: bool = False


_EDGE = 0.024
_LONG = 0.03
_CORNER = float(np.degrees(np.arctan(np.sqrt(0.5))))
_LEAN = (0.03, 0.014, 0.024, 0.024)
"""Length of the base and of the top along x, width, height of the leaning block [m]."""


@cache
def leaning_block() -> tuple[Mesh, float]:
    """Return a prism with an upright side, its origin in the middle of its base, and the x of its centre of mass."""
    base, top, width, height = _LEAN
    half = base / 2
    side = [(-half, 0.0), (half, 0.0), (half, height), (half - top, height)]
    vertices = np.array([(x, y, z) for y in (-width / 2, width / 2) for x, z in side])
    faces = [(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6)]
    for k in range(4):
        n = (k + 1) % 4
        faces += [(k, k + 4, n), (n, k + 4, n + 4)]
    # A right-angled trapezium is a rectangle and a triangle.
    rectangle = top * height
    triangle = 0.5 * (base - top) * height
    middle = rectangle * (half - top / 2) + triangle * (half - top - (base - top) / 3)
    return Mesh(vertices, np.array(faces)), middle / (rectangle + triangle)


BODIES: Mapping[str, Body] = {
    "sphere": Body("sphere", (0.02,), (0.0, 0.0, 0.0), 0.02),
    "disc": Body("cylinder", (0.015, 0.02), (0.0, 0.0, 0.0), 0.01, (0.015, 0.015)),
    "roller": Body("cylinder", (0.012, _LONG), (90.0, 0.0, 0.0), 0.012, (0.0, _LONG / 2)),
    "box on face": Body("box", (_LONG, 0.024, 0.02), (0.0, 0.0, 0.0), 0.01, (_LONG / 2, 0.012)),
    "box on edge": Body(
        "box", (_EDGE, _LONG, _EDGE), (0.0, 45.0, 0.0), _EDGE / math.sqrt(2), (0.0, _LONG / 2), guided=True
    ),
    "box on corner": Body("box", (_EDGE,) * 3, (45.0, _CORNER, 0.0), _EDGE * math.sqrt(3) / 2, guided=True),
    "mesh": Body("mesh", (), (0.0, 0.0, 0.0), 0.0, (_LEAN[0] / 2, _LEAN[2] / 2), aside=leaning_block()[1]),
}


def lay(
    name: str,
    at: tuple[float, float, float],
    *,
    mass: float = MASS,
    guided: bool = False,
    slope: float = 0.0,
    yaw: float = 0.0,
    called: str = "body",
) -> SceneObject:
    """Return a body whose lowest point is at a place of the block's frame [m].

    Args:
        name: Shape.
        at: Place.
        mass: Mass of the body [kg].
        guided: Whether it slides along the vertical alone.
        slope: Turn of the block about y [rad].
        yaw: Turn about the block's normal [deg].
        called: Name of the object.
    """
    body = BODIES[name]
    tilt = Rotation.from_euler("y", slope)
    own = Rotation.from_euler("z", yaw, degrees=True) * Rotation.from_euler("xyz", body.turn, degrees=True)
    place = tilt.apply(np.array(at) + (0.0, 0.0, body.height)).tolist()
    angles = (tilt * own).as_euler("xyz", degrees=True).tolist()
    spec = ObjectSpec(
        called,
        body.kind,
        body.size,
        tuple(place),
        tuple(angles),
        mass,
        FRICTION,
        guided=guided or body.guided,
        file="leaning_block.obj" if body.kind == "mesh" else "",
    )
    return SceneObject(spec, leaning_block()[0] if body.kind == "mesh" else primitive_mesh(spec))
