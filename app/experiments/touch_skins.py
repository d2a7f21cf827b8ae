"""Skins to touch, flat and bent, each with a grid of 200,000 points on it that knows better than its taxels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from app.arrays import FloatArray
from app.experiments.dense_touch import Blur, DensePoints
from app.experiments.flat_map import SIDE, flat_map
from app.experiments.meshes import tube
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.skin.place import place_taxels
from app.skin.skin import Patch, Skin
from app.touch.fft_blur import GridBlur

RADIUS, LENGTH = 0.036, 0.2
"""Of the bent skin, a tube like a forearm [m]."""
_LEAST_FACES, _FACES = 24_000, 12
_POINTS = 200_000


@dataclass(frozen=True, eq=False)
class Ground:
    """A skin of one patch, and the grid on it.

    Attributes:
        skin: With taxels.
        dense: The grid's points, row by row.
        shape: Rows and columns of the grid.
        pitch: Between rows and between columns, along the skin [m].
        radius: Of the tube whose girth the columns go round [m]; inf where it is flat.
    """

    skin: Skin
    dense: DensePoints
    shape: tuple[int, int]
    pitch: tuple[float, float]
    radius: float

    def blur(self, depth: float) -> Blur:
        """From pressures on the grid to those ``depth`` [m] below; distances are straight through the body."""
        bent = None if np.isinf(self.radius) else self._chord
        grid = GridBlur(self.shape, self.pitch, depth, distance=bent)
        return lambda pressures: grid.felt(pressures.reshape(self.shape)).ravel()

    def _chord(self, up: FloatArray, around: FloatArray) -> FloatArray:
        return np.hypot(up, 2 * self.radius * np.sin(np.minimum(0.5 * around / self.radius, np.pi / 2)))

    def place(self, across: float, up: float) -> tuple[FloatArray, FloatArray]:
        """Point and outward normal (3,) so far from the grid's middle [m]."""
        row, column = (round(n / 2 + step / p) for n, step, p in zip(self.shape, (up, across), self.pitch, strict=True))
        number = row * self.shape[1] + column
        return self.dense.positions[number], self.dense.normals[number]


@lru_cache(maxsize=2)
def flat(taxels: int, seed: int) -> Ground:
    """A square with a side of 100 mm; taxels at random in the cells of a grid. Cost: 1 s, and 0.1 ms a taxel."""
    side = round(np.sqrt(_POINTS))
    pitch = SIDE / side
    steps = pitch * (np.arange(side) + 0.5)
    up, across = np.meshgrid(steps, steps, indexing="ij")
    points = np.column_stack([across.ravel(), up.ravel(), np.zeros(up.size)])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    return _ground(flat_map(taxels, seed=seed).skin, points, normals, (side, side), (pitch, pitch), np.inf)


@lru_cache(maxsize=2)
def bent(taxels: int, seed: int) -> Ground:
    """A tube with a radius of 36 mm, open at both ends; taxels placed evenly. Cost: 1 s, and 1 ms a taxel."""
    raw = tube(max(_LEAST_FACES, _FACES * taxels))
    scale = RADIUS / np.hypot(*raw.vertices[0, :2])
    surface = Mesh(raw.vertices * [scale, scale, LENGTH / np.ptp(raw.vertices[:, 2])], raw.faces)
    girth = 2 * np.pi * RADIUS
    rows = round(np.sqrt(_POINTS * LENGTH / girth))
    columns = round(_POINTS / rows)
    pitch = (LENGTH / rows, girth / columns)
    up, turn = np.meshgrid(
        pitch[0] * (np.arange(rows) + 0.5), 2 * np.pi / columns * (np.arange(columns) + 0.5), indexing="ij"
    )
    normals = np.column_stack([np.cos(turn).ravel(), np.sin(turn).ravel(), np.zeros(turn.size)])
    points = RADIUS * normals + np.outer(up.ravel(), [0.0, 0.0, 1.0])
    skin = Skin((Patch("tube", "tube", surface, place_taxels(surface, taxels, seed=seed)),))
    return _ground(skin, points, normals, (rows, columns), pitch, RADIUS)


def _ground(
    skin: Skin,
    points: FloatArray,
    normals: FloatArray,
    shape: tuple[int, int],
    pitch: tuple[float, float],
    radius: float,
) -> Ground:
    patch = skin.patches[0]
    face, _, _ = ClosestPoint(patch.surface).query(points)
    taxel = patch.taxels.quadrature.taxel[face]  # every face is felt, so face and quadrature point have one number
    areas = np.full(len(points), pitch[0] * pitch[1])
    # A cell of a small taxel holds some 20 points, whose number misses its area by a tenth.
    parts = (patch.taxels.areas / np.maximum(np.bincount(taxel, minlength=len(skin)), 1))[taxel]
    return Ground(skin, DensePoints(patch.link, points, normals, areas, taxel, parts), shape, pitch, radius)


GROUNDS: Mapping[str, Callable[[int, int], Ground]] = {"flat": flat, "bent": bent}
"""By name, for a number of taxels and a seed. The last two of each are kept: a touch changes nothing."""
