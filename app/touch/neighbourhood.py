"""The points near a body where it was, and how long they stay all that matter."""

from __future__ import annotations

import math

import numpy as np

from app.arrays import FloatArray, IntArray
from app.touch.fill import Guess
from app.touch.load import Load
from app.touch.shapes import Ball

TILT = 0.05
"""A neighbourhood holds while the load's normal turns by less than this [rad]."""


class Neighbourhood:
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
        self.points, self.positions, self.areas, self.depth = points, positions, areas, depth
        self.shape, self.complete, self.guess = load.shape, cutoff, Guess()
        self._facing, self._cutoff, self._slack = facing, cutoff, slack
        self._normal = load.normal.tolist()
        cosines = normals @ load.normal
        # Only points at the limb may come to face the load, or turn away, while the neighbourhood holds.
        self._doubtful = normals if len(normals) and (cosines <= facing + TILT).any() else None
        self._round = isinstance(load.shape, Ball)
        self._pivot, self._rotation = load.point, load.pose.rotation
        self._place = self._where(load)
        beyond = load.shape.reach + max(cutoff, 0.0) + float(np.linalg.norm(load.pose.translation - load.point))
        self._lever = min(beyond, extent)

    def holds(self, load: Load, facing: float) -> bool:
        """Whether the points are still those for ``load``; ``complete`` is then up to date."""
        if not (self.shape is load.shape or self.shape == load.shape) or facing != self._facing:
            return False
        if math.dist(load.normal.tolist(), self._normal) > TILT:
            return False
        moved = math.dist(self._where(load), self._place)
        if not self._round and moved <= self._slack:
            moved += self._lever * math.dist(load.pose.rotation.ravel().tolist(), self._rotation.ravel().tolist())
        self.complete = self._cutoff - moved
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
