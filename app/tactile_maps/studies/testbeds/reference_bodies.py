"""Bodies by formula: tubes, shells and closed links at any resolution, and a flat skin whose map is the identity.

``MESHES`` are the bodies to flatten: two that can be flattened without distortion, one that cannot (Milnor 1969),
shapes like those of robots, and one with a handle. The image error on ``flat_map`` is that of the interpolation alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.connectivity import remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import taxels_at_points

_TURN = 2 * np.pi


def tube(faces: int) -> Mesh:
    """Return a cylinder open at both ends, which can be flattened without distortion."""
    return _ring(faces, lambda turn, up: (0.04 + 0 * up, 0.2 * up), 0.2 / (_TURN * 0.04))


def cone(faces: int) -> Mesh:
    """Return a frustum open at both ends, which can be flattened without distortion."""
    return _ring(faces, lambda turn, up: (0.05 - 0.03 * up, 0.2 * up), 0.2 / (_TURN * 0.035))


def torso(faces: int) -> Mesh:
    """Return an oval tube with chest and waist."""

    def shape(turn: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
        waist = np.exp(-(((up - 0.35) / 0.18) ** 2))
        chest = np.exp(-(((up - 0.75) / 0.2) ** 2))
        girth = 1 - 0.25 * waist + 0.1 * np.cos(turn) * chest
        return 0.12 * girth * (1 + 0.25 * np.cos(2 * turn)), 0.45 * up

    return _ring(faces, shape, 0.45 / (_TURN * 0.12))


def hemisphere(faces: int) -> Mesh:
    """Return half a ball, whose lengths no map preserves (Milnor 1969)."""
    points, triangles = _cube(2 * max(round(np.sqrt(faces / 24)), 1))
    upper, kept = remove_unreferenced(triangles[points[triangles, 2].mean(axis=1) > 0])
    ball = points[kept] / np.linalg.norm(points[kept], axis=1, keepdims=True)
    return Mesh(0.05 * ball, upper)


def bumpy_shell(faces: int) -> Mesh:
    """Return a plate with five smooth bumps and dents, like the shell of a hand."""
    a, b, triangles = _square(faces)
    height = np.zeros(len(a))
    for x, y, size in ((0.4, 0.3, 1.0), (-0.4, 0.45, -0.8), (-0.35, -0.4, 0.9), (0.45, -0.45, -0.7), (0.0, 0.0, 0.6)):
        height += size * np.exp(-((a - x) ** 2 + (b - y) ** 2) / 0.05)
    return Mesh(np.stack([0.08 * a, 0.06 * b, 0.025 * height], axis=1), triangles)


def closed_link(faces: int) -> Mesh:
    """Return a long closed body with rounded corners."""
    side = max(round(np.sqrt(faces / 12)), 2)
    points, triangles = _cube(side)
    rounded = points / (np.abs(points) ** 4).sum(axis=1, keepdims=True) ** 0.25
    return Mesh(rounded * [0.03, 0.04, 0.1], triangles)


def torus(faces: int) -> Mesh:
    """Return a closed body with a handle."""
    across = max(round(np.sqrt(faces / 6)), 3)
    u, v, triangles = _lattice(3 * across, across, wrap=(True, True))
    ring = 0.06 + 0.02 * np.cos(_TURN * v)
    points = np.stack([ring * np.cos(_TURN * u), ring * np.sin(_TURN * u), 0.02 * np.sin(_TURN * v)], axis=1)
    return Mesh(points, triangles)


def square_sheet(faces: int, *, size: float) -> Mesh:
    """Return a flat square with sides of ``size`` [m] and one corner at the origin."""
    a, b, triangles = _square(faces)
    return Mesh(0.5 * size * np.stack([a + 1, b + 1, 0 * a], axis=1), triangles)


MESHES: Mapping[str, Callable[[int], Mesh]] = {
    "tube": tube,
    "cone": cone,
    "torso": torso,
    "hemisphere": hemisphere,
    "bumpy shell": bumpy_shell,
    "closed link": closed_link,
    "torus": torus,
}
"""Bodies by name, as functions of the approximate number of faces. All are oriented outwards."""


def _ring(faces: int, shape: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]], length: float) -> Mesh:
    """Surface around the z axis.

    Args:
        faces: Approximate number of faces.
        shape: Returns radius and height for an angle and a share of the height.
        length: Length of the tube in circumferences.
    """
    around = max(round(np.sqrt(faces / 2 / length)), 3)
    u, up, triangles = _lattice(around, max(round(faces / 2 / around), 1), wrap=(True, False))
    radius, height = shape(_TURN * u, up)
    return Mesh(np.stack([radius * np.cos(_TURN * u), radius * np.sin(_TURN * u), height], axis=1), triangles)


def _square(faces: int) -> tuple[FloatArray, FloatArray, IntArray]:
    """Coordinates from -1 to 1 and faces of a square."""
    side = max(round(np.sqrt(faces / 2)), 1)
    u, v, triangles = _lattice(side, side, wrap=(False, False))
    return 2 * u - 1, 2 * v - 1, triangles


def _lattice(columns: int, rows: int, *, wrap: tuple[bool, bool]) -> tuple[FloatArray, FloatArray, IntArray]:
    """Coordinates u, v from 0 to 1 of the points of a grid, and its faces (m, 3); a wrapped side has no last line."""
    counts = columns + (not wrap[0]), rows + (not wrap[1])
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    a, b, c, d = (
        ((i + x) % counts[0] * counts[1] + (j + y) % counts[1]).ravel() for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    u, v = np.meshgrid(np.arange(counts[0]) / columns, np.arange(counts[1]) / rows, indexing="ij")
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return u.ravel(), v.ravel(), faces


def _cube(side: int) -> tuple[FloatArray, IntArray]:
    """Points from -1 to 1 and faces of a cube whose sides are ``side`` squares long."""
    u, v, triangles = _lattice(side, side, wrap=(False, False))
    first, second = (np.rint(side * part).astype(np.int64) for part in (u, v))
    sheets = []
    for axis in range(3):
        for end in (0, side):
            sheet = np.empty((len(u), 3), dtype=np.int64)
            sheet[:, axis] = end
            pair = (first, second) if end else (second, first)
            sheet[:, (axis + 1) % 3], sheet[:, (axis + 2) % 3] = pair
            sheets.append(sheet)
    points, number = np.unique(np.concatenate(sheets), axis=0, return_inverse=True)
    faces = number.reshape(6, -1)[:, triangles].reshape(-1, 3)
    return 2 * points / side - 1, faces


SIDE = 0.1
"""Side of the square [m]."""
_JITTER = 0.2


def flat_map(taxels: int, *, seed: int = 0) -> TactileMap:
    """Return a map of about ``taxels`` taxels, up to 0.2 cells from the middles of grid cells. Cost: 50 µs each."""
    side = max(round(np.sqrt(taxels)), 1)
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    middles = np.stack([x, y], axis=-1).reshape(-1, 2) + 0.5
    places = SIDE / side * (middles + np.random.default_rng(seed).uniform(-_JITTER, _JITTER, middles.shape))
    surface = square_sheet(8 * side**2, size=SIDE)
    centres = surface.vertices[surface.faces].mean(axis=1)[:, :2]
    owner = cKDTree(places).query(centres)[1].astype(np.int64)
    cells = taxels_at_points(surface, np.column_stack([places, np.zeros(len(places))]), owner)
    skin = Skin((Patch("square", "square", surface, cells),))
    flat: FloatArray = surface.vertices[:, :2]
    chart = Chart(surface.faces, flat, np.arange(len(flat)), np.zeros((0, 2), np.int64), "unroll")
    return TactileMap(skin, (chart,), MapLayout((Placement(),)))
