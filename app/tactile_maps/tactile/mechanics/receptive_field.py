"""What each taxel feels of the forces on the skin's quadrature points: its whole cell, or a disc about its middle.

Pressure is evaluated at the quadrature points of all patches (``quadrature_points``), whichever contact model does it.
The answer is linear, so a field is a table: for each quadrature point, the taxels that feel it and how much of its
force [1/m²].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import SimulationError
from tactile_maps.core.weak_cache import weak_cache
from tactile_maps.skin.model.skin import Quadrature, Skin, Taxels


@weak_cache
def quadrature_points(skin: Skin) -> Quadrature:
    """The quadrature points of all patches, patch after patch; their number here is what models call a point.

    Positions and normals are in the frame of the link that carries the patch; ``taxel`` is numbered through the skin.
    """
    parts = [patch.taxels.quadrature for patch in skin.patches]
    if not parts:
        return Quadrature(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
    return Quadrature(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.areas for part in parts]),
        np.concatenate([part.taxel + first for part, first in zip(parts, skin.first[:-1], strict=True)]),
    )


@weak_cache
def load_points(skin: Skin) -> Quadrature:
    """Return all points that bear load: the quadrature points, then the skin's bare points, whose taxel is -1."""
    points = quadrature_points(skin)
    bare = skin.bare_points
    if not bare:
        return points
    return Quadrature(
        np.concatenate([points.positions, *(part.positions for part in bare)]),
        np.concatenate([points.normals, *(part.normals for part in bare)]),
        np.concatenate([points.areas, *(part.areas for part in bare)]),
        np.concatenate([points.taxel, np.full(sum(len(part.areas) for part in bare), -1)]),
    )


def points_of_link(skin: Skin, link: str) -> IntArray:
    """Return the numbers of the link's ``load_points``, those that taxels read first."""
    on_link = np.array([patch.link == link for patch in skin.patches])
    bare = [np.full(len(part.areas), part.link == link) for part in skin.bare_points]
    return np.flatnonzero(np.concatenate([on_link[skin.patch_of[quadrature_points(skin).taxel]], *bare]))


@dataclass(frozen=True, eq=False)
class ReceptiveField:
    """The table, by quadrature point in the order of ``quadrature_points``.

    Attributes:
        taxels: (q, w) which taxels feel the point; w is the most that feel one.
        weights: (q, w) pressure that a taxel feels of a force on the point [1/m²]; 0 fills a row up.
    """

    taxels: IntArray
    weights: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxels", dtype=np.int64)
        freeze_arrays(self, "weights")

    def add(self, pressures: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """Add to ``pressures`` (taxels,) [Pa] what ``forces`` (k,) [N] on ``points`` (k,) make the taxels feel.

        Cost: 2 µs for 50 points that one taxel feels each.
        """
        felt = self.weights.take(points, axis=0)
        felt *= forces[:, None]
        np.add.at(pressures, self.taxels.take(points, axis=0).ravel(), felt.ravel())


def cell_field(skin: Skin) -> ReceptiveField:
    """Each taxel feels the mean pressure over the area it answers for; the sum of pressure times area is the force."""
    taxel = quadrature_points(skin).taxel
    return ReceptiveField(taxel[:, None], (1.0 / skin.areas[taxel])[:, None])


def disc_field(skin: Skin, radius: float) -> ReceptiveField:
    """Each taxel feels the mean pressure over a disc of ``radius`` [m] about its middle, as an electrode does.

    What presses between the discs is not felt. A uniform pressure is read exactly, at borders too: the mean is over
    those points of the taxel's own patch that lie in the disc and face as the taxel does. A disc smaller than the
    spacing of the points may hold none: then it is the one nearest to its middle.

    Raises:
        SimulationError: The radius is no such number.
    """
    if not (math.isfinite(radius) and radius > 0):
        remedy = "Choose 0.001 to 0.02"
        raise SimulationError("the pad radius must be positive", value=f"radius {radius} m", remedy=remedy)
    points = []
    taxels = []
    weights = []
    start = 0
    for patch, first in zip(skin.patches, skin.first[:-1], strict=True):
        point, taxel, weight = _in_discs(patch.taxels, radius)
        points.append(point + start)
        taxels.append(taxel + first)
        weights.append(weight)
        start += len(patch.taxels.quadrature.areas)
    if not points:
        return cell_field(skin)
    return field_from_entries(start, np.concatenate(points), np.concatenate(taxels), np.concatenate(weights))


def pad_displacements(skin: Skin, radius: float) -> FloatArray:
    """Return the squared distances [m²] of the discs' middles from the places of the taxels (taxels,).

    A disc is as many quadrature points as it holds, at least one: where they are farther apart than the disc is wide,
    its middle is that of the nearest one.
    """
    points = quadrature_points(skin)
    field = disc_field(skin, radius)
    shares = field.weights * points.areas[:, None]
    middles = np.zeros((len(skin), 3))
    np.add.at(middles, field.taxels, shares[:, :, None] * points.positions[:, None])
    places = [patch.taxels.positions for patch in skin.patches]
    offsets = middles - np.concatenate(places) if places else middles
    return np.asarray(np.einsum("ij,ij->i", offsets, offsets))


def field_from_entries(count: int, points: IntArray, taxels: IntArray, weights: FloatArray) -> ReceptiveField:
    """The field of ``count`` points from its entries (e,): this point is felt by that taxel with this weight [1/m²]."""
    order = np.argsort(points, kind="stable")
    points = points[order]
    taxels = taxels[order]
    weights = weights[order]
    held = np.bincount(points, minlength=count)
    column = np.arange(len(points)) - np.repeat(np.cumsum(held) - held, held)
    shape = count, max(int(held.max(initial=0)), 1)
    table = np.zeros(shape, dtype=np.int64)
    weight = np.zeros(shape)
    table[points, column] = taxels
    weight[points, column] = weights
    return ReceptiveField(table, weight)


def _in_discs(taxels: Taxels, radius: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Entries (e,) of one patch: points within ``radius`` of each taxel, taxels, weights."""
    points = taxels.quadrature
    tree = cKDTree(points.positions)
    pairs = cKDTree(taxels.positions).sparse_distance_matrix(tree, radius, output_type="coo_matrix")
    taxel = np.asarray(pairs.row, dtype=np.int64)
    point = np.asarray(pairs.col, dtype=np.int64)
    facing = np.einsum("ij,ij->i", taxels.normals[taxel], points.normals[point]) > 0
    taxel = taxel[facing]
    point = point[facing]
    empty = np.flatnonzero(np.bincount(taxel, minlength=len(taxels)) == 0)
    taxel = np.concatenate([taxel, empty])
    point = np.concatenate([point, tree.query(taxels.positions[empty])[1].astype(np.int64)])
    area = np.bincount(taxel, points.areas[point], minlength=len(taxels))
    return point, taxel, 1.0 / area[taxel]
