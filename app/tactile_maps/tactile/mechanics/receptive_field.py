"""Receptive fields: pressures on taxels for forces on the skin's quadrature points, over cells or discs.

All contact models evaluate forces at the quadrature points of all patches (``quadrature_points``). The response is
linear, so a field is a table with the taxels that measure each quadrature point and the weight of its force [1/m²].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import Finding, SimulationError, places_finding
from tactile_maps.skin.model.skin import Quadrature, Skin, Taxels

_SPARSE = 0.2
"""Share of the skin that pads cover below which a finding states what they miss; ROBOSKIN's cover 0.3."""


@weak_cache
def quadrature_points(skin: Skin) -> Quadrature:
    """Return the quadrature points of all patches, patch after patch; models use their numbers.

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
class ReceptiveField(ArrayFields):
    """The table, by quadrature point in the order of ``quadrature_points``.

    Attributes:
        taxels: (q, w) taxels that measure the point; w is their largest number.
        weights: (q, w) pressure of a taxel per force on the point [1/m²]; rows are padded with 0.
    """

    taxels: IntArray
    weights: FloatArray

    def add(self, pressures: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """Add the pressures of ``forces`` (k,) [N] on ``points`` (k,) to ``pressures`` (taxels,) [Pa].

        Cost: 2 µs for 50 points with one taxel each.
        """
        felt = self.weights.take(points, axis=0)
        felt *= forces[:, None]
        np.add.at(pressures, self.taxels.take(points, axis=0).ravel(), felt.ravel())


def cell_field(skin: Skin) -> ReceptiveField:
    """Return the field of whole cells: each taxel measures the mean pressure over its area, which conserves force."""
    taxel = quadrature_points(skin).taxel
    return ReceptiveField(taxel[:, None], (1.0 / skin.areas[taxel])[:, None])


def disc_field(skin: Skin, radius: float) -> ReceptiveField:
    """Return the field of discs: each taxel measures the mean pressure over ``radius`` [m], like an electrode.

    Force between the discs is not measured. A uniform pressure is measured exactly, also at borders: the mean is over
    the points of the taxel's own patch that are in the disc and face in its direction. If a disc contains no point, the
    nearest point is used.

    Raises:
        SimulationError: The radius is not positive.
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


def sparse_pads_findings(skin: Skin, radius: float) -> list[Finding]:
    """Return the finding about links whose pads of this ``radius`` [m] cover little of the skin; empty without any."""
    links = np.repeat([patch.link for patch in skin.patches], [len(patch.taxels) for patch in skin.patches])
    areas = {str(link): float(skin.areas[links == link].mean()) for link in dict.fromkeys(links)}
    pad = math.pi * radius**2
    sparse = [link for link, area in areas.items() if pad < _SPARSE * area]
    widest = max((areas[link] for link in sparse), default=pad)
    action = (
        f"pads cover {100 * pad / widest:.2g} % of the skin (area averaging, radius {1e3 * radius:.2g} mm), and taxels "
        f"are {1e3 * math.sqrt(widest):.2g} mm apart: a narrower contact is not felt between pads, and is read as up "
        f"to {widest / pad:.2g} times its force on a pad; use larger pads, more taxels or no area averaging"
    )
    return places_finding("sparse-pads", sparse, action)


def pad_displacements(skin: Skin, radius: float) -> FloatArray:
    """Return the squared distances [m²] of the discs' centres from the places of the taxels (taxels,).

    A disc consists of the quadrature points in it, at least one: where they are farther apart than the disc is wide,
    its centre is the nearest point.
    """
    points = quadrature_points(skin)
    field = disc_field(skin, radius)
    shares = field.weights * points.areas[:, None]
    middles = np.zeros((len(skin), 3))
    np.add.at(middles, field.taxels, shares[:, :, None] * points.positions[:, None])
    offsets = middles - skin.positions
    return np.asarray(np.einsum("ij,ij->i", offsets, offsets))


def field_from_entries(count: int, points: IntArray, taxels: IntArray, weights: FloatArray) -> ReceptiveField:
    """Return the field of ``count`` points from entries (e,) of points, taxels and weights [1/m²]."""
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
    """Return entries (e,) of one patch: points within ``radius`` of each taxel, taxels, weights."""
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
