"""Which points of a link's skin lie near a body, and how far from it: asked at every step, so it remembers where.

A signed distance changes no faster than its body moves. So once all points closer to the body than some cutoff are
found, all points closer than the cutoff less the body's way since then are still among them: nothing is searched again
until the body has moved by half a point's spacing. What is remembered never changes an answer.

``CellGrid`` sorts points into boxes, so that a body far from a box need not be asked about each point in it; a
``CachedNeighbourhood`` holds the points near a body where it was, and knows how long they stay all that matter;
``LinkBroadphase`` is both for one link.
"""

from __future__ import annotations

import math
from copy import copy
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.core.weak_cache import weak_cache
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
        order: (n,) the points, cube after cube; ``members`` are places in it.
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
        """(cells,) a distance [m] from the load's body that no point of the cell can be below."""
        return load.distances(self._centres) - self._radii

    def members(self, cells: IntArray) -> IntArray:
        """Places in ``order`` of the points in ``cells``, cell after cell."""
        counts = self._counts[cells]
        ends = np.cumsum(counts)
        return np.arange(counts.sum()) + np.repeat(self._starts[cells] - ends + counts, counts)


TILT = 0.05
"""A neighbourhood holds while the load's normal turns by less than this [rad]."""


class CachedNeighbourhood:
    """All points of a link that face a load and are closer to its body than a cutoff.

    Args:
        load: What presses, where it is now.
        facing: Cosine of a point's normal with the load's from which on the point faces it.
        points: (k,) numbers of the points.
        positions: (k, 3) [m], link frame, of all whose cosine is above ``facing`` less TILT.
        normals: (k, 3) outward.
        areas: (k,) [m²].
        cutoff: [m], no such point closer is missing.
        slack: Way of the body [m] after which the points should be looked for again.
        depth: How far above the closest point the load reached [m]; a hint for the next search.
        extent: No point of the link is farther from the load's point [m].
        bare: Whether some of the points are bare.
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
        bare: bool = False,
    ) -> None:
        self.points = points
        self.positions = positions
        self.areas = areas
        self.depth = depth
        self.shape = load.shape
        self.search_radius = cutoff
        self.guess = WarmStart()
        self.bare = bare
        self._facing = facing
        self._cutoff = cutoff
        self._slack = slack
        self._normal = load.normal.tolist()
        cosines = normals @ load.normal
        # Only points at the limb may come to face the load, or turn away, while the neighbourhood holds.
        self._doubtful = normals if len(normals) and (cosines <= facing + TILT).any() else None
        self._round = isinstance(load.shape, Sphere)
        self._pivot = load.point
        self._rotation = load.pose.rotation
        self._place = self._where(load)
        beyond = load.shape.reach + max(cutoff, 0.0) + float(np.linalg.norm(load.pose.translation - load.point))
        self._lever = min(beyond, extent)

    def holds(self, load: Load, facing: float) -> bool:
        """Whether the points are still those for ``load``; ``search_radius`` is then up to date."""
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
        """(k,) signed distance of the points from the load's body [m]; inf for those that do not face it."""
        offset = self.positions - load.pose.translation
        distances = load.shape.distance(offset if self._round else offset @ load.pose.rotation)
        if self._doubtful is not None:
            distances[self._doubtful @ load.normal <= self._facing] = math.inf
        return distances

    def _where(self, load: Load) -> list[float]:
        """The body's place [m]: its middle; for one that may turn, where the pivot lies in its own frame."""
        if self._round:
            return load.pose.translation.tolist()
        return ((self._pivot - load.pose.translation) @ load.pose.rotation).tolist()


FACING = 0.2
"""A point feels a load when its normal and the load's agree by more than this (a cosine)."""
_MISFIT = 0.01
"""Collision hulls stand off the skin by about this [m]: a body so far and three spacings off still touches."""
_EMPTY = 0.005
"""Nothing is searched again until a body has come closer by this [m]."""
_REMEMBERED = 32
_FIRST = 8
_DEEPEST = 0.02


class NearbyPoints(NamedTuple):
    """Points that face a load, and their distances from its body.

    Attributes:
        points: (k,) numbers through the skin, as in ``load_points``.
        positions: (k, 3) [m], link frame.
        areas: (k,) [m²].
        distances: (k,) signed distance from the body [m]; inf where the point does not face the load.
        search_radius: No facing point of the link that is closer to the body than this [m] is missing.
        guess: Which of these points bore the load the last time.
        bare: Whether some of the points are bare.
    """

    points: IntArray
    positions: FloatArray
    areas: FloatArray
    distances: FloatArray
    search_radius: float
    guess: WarmStart
    bare: bool


class LinkBroadphase:
    """The points of one link that bear load. What it remembers of earlier questions only saves time.

    Args:
        skin: The skin.
        link: One that has a patch.

    Attributes:
        points: (n,) the numbers of the link's points through the skin, as in ``load_points``; near ones together.
        read: Number of points that taxels read; higher numbers are bare points.
        spacing: Of the points that taxels read [m].
        beside: A body farther than this [m] from all points presses beside the skin.
    """

    def __init__(self, skin: Skin, link: str) -> None:
        everything = load_points(skin)
        own = points_of_link(skin, link)
        self.read = len(quadrature_points(skin).areas)
        self.spacing = float(np.sqrt(np.median(everything.areas[own[own < self.read]])))
        self._cells = CellGrid(everything.positions[own], 8 * self.spacing)
        self.points: IntArray = own[self._cells.order]
        self._positions = everything.positions[self.points]
        self._normals = everything.normals[self.points]
        self._areas = everything.areas[self.points]
        self._middle = self._positions.mean(axis=0)
        self._radius = float(np.linalg.norm(self._positions - self._middle, axis=1).max())
        self.beside = 3 * self.spacing + _MISFIT
        self._slack = min(max(0.5 * self.spacing, 1e-3), 3e-3)
        self._near: list[CachedNeighbourhood] = []

    def near(self, load: Load, *, upto: float | None = None, facing: float = FACING) -> NearbyPoints | None:
        """The points that face ``load`` and are closest to its body; None when it presses beside this skin.

        Args:
            load: On this link.
            upto: Distance from the body [m] up to which the points must be search_radius; by default the closest are
                there.
            facing: Cosine between a point's normal and the load's from which on the point faces it.

        Raises:
            SimulationError: The body is at no place that is a number.

        Cost: 5 µs for a ball and 100 points while the body moves less than half a spacing, else a search of 0.05 ms; a
        mesh takes 1 to 3 µs a point in both.
        """
        near = self._remembered(load, facing)
        if near is None or (upto is not None and near.search_radius < upto):
            near = self._search(load, facing, upto)
        if not near.points.size:
            return None
        distances = near.distances(load)
        if distances[distances.argmin()] > self.beside:
            return None
        return NearbyPoints(
            near.points, near.positions, near.areas, distances, near.search_radius, near.guess, near.bare
        )

    def nearest(self, load: Load) -> int | None:
        """Number through the skin of the point closest to a body that no point faces; None when it presses beside.

        Points that look away from the load are on the other side of the link and never feel it.
        """
        found = self.near(load, facing=-FACING)
        return None if found is None else int(found.points[found.distances.argmin()])

    def forget(self) -> LinkBroadphase:
        """Remember nothing of earlier questions, like a new one; returns itself."""
        self._near = []
        return self

    def _remembered(self, load: Load, facing: float) -> CachedNeighbourhood | None:
        for near in reversed(self._near):
            if near.holds(load, facing):
                return near
        return None

    def _search(self, load: Load, facing: float, upto: float | None) -> CachedNeighbourhood:
        """Find the points anew, and remember them instead of what held here."""
        if not np.isfinite(load.pose.translation).all():
            raise SimulationError(
                "the pose of a body is not finite", place=f"on {load.link}", value=load.pose.translation.tolist()
            )
        hint = next((near.depth for near in reversed(self._near) if near.shape == load.shape), 0.0)
        seen = facing - TILT
        lowest = self._cells.lowest(load)
        limit = self.beside + _EMPTY
        least, _, _ = self._closer(load, seen, np.argsort(lowest)[:_FIRST])
        cutoff = self._cutoff(min(least, limit), hint, upto)
        least, here, distances = self._closer(load, seen, np.flatnonzero(lowest <= cutoff))
        if least > limit:  # an empty neighbourhood holds until the body may have come close enough to press
            cutoff = limit
            here = here[:0]
        else:
            cutoff = self._cutoff(least, hint, upto)
            here = here[distances <= cutoff]
        near = CachedNeighbourhood(
            load, facing, self.points[here], self._positions[here], self._normals[here], self._areas[here],
            cutoff=cutoff, slack=self._slack, depth=hint if upto is None else min(max(upto - least, 0.0), _DEEPEST),
            extent=math.dist(load.point, self._middle) + self._radius,
            bare=bool((self.points[here] >= self.read).any()),
        )  # fmt: skip
        self._near = [old for old in self._near if not old.holds(load, facing)][1 - _REMEMBERED :] + [near]
        return near

    def _cutoff(self, least: float, depth: float, upto: float | None) -> float:
        """Points up to here [m] last until the body has moved by the slack, which lifts the level by as much."""
        level = least + depth if upto is None else max(least, upto)
        return level + 2 * self._slack

    def _closer(self, load: Load, seen: float, cells: IntArray) -> tuple[float, IntArray, FloatArray]:
        """The points of ``cells`` whose cosine with the load is above ``seen``: smallest distance, which, distances."""
        here = self._cells.members(cells)
        here = here[self._normals[here] @ load.normal > seen]
        distances = load.distances(self._positions[here]) if here.size else np.zeros(0)
        return float(distances.min(initial=math.inf)), here, distances


def link_broadphases(skin: Skin) -> dict[str, LinkBroadphase]:
    """A bed for each link that has points, with nothing to remember yet. The sorted points are kept with the skin."""
    return {link: copy(bed).forget() for link, bed in _sorted_points(skin).items()}


@weak_cache
def _sorted_points(skin: Skin) -> dict[str, LinkBroadphase]:
    links = [patch.link for patch in skin.patches if len(patch.taxels.quadrature.areas)]
    return {link: LinkBroadphase(skin, link) for link in dict.fromkeys(links)}
