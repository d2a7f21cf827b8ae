"""Known touches: a ball pressed into a bed of springs with so many samples that the sampling error is negligible.

The code is independent of the contact models that it is compared with: a signed distance in closed form, summed over
every point. The pressure below the surface is the Boussinesq stress of those forces. ``REFERENCE_SKINS`` are a flat
skin and a tube, each with a grid of 200,000 points as the reference for its taxels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.studies.testbeds.reference_bodies import SIDE, flat_map, tube
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.half_space_stress import GridBlur
from tactile_maps.tactile.mechanics.loads import Load, Sphere

INDENTATION = 1e-3
"""Indentation of the balls [m]."""
_FACING = 0.2

Blur = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class DensePoints:
    """Points spread over the skin of a link, or over the part around a touch.

    Attributes:
        link: Name of the link.
        positions: (k, 3) [m], link frame.
        normals: (k, 3) outward.
        areas: (k,) [m²].
        taxel: (k,) number of the taxel that senses each point, counted over the whole skin.
        parts: (k,) area of the taxel's cell that each point represents [m²]. It differs from the area of the point
            where a cell has so few points that their areas do not sum to that of the cell.
    """

    link: str
    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    taxel: IntArray
    parts: FloatArray


@dataclass(frozen=True, eq=False)
class ReferenceTouch:
    """Input of a contact model and its true output.

    Attributes:
        load: Force, centre of pressure and the ball.
        surface: (taxels,) force on the cell of each taxel [N].
        felt: (taxels,) force through the cell of each taxel at the depth of the taxels [N].
    """

    load: Load
    surface: FloatArray
    felt: FloatArray


def ball_radius(contact: float) -> float:
    """Return the radius of a ball whose contact with a plane at depth ``INDENTATION`` has radius ``contact`` [m]."""
    return (contact**2 + INDENTATION**2) / (2 * INDENTATION)


def press_ball(
    dense: DensePoints,
    at: FloatArray,
    normal: FloatArray,
    contact: float,
    *,
    taxels: int,
    blur: Blur,
    layer: ElasticLayer,
) -> ReferenceTouch:
    """Press a ball into the skin at a point: springs along its radii, sensed across the skin.

    Args:
        dense: Skin around the point.
        at: (3,) the point [m].
        normal: (3,) outward normal there, the direction of the ball.
        contact: Radius of the contact on a plane [m].
        taxels: Number of taxels of the whole skin.
        blur: Function from pressures at the points to those at the depth of the taxels.
        layer: Layer whose foundation yields.
    """
    radius = ball_radius(contact)
    centre = at + (radius - INDENTATION) * normal
    away = dense.positions - centre
    far = np.linalg.norm(away, axis=1)
    across = -np.einsum("ij,ij->i", away, dense.normals) / np.maximum(far, 1e-12)
    sunk = np.maximum(radius - far, 0)
    sunk[dense.normals @ normal < _FACING] = 0
    pressures = layer.foundation * sunk * across
    forces = pressures * dense.areas
    force = float(forces.sum())
    aside = forces @ (dense.positions - at) / force
    point = at + aside - (aside @ normal) * normal
    load = Load(dense.link, point, normal, force, Sphere(radius), Pose(np.eye(3), centre))
    return ReferenceTouch(
        load, _force_per_taxel(dense, pressures, taxels), _force_per_taxel(dense, blur(pressures), taxels)
    )


def _force_per_taxel(dense: DensePoints, pressures: FloatArray, taxels: int) -> FloatArray:
    """(taxels,) force on each cell [N]; the sum is the total force."""
    forces = np.bincount(dense.taxel, pressures * dense.parts, taxels)
    return np.asarray(forces * (pressures @ dense.areas / forces.sum()))


def displace_ball(touch: ReferenceTouch, by: float) -> ReferenceTouch:
    """Return the same touch with the position of the ball in the load displaced along the skin [m].

    Force and centre of pressure are unchanged, because collision hulls are less accurate than the solver's forces.
    """
    load = touch.load
    helper = np.eye(3)[np.abs(load.normal).argmin()]
    aside = np.cross(load.normal, helper)
    pose = Pose(load.pose.rotation, load.pose.translation + by * aside / np.linalg.norm(aside))
    return replace(touch, load=replace(load, pose=pose))


def pairwise_blur(dense: DensePoints, depth: float) -> Blur:
    """Return the stress at ``depth`` [m] by summation over all pairs of a few thousand points. Cost: 0.1 µs a pair."""

    def felt(pressures: FloatArray) -> FloatArray:
        pressed = np.flatnonzero(pressures)
        sources = dense.positions[pressed]
        squared = ((dense.positions[:, None] - sources) ** 2).sum(axis=2) + depth**2
        kernel = 3 * depth**3 / (2 * np.pi * squared**2.5)
        kernel[dense.normals @ dense.normals[pressed].T < _FACING] = 0
        return np.asarray(kernel @ (pressures * dense.areas)[pressed])

    return felt


def touch_errors(
    touch: ReferenceTouch, pressures: FloatArray, skin: Skin, centres: FloatArray
) -> Mapping[str, float | None]:
    """Return the errors of the pressures of a model.

    Args:
        touch: Input of the model and its true output.
        pressures: (taxels,) output of the model [Pa].
        skin: The skin.
        centres: (taxels, 3) centres of the taxels' cells [m], see ``cell_centres``.

    Returns:
        ``force_percent``: error of the total force. ``place_mm``: error of the centre of pressure along the skin, None
        without pressure. ``surface_percent`` and ``depth_percent``: sum of the wrong forces on the cells, as a share of
        the total force, at the surface and at the depth of the taxels.
    """
    load = touch.load
    forces = pressures * skin.areas
    total = float(forces.sum())
    place = None
    if total > 0:
        aside = forces @ (centres - load.point) / total
        place = 1e3 * float(np.linalg.norm(aside - (aside @ load.normal) * load.normal))
    return {
        "force_percent": 100 * abs(total - load.force) / load.force,
        "place_mm": place,
        "surface_percent": 100 * float(np.abs(forces - touch.surface).sum()) / load.force,
        "depth_percent": 100 * float(np.abs(forces - touch.felt).sum()) / load.force,
    }


def cell_centres(skin: Skin) -> FloatArray:
    """Return the mean position of each taxel's cell (taxels, 3) [m], link frame, where its force acts."""
    centres = []
    for patch in skin.patches:
        points = patch.taxels.quadrature
        count = len(patch.taxels)
        sums = [np.bincount(points.taxel, points.areas * points.positions[:, axis], count) for axis in range(3)]
        centres.append(np.column_stack(sums) / patch.taxels.areas[:, None])
    return np.concatenate(centres)


RADIUS = 0.036
LENGTH = 0.2
"""Radius and length of the bent skin, a tube like a forearm [m]."""
_LEAST_FACES = 24_000
_FACES = 12
_POINTS = 200_000


@dataclass(frozen=True, eq=False)
class ReferenceSkin:
    """A skin of one patch and the grid on it.

    Attributes:
        skin: Skin with taxels.
        dense: Points of the grid, row by row.
        shape: Numbers of rows and columns of the grid.
        pitch: Distances of rows and of columns along the skin [m].
        radius: Radius of the tube, whose columns go around it [m]; inf for a flat skin.
    """

    skin: Skin
    dense: DensePoints
    shape: tuple[int, int]
    pitch: tuple[float, float]
    radius: float

    def blur(self, depth: float) -> Blur:
        """Return the blur from pressures on the grid to those at ``depth`` [m]; distances are straight lines."""
        bent = None if np.isinf(self.radius) else self._chord
        grid = GridBlur(self.shape, self.pitch, depth, distance=bent)
        return lambda pressures: grid.felt(pressures.reshape(self.shape)).ravel()

    def _chord(self, up: FloatArray, around: FloatArray) -> FloatArray:
        return np.hypot(up, 2 * self.radius * np.sin(np.minimum(0.5 * around / self.radius, np.pi / 2)))

    def place(self, across: float, up: float) -> tuple[FloatArray, FloatArray]:
        """Return point and outward normal (3,) at a distance from the middle of the grid [m]."""
        row, column = (round(n / 2 + step / p) for n, step, p in zip(self.shape, (up, across), self.pitch, strict=True))
        number = row * self.shape[1] + column
        return self.dense.positions[number], self.dense.normals[number]


@lru_cache(maxsize=2)
def flat_skin(taxels: int, seed: int) -> ReferenceSkin:
    """Return a square with a side of 100 mm, with taxels at random in grid cells. Cost: 1 s, and 0.1 ms a taxel."""
    side = round(np.sqrt(_POINTS))
    pitch = SIDE / side
    steps = pitch * (np.arange(side) + 0.5)
    up, across = np.meshgrid(steps, steps, indexing="ij")
    points = np.column_stack([across.ravel(), up.ravel(), np.zeros(up.size)])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    return _reference_skin(flat_map(taxels, seed=seed).skin, points, normals, (side, side), (pitch, pitch), np.inf)


@lru_cache(maxsize=2)
def tubular_skin(taxels: int, seed: int) -> ReferenceSkin:
    """Return a tube with a radius of 36 mm, open at both ends, with even taxels. Cost: 1 s, and 1 ms a taxel."""
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
    skin = Skin((Patch("tube", "tube", surface, place_evenly(surface, taxels, seed=seed)),))
    return _reference_skin(skin, points, normals, (rows, columns), pitch, RADIUS)


def _reference_skin(
    skin: Skin,
    points: FloatArray,
    normals: FloatArray,
    shape: tuple[int, int],
    pitch: tuple[float, float],
    radius: float,
) -> ReferenceSkin:
    patch = skin.patches[0]
    taxel = cKDTree(patch.taxels.positions).query(points)[1].astype(np.int64)
    areas = np.full(len(points), pitch[0] * pitch[1])
    # The cell of a small taxel contains some 20 points, whose areas differ from that of the cell by a tenth.
    parts = (patch.taxels.areas / np.maximum(np.bincount(taxel, minlength=len(skin)), 1))[taxel]
    return ReferenceSkin(skin, DensePoints(patch.link, points, normals, areas, taxel, parts), shape, pitch, radius)


REFERENCE_SKINS: Mapping[str, Callable[[int, int], ReferenceSkin]] = {"flat": flat_skin, "bent": tubular_skin}
"""Skins by name, as functions of number of taxels and seed. The last two of each are cached."""
