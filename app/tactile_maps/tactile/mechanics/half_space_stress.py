"""Normal stress inside an elastic half-space under loads on its surface, as measured by taxels below it.

Boussinesq (1885) for a force at a point, Love (1929) for pressure over a rectangle; Johnson, Contact Mechanics, 3.2 and
3.3. These results do not depend on the material: the stiffness of a cover changes the depth of a body, not the
distribution of its force.

``subsurface_field`` is a receptive field that spreads each force as the half-space does. Points that are close together
compared to the depth are combined in clusters, so that the cost depends on the area of the skin in squared depths and
not on the number of taxels. ``GridBlur`` does the same on a regular grid by fast Fourier transform. Skins are not
grids, so the half-space model does not use it; references on a fine grid do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import fftfreq, irfft2, next_fast_len, rfft2
from scipy.sparse import csr_matrix, vstack
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.caches import content_cache
from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import Quadrature, Skin
from tactile_maps.tactile.mechanics.receptive_field import (
    ReceptiveField,
    cell_field,
    field_from_entries,
    quadrature_points,
)


def point_stress(distance: FloatArray, depth: float) -> FloatArray:
    """Return the normal stress [Pa/N] of a unit force: 3 h³ / (2 π (r² + h²)^(5/2)).

    Args:
        distance: Distance along the surface from the force [m], any shape.
        depth: Depth below the surface [m], > 0.
    """
    squared = np.square(distance) + depth**2
    return np.asarray(1.5 / np.pi * depth**3 / (squared * squared * np.sqrt(squared)))


def rectangle_stress(x: FloatArray, y: FloatArray, depth: float, *, sides: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return the normal stress under a rectangle with unit pressure, by superposition of its four corners.

    Args:
        x: First coordinate from the rectangle's centre [m], any shape.
        y: Second coordinate [m], same shape.
        depth: Depth below the surface [m], > 0.
        sides: Sides of the rectangle [m], each a scalar or of that shape.

    Cost: 0.2 µs a point.
    """
    a = 0.5 * sides[0]
    b = 0.5 * sides[1]
    corners = ((x + a, y + b, 1), (x + a, y - b, -1), (x - a, y + b, -1), (x - a, y - b, 1))
    return np.asarray(sum(sign * _corner(u, v, depth) for u, v, sign in corners))


def square_stress(distance: FloatArray, depth: float, *, side: FloatArray) -> FloatArray:
    """Return the normal stress under a square, perpendicular to one of its sides, for squares of unknown orientation.

    Args:
        distance: Distance from the square's centre [m], any shape.
        depth: Depth below the surface [m], > 0.
        side: Side of the square [m], a scalar or of that shape.

    Cost: 0.1 µs a point.
    """
    half = 0.5 * side
    return np.asarray(2 * (_corner(distance + half, half, depth) - _corner(distance - half, half, depth)))


def _corner(a: FloatArray, b: FloatArray, h: float) -> FloatArray:
    """Return the stress under the corner of a rectangle a × b; odd in both sides, as superposition requires."""
    across = a * a + h * h
    along = b * b + h * h
    root = np.sqrt(across + b * b)
    both = a * b
    return np.asarray((np.arctan2(both, h * root) + both * h / root * (1 / across + 1 / along)) / (2 * np.pi))


def cutoff_radius(depth: float, share: float) -> float:
    """Return the radius [m] within which all but ``share`` of a point's force passes at ``depth`` [m].

    It is the inverse of the share within a radius, 1 - (1 + (a/h)²)^(-3/2).

    At a share of 0.01 it is 4.5 depths, at 0.001 it is 9.9.
    """
    return depth * float(np.sqrt(share ** (-2 / 3) - 1))


TAIL_SHARE = 0.01
"""Share of a force that passes outside the receptive fields."""
_CLUSTER = 0.3
"""Size of a cluster of points of a taxel in depths; a point is displaced by up to half of that."""
_FACING = 0.2
_BLOCK = 2_000_000
_MOST_PAIRS = 60_000_000


@dataclass(frozen=True, eq=False)
class SubsurfaceField(ReceptiveField):
    """The table, by cluster of quadrature points.

    Attributes:
        cluster: (q,) cluster of each quadrature point.
    """

    cluster: IntArray

    def add(self, pressures: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """Add the pressures of forces on points. Cost: 10 ns for each taxel and loaded cluster in its field."""
        summed = np.bincount(self.cluster.take(points), forces)
        loaded = np.flatnonzero(summed)
        felt = self.weights.take(loaded, axis=0)
        felt *= summed.take(loaded)[:, None]
        pressures += np.bincount(self.taxels.take(loaded, axis=0).ravel(), felt.ravel(), len(pressures))


class _Clusters(NamedTuple):
    """Centres (c, 3) [m], mean normals (c, 3), areas (c,) and links (c,) of clusters."""

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    links: IntArray


def _content(
    skin: Skin, depth: float, *, field: ReceptiveField | None = None, share: float = TAIL_SHARE
) -> Iterator[ArrayLike]:
    points = quadrature_points(skin)
    surface = field or cell_field(skin)
    yield from (points.positions, points.normals, points.areas, points.taxel, surface.taxels, surface.weights)
    yield from (skin.first, [patch.link for patch in skin.patches], depth, share)


@content_cache(_content, most=2)
def subsurface_field(
    skin: Skin, depth: float, *, field: ReceptiveField | None = None, share: float = TAIL_SHARE
) -> SubsurfaceField:
    """Return the receptive field of taxels at ``depth`` [m] below the surface.

    Rows are normalized so that the force on a cluster is measured completely, see ``models.half_space``.

    Args:
        skin: The skin.
        depth: Depth of all taxels below the surface [m], > 0.
        field: Receptive field of a taxel at its own depth; its whole cell by default.
        share: Share of a force that may pass outside the receptive fields; it is added within them.

    Raises:
        SimulationError: More than 60 million pairs of clusters are within reach: it would take gigabytes.

    The last two tables are kept, for the contact model and for the estimator of forces.

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
    """Return the cluster of each point (q,): taxels, halved along the longest axis until they fit ``size``."""
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
    """Return the clusters, and the share of each point in its cluster's area (c, q)."""
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
    """Yield blocks of rows (c, c): share of the force on a cluster that passes below each other; rows sum to one."""
    # Links are separated along a fourth axis, so that forces do not spread between them.
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
    """Stress at a depth from pressure at the surface of a grid. Built once.

    The grid is padded to twice its size, so that nothing wraps around the borders.

    Args:
        shape: Number of rows and columns.
        pitch: Height and width of a cell [m].
        depth: Depth of the taxels below the surface [m], > 0.
        distance: Distance through the body as a function of offsets in rows and columns [m], for a curved grid. Cells
            are then points, with an error of 1e-5 for cells up to half the depth. None for a flat grid.

    Cost: 60 ms for 450 × 450 cells, per call and to build.
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
        """Return the normal stress at the depth below every cell's centre for ``pressures`` on the cells."""
        spread = irfft2(rfft2(pressures, self._size) * self._symbol, self._size)
        return np.asarray(spread[: self._shape[0], : self._shape[1]])
