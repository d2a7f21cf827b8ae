"""A plate of skin on three slides: a robot whose loops can be computed by hand, to compare controllers with theory."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly

MASS = 4.0
"""Mass of the plate [kg]."""
_HALF = 0.06
_CELLS = 72
_TAXELS = 900
_REACH = 0.2
_LIGHT = 1e-6
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


@dataclass(frozen=True, eq=False)
class Gantry:
    """The robot and its skin.

    Attributes:
        robot: Slides along x, y and z; its posture is the position of the plate [m].
        skin: Top of the plate, at height zero of the plate and centred at the origin; taxels 4 mm apart.
        map: Map of the skin: the plate itself, stretched.
        believed: The same map of a skin that is rotated on the plate: the wrong belief of a controller. It is the true
            map without rotation.
    """

    robot: Robot
    skin: Skin
    map: TactileMap
    believed: TactileMap


@lru_cache(maxsize=16)
def gantry(*, stretch: float = 1.0, turn: float = 0.0) -> Gantry:
    """Return the plate with a map.

    Args:
        stretch: Ratio of the larger to the smaller stretch of the map; areas are preserved.
        turn: Rotation of the map on the plate that the controller does not know [deg].

    Cost: 1 s; cached.
    """
    skin = _skin()
    return Gantry(_robot(), skin, _map(skin, stretch, 0.0), _map(skin, stretch, turn))


def _robot() -> Robot:
    """Robot with nearly all of its mass in the plate, so that all three joints have equal dynamics."""
    bodies = "".join(f'<body name="{name}">{_joint(name)}{_inertial(_LIGHT)}' for name in ("x", "y"))
    plate = f'<body name="plate">{_joint("z")}{_inertial(MASS)}</body>'
    text = f'<mujoco model="gantry"><worldbody>{bodies}{plate}</body></body></worldbody></mujoco>'
    mesh = _box()
    links = (Link("x", None), Link("y", None), Link("plate", mesh))
    joints = tuple(Joint(name, -_REACH, _REACH, slide=True) for name in _AXES)
    return Robot("gantry", "made for studies", text, {}, links, joints, np.zeros(3))


def _joint(name: str) -> str:
    return f'<joint name="{name}" type="slide" axis="{_AXES[name]}" range="-{_REACH} {_REACH}" limited="true"/>'


def _inertial(mass: float) -> str:
    return f'<inertial pos="0 0 0" mass="{mass}" diaginertia="{mass:g} {mass:g} {mass:g}"/>'


def _box() -> Mesh:
    corners = np.array([[x, y, z] for x in (-_HALF, _HALF) for y in (-_HALF, _HALF) for z in (-0.02, 0.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]))


@lru_cache(maxsize=1)
def _skin() -> Skin:
    x, y = (line.ravel() for line in np.meshgrid(*2 * [np.linspace(-_HALF, _HALF, _CELLS + 1)], indexing="ij"))
    i, j = np.indices((_CELLS, _CELLS)).reshape(2, -1)
    a = i * (_CELLS + 1) + j
    b = a + _CELLS + 1
    faces = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])
    surface = Mesh(np.stack([x, y, np.zeros_like(x)], axis=1), faces)
    return Skin((Patch("top", "plate", surface, place_evenly(surface, _TAXELS, seed=0)),))


def _turned(skin: Skin, degrees: float) -> Skin:
    """The same taxels on the same faces, rotated about the middle of the plate."""
    (patch,) = skin.patches
    c = np.cos(np.radians(degrees))
    s = np.sin(np.radians(degrees))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])  # for rows
    taxels = patch.taxels
    felt = patch.taxels.quadrature
    moved = replace(
        taxels, positions=taxels.positions @ turn, quadrature=replace(felt, positions=felt.positions @ turn)
    )
    return Skin((replace(patch, surface=Mesh(patch.surface.vertices @ turn, patch.surface.faces), taxels=moved),))


def _map(skin: Skin, stretch: float, turn: float) -> TactileMap:
    """Map of the plate, for a skin that is believed to be rotated [deg]."""
    surface = skin.patches[0].surface
    plane = surface.vertices[:, :2] * [stretch**0.5, stretch**-0.5]
    chart = Chart(surface.faces, plane, np.arange(len(plane)), np.zeros((0, 2), dtype=np.int64), "by hand")
    return TactileMap(_turned(skin, turn) if turn else skin, (chart,), MapLayout((Placement(),)))
