"""Points of a link's skin near a body, and their distances from it, with a cache for queries at every step.

A signed distance changes no faster than its body moves. After a search for all points closer to the body than a cutoff,
those points include all that are closer than the cutoff minus the motion of the body since then. A new search is needed
only after the body has moved by half the spacing of points. The cache never changes a result.

``CellGrid`` sorts points into boxes, so that distant boxes are skipped as a whole. ``CachedNeighbourhood`` contains the
points near a body and tests whether they are still valid. ``LinkBroadphase`` combines both for one link.
"""

from __future__ import annotations

import math
from copy import copy
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.loads import Load, Sphere
from tactile_maps.tactile.mechanics.receptive_field import load_points, points_of_link, quadrature_points
from tactile_maps.tactile.mechanics.winkler import WarmStart


class CellGrid:
    """Points sorted into cubes. Built once.

    Args:
        positions: (n, 3) [m], link frame.
        size: Edge of the cubes [m]; with 8 spacings a cube holds some 60 points of a surface.

    Attributes:
        order: (n,) the points, cube after cube; ``members`` are indices into it.
    """

    def __init__(self, positions: FloatArray, size: float) -> None:
        grid = np.floor((positions - positions.min(axis=0)) / size).astype(np.int64)
        wide, high = grid.max(axis=0)[1:] + 1
        _, cell, counts = np.unique(
            (grid[:, 0] * wide + grid[:, 1]) * high + grid[:, 2], return_inverse=True, return_counts=True
        )
        self.order: IntArray = np.argsort(cell, kind="stable")
        self._counts = counts
        self._starts = np.cumsum(counts) - counts
        self._centres = np.stack([np.bincount(cell, positions[:, k]) for k in range(3)], axis=1) / counts[:, None]
        away = np.linalg.norm(positions - self._centres[cell], axis=1)
        self._radii = np.maximum.reduceat(away[self.order], self._starts)

    def lowest(self, load: Load) -> FloatArray:
        """Return a lower bound of the distance [m] of each cell's points from the load's body (cells,)."""
        return load.distances(self._centres) - self._radii

    def members(self, cells: IntArray) -> IntArray:
        """Return the indices into ``order`` of the points in ``cells``, cell after cell."""
        counts = self._counts[cells]
        ends = np.cumsum(counts)
        return np.arange(counts.sum()) + np.repeat(self._starts[cells] - ends + counts, counts)


TILT = 0.05
"""Rotation of the load's normal up to which a neighbourhood is valid [rad]."""


class CachedNeighbourhood:
    """All points of a link that face a load and are closer to its body than a cutoff.

    Args:
        load: The load at its present pose.
        facing: Cosine between the normals of point and load above which the point faces the load.
        points: (k,) numbers of the points.
        positions: (k, 3) positions of all points with a cosine above ``facing`` - TILT, link frame [m].
        normals: (k, 3) outward normals.
        areas: (k,) areas [m²].
        cutoff: Distance below which the points are complete [m].
        slack: Motion of the body after which a new search is needed [m].
        depth: Depth of the load above the closest point [m], a hint for the next search.
        extent: Largest distance of a point of the link from the load's point [m].
    """

    def __init__(
        self,
        load: Load,
        facing: float,
        points: IntArray,
        positions: FloatArray,
        normals: FloatArray,
        areas: FloatArray,
        *,
        cutoff: float,
        slack: float,
        depth: float,
        extent: float,
    ) -> None:
        self.points = points
        self.positions = positions
        self.areas = areas
        self.depth = depth
        self.shape = load.shape
        self.search_radius = cutoff
        self.guess = WarmStart()
        self._facing = facing
        self._cutoff = cutoff
        self._slack = slack
        self._normal = load.normal.tolist()
        cosines = normals @ load.normal
        # Only points near the limit may change between facing and not facing while the neighbourhood is valid.
        self._doubtful = normals if len(normals) and (cosines <= facing + TILT).any() else None
        self._round = isinstance(load.shape, Sphere)
        self._pivot = load.point
        self._rotation = load.pose.rotation
        self._place = self._where(load)
        beyond = load.shape.reach + max(cutoff, 0.0) + float(np.linalg.norm(load.pose.translation - load.point))
        self._lever = min(beyond, extent)

    def holds(self, load: Load, facing: float) -> bool:
        """Whether the points are valid for ``load``; updates ``search_radius``."""
        if not (self.shape is load.shape or self.shape == load.shape) or facing != self._facing:
            return False
        if math.dist(load.normal.tolist(), self._normal) > TILT:
            return False
        moved = math.dist(self._where(load), self._place)
        if not self._round and moved <= self._slack:
            moved += self._lever * math.dist(load.pose.rotation.ravel().tolist(), self._rotation.ravel().tolist())
        self.search_radius = self._cutoff - moved
        return moved <= self._slack

    def distances(self, load: Load) -> FloatArray:
        """Return signed distances (k,) of the points from the load's body [m]; inf for points that do not face it."""
        offset = self.positions - load.pose.translation
        distances = load.shape.distance(offset if self._round else offset @ load.pose.rotation)
        if self._doubtful is not None:
            distances[self._doubtful @ load.normal <= self._facing] = math.inf
        return distances

    def _where(self, load: Load) -> list[float]:
        """Return the body's position [m]: its centre, or the pivot in the body's frame if it is not round."""
        if self._round:
            return load.pose.translation.tolist()
        return ((self._pivot - load.pose.translation) @ load.pose.rotation).tolist()


FACING = 0.2
"""Cosine between the normals of a point and a load above which the point bears the load."""
_MISFIT = 0.01
"""Typical gap between collision hull and skin [m]: a body at this distance plus three spacings still touches."""
_EMPTY = 0.005
"""Approach of a distant body after which a new search is needed [m]."""
_REMEMBERED = 32
_FIRST = 8
_DEEPEST = 0.02


class NearbyPoints(NamedTuple):
    """Points that face a load, and their distances from its body.

    Attributes:
        points: (k,) numbers through the skin, as in ``load_points``.
        positions: (k, 3) positions [m], link frame.
        areas: (k,) areas [m²].
        distances: (k,) signed distances from the body [m]; inf for points that do not face the load.
        search_radius: Distance from the body below which the facing points are complete [m].
        guess: Points that bore the load at the last query.
    """

    points: IntArray
    positions: FloatArray
    areas: FloatArray
    distances: FloatArray
    search_radius: float
    guess: WarmStart


class LinkBroadphase:
    """Points of one link that bear load, with a cache of recent queries.

    Args:
        skin: The skin.
        link: Link with a patch.

    Attributes:
        points: (n,) numbers of the link's points through the skin, as in ``load_points``; near ones together.
        read: Number of points that taxels read; higher numbers are bare points.
        has_bare: Whether the link has bare points.
        spacing: Spacing of the points that taxels read [m].
        contact_range: Distance from all points beyond which a body presses outside the skin [m].
    """

    def __init__(self, skin: Skin, link: str) -> None:
        everything = load_points(skin)
        own = points_of_link(skin, link)
        self.read = len(quadrature_points(skin).areas)
        self.spacing = float(np.sqrt(np.median(everything.areas[own[own < self.read]])))
        self._cells = CellGrid(everything.positions[own], 8 * self.spacing)
        self.points: IntArray = own[self._cells.order]
        self.has_bare = bool((own >= self.read).any())
        self._positions = everything.positions[self.points]
        self._normals = everything.normals[self.points]
        self._areas = everything.areas[self.points]
        self._middle = self._positions.mean(axis=0)
        self._radius = float(np.linalg.norm(self._positions - self._middle, axis=1).max())
        self.contact_range = 3 * self.spacing + _MISFIT
        self._slack = min(max(0.5 * self.spacing, 1e-3), 3e-3)
        self._near: list[CachedNeighbourhood] = []

    def near(self, load: Load, *, upto: float | None = None, facing: float = FACING) -> NearbyPoints | None:
        """Return the points that face ``load`` and are closest to its body; None if it presses outside the skin.

        Args:
            load: Load on this link.
            upto: Distance from the body [m] up to which the points must be complete; by default the closest are
                included.
            facing: Cosine between the normals of point and load above which the point faces the load.

        Raises:
            SimulationError: The pose of the body is not finite.

        Cost: 5 µs for a ball and 100 points while the body moves less than half a spacing, and 0.05 ms for a search
            after a larger motion. A mesh takes 1 to 3 µs a point in both cases.
        """
        near = self._remembered(load, facing)
        if near is None or (upto is not None and near.search_radius < upto):
            near = self._search(load, facing, upto)
        if not near.points.size:
            return None
        distances = near.distances(load)
        if distances[distances.argmin()] > self.contact_range:
            return None
        return NearbyPoints(near.points, near.positions, near.areas, distances, near.search_radius, near.guess)

    def nearest(self, load: Load) -> int | None:
        """Return the point closest to a body that no point faces; None if it presses outside the skin.

        Points that face away from the load are on the other side of the link and never bear it.
        """
        found = self.near(load, facing=-FACING)
        return None if found is None else int(found.points[found.distances.argmin()])

    def forget(self) -> LinkBroadphase:
        """Clear the cache and return the object."""
        self._near = []
        return self

    def _remembered(self, load: Load, facing: float) -> CachedNeighbourhood | None:
        for near in reversed(self._near):
            if near.holds(load, facing):
                return near
        return None

    def _search(self, load: Load, facing: float, upto: float | None) -> CachedNeighbourhood:
        """Find the points and store them in the cache, in place of a valid older neighbourhood."""
        if not np.isfinite(load.pose.translation).all():
            raise SimulationError(
                "the pose of a body is not finite", place=f"on {load.link}", value=load.pose.translation.tolist()
            )
        hint = next((near.depth for near in reversed(self._near) if near.shape == load.shape), 0.0)
        seen = facing - TILT
        lowest = self._cells.lowest(load)
        limit = self.contact_range + _EMPTY
        least, _, _ = self._closer(load, seen, np.argsort(lowest)[:_FIRST])
        cutoff = self._cutoff(min(least, limit), hint, upto)
        least, here, distances = self._closer(load, seen, np.flatnonzero(lowest <= cutoff))
        if least > limit:  # an empty neighbourhood is valid until the body may touch
            cutoff = limit
            here = here[:0]
        else:
            cutoff = self._cutoff(least, hint, upto)
            here = here[distances <= cutoff]
        near = CachedNeighbourhood(
            load,
            facing,
            self.points[here],
            self._positions[here],
            self._normals[here],
            self._areas[here],
            cutoff=cutoff,
            slack=self._slack,
            depth=hint if upto is None else min(max(upto - least, 0.0), _DEEPEST),
            extent=math.dist(load.point, self._middle) + self._radius,
        )
        self._near = [old for old in self._near if not old.holds(load, facing)][1 - _REMEMBERED :] + [near]
        return near

    def _cutoff(self, least: float, depth: float, upto: float | None) -> float:
        """Return the cutoff [m] that stays sufficient until the body has moved by the slack."""
        level = least + depth if upto is None else max(least, upto)
        return level + 2 * self._slack

    def _closer(self, load: Load, seen: float, cells: IntArray) -> tuple[float, IntArray, FloatArray]:
        """Return smallest distance, indices and distances of the points of ``cells`` with a cosine above ``seen``."""
        here = self._cells.members(cells)
        here = here[self._normals[here] @ load.normal > seen]
        distances = load.distances(self._positions[here]) if here.size else np.zeros(0)
        return float(distances.min(initial=math.inf)), here, distances


def link_broadphases(skin: Skin) -> dict[str, LinkBroadphase]:
    """Return the broadphase of each link with points, with empty caches. The sorted points are stored with the skin."""
    return {link: copy(bed).forget() for link, bed in _sorted_points(skin).items()}


@weak_cache
def _sorted_points(skin: Skin) -> dict[str, LinkBroadphase]:
    links = [patch.link for patch in skin.patches if len(patch.taxels.quadrature.areas)]
    return {link: LinkBroadphase(skin, link) for link in dict.fromkeys(links)}
