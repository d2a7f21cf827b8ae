"""Normal stress inside an elastic half-space under loads on its surface: what a taxel below the surface feels.

Boussinesq (1885) for a force at a point, Love (1929) for pressure over a rectangle; Johnson, Contact Mechanics, 3.2 and
3.3. None depends on the material: how stiff a cover is changes how deep a body sinks in, not how its force spreads.

``subsurface_field`` makes a receptive field of them that spreads each force as the half-space does. Points that are
close together compared to the depth are felt alike, so they are taken in clusters: the work depends on how much skin
there is in depths, however fine its taxels are. ``GridBlur`` is the same on a regular grid, every cell at once by fast
Fourier transform. Skins are no grids, so the half-space model does not use it; a sheet of taxels or a reference on a
fine grid may.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.fft import fftfreq, irfft2, next_fast_len, rfft2
from scipy.sparse import csr_matrix, vstack
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import Quadrature, Skin
from tactile_maps.tactile.mechanics.receptive_field import (
    ReceptiveField,
    cell_field,
    field_from_entries,
    quadrature_points,
)


def point_stress(distance: FloatArray, depth: float) -> FloatArray:
    """Normal stress [Pa/N] of a unit force: 3 h³ / (2 π (r² + h²)^(5/2)).

    Args:
        distance: Along the surface from the force [m], any shape.
        depth: Below the surface [m], > 0.
    """
    squared = np.square(distance) + depth**2
    return np.asarray(1.5 / np.pi * depth**3 / (squared * squared * np.sqrt(squared)))


def rectangle_stress(x: FloatArray, y: FloatArray, depth: float, *, sides: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Normal stress under a rectangle that bears unit pressure, by superposition of its four corners.

    Args:
        x: Across from the rectangle's middle [m], any shape.
        y: Along likewise.
        depth: Below the surface [m], > 0.
        sides: Of the rectangle [m], each one number or of that shape.

    Cost: 0.2 µs a point.
    """
    a = 0.5 * sides[0]
    b = 0.5 * sides[1]
    corners = ((x + a, y + b, 1), (x + a, y - b, -1), (x - a, y + b, -1), (x - a, y - b, 1))
    return np.asarray(sum(sign * _corner(u, v, depth) for u, v, sign in corners))


def square_stress(distance: FloatArray, depth: float, *, side: FloatArray) -> FloatArray:
    """The same under a square, straight out from one of its sides: for squares whose turn nobody knows.

    Args:
        distance: From the square's middle [m], any shape.
        depth: Below the surface [m], > 0.
        side: Of the square [m], one number or of that shape.

    Cost: 0.1 µs a point.
    """
    half = 0.5 * side
    return np.asarray(2 * (_corner(distance + half, half, depth) - _corner(distance - half, half, depth)))


def _corner(a: FloatArray, b: FloatArray, h: float) -> FloatArray:
    """Stress under the corner of a rectangle a × b; odd in both sides, as superposition needs."""
    across = a * a + h * h
    along = b * b + h * h
    root = np.sqrt(across + b * b)
    both = a * b
    return np.asarray((np.arctan2(both, h * root) + both * h / root * (1 / across + 1 / along)) / (2 * np.pi))


def disc_stress(radius: FloatArray, depth: float) -> FloatArray:
    """Normal stress on the axis of a disc that bears unit pressure: 1 - (1 + (a/h)²)^(-3/2).

    Also the share of a point's force that passes within ``radius`` of the axis at that depth.

    Args:
        radius: Of the disc [m], any shape.
        depth: Below the surface [m], > 0.
    """
    return np.asarray(1 - (1 + np.square(np.asarray(radius) / depth)) ** -1.5)


def cutoff_radius(depth: float, share: float) -> float:
    """How far from the axis [m] all but ``share`` of a point's force passes at ``depth`` [m]; ``disc_stress`` solved.

    At a share of 0.01 it is 4.5 depths, at 0.001 it is 9.9.
    """
    return depth * float(np.sqrt(share ** (-2 / 3) - 1))


TAIL_SHARE = 0.01
"""Of a force, what passes so far aside that its whereabouts are not followed."""
_CLUSTER = 0.3
"""Points of a taxel are taken together within a box of so many depths: felt up to half of that from where they are."""
_FACING = 0.2
_BLOCK = 2_000_000
_MOST_PAIRS = 60_000_000


@dataclass(frozen=True, eq=False)
class SubsurfaceField(ReceptiveField):
    """The table, by cluster of quadrature points.

    Attributes:
        cluster: (q,) which cluster each quadrature point belongs to.
    """

    cluster: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        freeze_arrays(self, "cluster", dtype=np.int64)

    def add(self, pressures: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """As of every receptive field. Cost: 10 ns for each taxel that feels a cluster under load."""
        summed = np.bincount(self.cluster.take(points), forces)
        loaded = np.flatnonzero(summed)
        felt = self.weights.take(loaded, axis=0)
        felt *= summed.take(loaded)[:, None]
        pressures += np.bincount(self.taxels.take(loaded, axis=0).ravel(), felt.ravel(), len(pressures))


class _Clusters(NamedTuple):
    """Middles (c, 3) [m], mean normals (c, 3), areas (c,) and links (c,) of clusters."""

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    links: IntArray


def subsurface_field(
    skin: Skin, depth: float, *, field: ReceptiveField | None = None, share: float = TAIL_SHARE
) -> SubsurfaceField:
    """What taxels feel of forces on the surface ``depth`` [m] above them.

    Each row is made to keep its force: what a cluster bears is felt whole, see ``models.half_space``.

    Args:
        skin: The skin.
        depth: Of all taxels below it [m], > 0.
        field: What a taxel feels of the stress about it; its whole cell by default.
        share: Of a force, what may pass beyond the receptive fields; it is felt within them instead.

    Raises:
        SimulationError: More than 60 million pairs of clusters are within reach: it would take gigabytes.

    Cost: 0.2 µs a pair of clusters within reach: 0.2 s for a flat 100 cm² in 1,000 taxels at 2 mm, 1 s for a tube of
    450 cm², 8 s and 150 MB when that has 10,000 taxels.
    """
    points = quadrature_points(skin)
    cluster = _clustered(points, _CLUSTER * depth)
    clusters, share_of = _gathered(skin, points, cluster)
    surface = field or cell_field(skin)
    count, width = surface.taxels.shape
    rows = np.repeat(np.arange(count), width)
    felt = csr_matrix((surface.weights.ravel(), (rows, surface.taxels.ravel())), shape=(count, len(skin)))
    felt = share_of @ felt
    below = vstack([part @ felt for part in _stress_rows(clusters, depth, cutoff_radius(depth, share))]).tocoo()
    table = field_from_entries(len(clusters.areas), below.row.astype(np.int64), below.col.astype(np.int64), below.data)
    return SubsurfaceField(table.taxels, table.weights, cluster)


def _clustered(points: Quadrature, size: float) -> IntArray:
    """(q,) number of each point's cluster: a taxel's points, halved along the longest axis until a box of ``size``
    holds them.
    """
    cluster = np.unique(points.taxel, return_inverse=True)[1]
    while True:
        order = np.argsort(cluster, kind="stable")
        starts = np.flatnonzero(np.diff(cluster[order], prepend=-1))
        low = np.minimum.reduceat(points.positions[order], starts)
        high = np.maximum.reduceat(points.positions[order], starts)
        axis = (high - low).argmax(axis=1)
        wide = (high - low).max(axis=1) > size
        if not wide.any():
            return cluster.astype(np.int64)
        middle = 0.5 * np.take_along_axis(low + high, axis[:, None], axis=1)[:, 0]
        along = np.take_along_axis(points.positions, axis[cluster][:, None], axis=1)[:, 0]
        cluster = np.unique(2 * cluster + (wide[cluster] & (along > middle[cluster])), return_inverse=True)[1]


def _gathered(skin: Skin, points: Quadrature, cluster: IntArray) -> tuple[_Clusters, csr_matrix]:
    """The clusters, and (c, q) the share of each point in its cluster's area."""
    number = np.arange(len(cluster))
    areas = np.bincount(cluster, points.areas).astype(np.float64)
    share_of = csr_matrix((points.areas / areas[cluster], (cluster, number)), shape=(len(areas), len(cluster)))
    normals = share_of @ points.normals
    names = {patch.link: number for number, patch in enumerate(skin.patches)}
    wearer = np.array([names[patch.link] for patch in skin.patches])
    links = np.empty(len(areas), dtype=np.int64)
    links[cluster] = wearer[skin.patch_of[points.taxel]]
    return _Clusters(share_of @ points.positions, normals, areas, links), share_of


def _stress_rows(clusters: _Clusters, depth: float, radius: float) -> Iterator[csr_matrix]:
    """Rows (c, c), some at a time: which share of the force on a cluster passes below each; a row sums to one."""
    # Links lie apart along a fourth axis, so that none feels through another.
    places = np.column_stack([clusters.positions, 4 * radius * clusters.links])
    tree = cKDTree(places)
    count = len(places)
    pairs = int(tree.count_neighbors(tree, radius))
    if pairs > _MOST_PAIRS:
        raise SimulationError(
            "the cover is too deep for so fine a skin",
            place="layer.depth",
            value=f"{1e3 * depth:g} mm, {pairs:,} pairs of places",
            remedy="Choose a shallower cover, fewer taxels or another contact model",
        )
    step = max(_BLOCK * count // max(pairs, 1), 1)
    for start in range(0, count, step):
        here = np.arange(start, min(start + step, count))
        near = cKDTree(places[here]).sparse_distance_matrix(tree, radius, output_type="ndarray")
        source = here[near["i"]]
        target = near["j"]
        alike = np.einsum("ij,ij->i", clusters.normals[source], clusters.normals[target]) > _FACING
        source = source[alike]
        target = target[alike]
        away = near["v"][alike]
        passing = clusters.areas[target] * square_stress(away, depth, side=np.sqrt(clusters.areas)[source])
        total = np.bincount(source - start, passing, len(here))
        yield csr_matrix((passing / total[source - start], (source - start, target)), shape=(len(here), count))


Distance = Callable[[FloatArray, FloatArray], FloatArray]


class GridBlur:
    """Pressure at a depth from pressure at the surface of a grid. Built once.

    The grid is padded to twice its size, so nothing wraps: what is pressed at a border is not felt at the other.

    Args:
        shape: Cells up and across.
        pitch: Sides of a cell [m], up and across.
        depth: Of the taxels below the surface [m], > 0.
        distance: From steps up and across [m] to the distance through the body, where the grid is bent; cells then are
            taken for points, which is right to 1e-5 where a cell is no wider than half the depth. Flat if None.

    Cost: 60 ms for 450 × 450 cells, each time and to build.
    """

    def __init__(
        self, shape: tuple[int, int], pitch: tuple[float, float], depth: float, *, distance: Distance | None = None
    ) -> None:
        self._shape = shape
        self._size = (next_fast_len(2 * shape[0], real=True), next_fast_len(2 * shape[1], real=True))
        steps = [step * np.abs(fftfreq(size, 1 / size)) for step, size in zip(pitch, self._size, strict=True)]
        up, across = np.meshgrid(*steps, indexing="ij")
        if distance is None:
            kernel = rectangle_stress(up, across, depth, sides=(np.array(pitch[0]), np.array(pitch[1])))
        else:
            kernel = pitch[0] * pitch[1] * point_stress(distance(up, across), depth)
        self._symbol = rfft2(kernel)

    def felt(self, pressures: FloatArray) -> FloatArray:
        """Normal stress at the depth under every cell's middle, of ``pressures`` on the cells, both of the shape."""
        spread = irfft2(rfft2(pressures, self._size) * self._symbol, self._size)
        return np.asarray(spread[: self._shape[0], : self._shape[1]])
