"""Reachability of a point by a place of the skin, decided by a search of the whole range of the joints.

Boxes of postures are halved until none is left in which the place could reach the point with the required normal; this
is a proof that it cannot. Inverse kinematics starts from the remaining boxes.

The bound: let joints move one after the other from the base on, from a box's middle to any other posture in it. When
joint i turns, those after it are still as in the middle, so the place moves by at most the rotation times its distance
from that joint's axis in the middle; its normal turns by at most the rotation times the sine of its angle to the axis.
The sums bound the distance of place and normal from those at the middle, in the whole box.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np

from tactile_maps.control.path_following.inverse_kinematics import CLOSE, TILT, LinkPoint, PointTarget
from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration

MANY_BOXES = 3000
MOST_BOXES = 40_000
"""Number of boxes from which seeds are reported before reachability is decided, and at which the search ends."""
_FEW_BOXES = 1500
"""Largest number of boxes of the first search, which ignores the normal."""
_CHUNK = 250
"""Number of boxes evaluated in one round."""
_FINE = 0.06
"""Boxes in which place [m] and normal [rad] vary by less are used as seeds of inverse kinematics."""
_FINEST = 1e-3
"""Boxes below this size are not halved."""
_SEEDS = 12


@dataclass(frozen=True, eq=False)
class Reach:
    """Result of a search.

    Attributes:
        possible: False if the place can never reach the point; True if it may.
        short_by: Smallest distance from the point [m]; 0 if it gets there, but never with the normal.
        seeds: Postures (n,) near which it may get there.
    """

    possible: bool
    short_by: float
    seeds: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Boxes of postures, all of the same size.

    Attributes:
        middles: (m, k).
        half: (k,) half widths.
    """

    middles: FloatArray
    half: FloatArray

    def halved(self, joint: int) -> _Boxes:
        """Return each box halved along one joint."""
        shift = np.zeros_like(self.half)
        shift[joint] = self.half[joint] / 2
        return _Boxes(np.concatenate([self.middles - shift, self.middles + shift]), self.half - shift)


class ReachSearch:
    """Searches for postures, or for the proof that there are none, in rounds. Mutable.

    Args:
        configuration: Configuration of the robot; read only in the constructor, at any posture.
        spot: The place of the skin.
        goal: Target of the place.
        start: (n,) posture; joints that do not move the place keep its values.
        lower: (n,) lower limits of the joints.
        upper: (n,) upper limits of the joints.

    Attributes:
        found: None until there are seeds, or the proof that none exist; a proof may follow seeds.
        done: Whether the search is over.

    Cost: 1 ms a round; with two or three joints before the place 5 to 30 rounds, with five 100 to 800 for a proof.
    """

    def __init__(
        self,
        configuration: Configuration,
        spot: LinkPoint,
        goal: PointTarget,
        start: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
    ) -> None:
        configuration.update(start)
        anchors, axes, slides = configuration.joint_axes()
        pose = configuration.pose(spot.link)
        self._point = pose.points(spot.point)
        self._normal = pose.rotation @ spot.normal
        self._joints = configuration.joints_before(spot.link)
        self._anchors = anchors[self._joints]
        self._axes = axes[self._joints]
        self._slides = slides[self._joints]
        self._goal = goal
        self._start = start
        low = lower[self._joints]
        high = upper[self._joints]
        turns = ~self._slides & (high - low > 2 * np.pi)  # one turn is all there is
        here = start[self._joints]
        self._low = np.where(turns, np.maximum(low, np.minimum(here - np.pi, high - 2 * np.pi)), low)
        self._high = np.where(turns, self._low + 2 * np.pi, high)
        self.found: Reach | None = None
        self.done = False
        self._search = self._rounds()

    def look(self) -> None:
        """Search for one more round."""
        next(self._search, None)

    def _rounds(self) -> Iterator[None]:
        short_by = yield from self._short_by()
        if short_by is not None:
            self.found = Reach(False, short_by, ())
            self.done = True
            return
        boxes = self._whole_range()
        while True:
            boxes, order, spread, _ = yield from self._left(boxes, facing=True)
            if not len(boxes.middles):
                self.found = Reach(False, 0.0, ())
                self.done = True
                return
            count = 2 * len(boxes.middles)
            finest = spread.max(initial=0.0)
            self.done = count > MOST_BOXES or finest < _FINEST
            if self.found is None and (self.done or finest < _FINE or count > MANY_BOXES):
                seeds = tuple(self._whole(boxes.middles[k]) for k in _spread_out(boxes.middles, order))
                self.found = Reach(True, 0.0, seeds)
            if self.done:
                return
            boxes = boxes.halved(int(spread.argmax()))

    def _short_by(self) -> Generator[None, None, float | None]:
        """Return the smallest distance [m] if the place never gets there with any normal; None if it may."""
        boxes = self._whole_range()
        nearest = np.inf
        while len(boxes.middles) < _FEW_BOXES:
            boxes, _, spread, near = yield from self._left(boxes, facing=False)
            nearest = min(nearest, near)
            if not len(boxes.middles):
                return nearest
            if spread.max(initial=0.0) < _FINE:
                break
            boxes = boxes.halved(int(spread.argmax()))
        return None

    def _whole_range(self) -> _Boxes:
        return _Boxes(((self._low + self._high) / 2)[None], (self._high - self._low) / 2)

    def _left(
        self, boxes: _Boxes, *, facing: bool
    ) -> Generator[None, None, tuple[_Boxes, FloatArray, FloatArray, float]]:
        """Return boxes in which the place may reach the point, the quality of their middles (m,), the motion by each
        joint's half width (k,), and the smallest distance of excluded boxes [m].
        """
        kept = []
        order = []
        spread = np.zeros_like(boxes.half)
        nearest = np.inf
        for first in range(0, len(boxes.middles), _CHUNK):
            chunk = boxes.middles[first : first + _CHUNK]
            off, turned, reach, sines = self._at(chunk)
            least = off - reach @ boxes.half
            stay = least <= 2 * CLOSE
            nearest = min(nearest, float(least[~stay].min(initial=np.inf)))
            if facing:
                stay &= turned - sines @ boxes.half <= TILT
            kept.append(chunk[stay])
            order.append(off[stay] + 0.1 * turned[stay])
            spread = np.maximum(spread, (reach + 0.3 * sines).max(axis=0) * boxes.half)
            yield
        return _Boxes(np.concatenate(kept), boxes.half), np.concatenate(order), spread, nearest

    def _at(self, postures: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the errors of postures (m, k) and their sensitivity to the joints.

        Returns:
            Distance of the place [m] and angle of the normal from the target (m,), distances of the place from the axes
            (m, k) and sines of the normal's angles to them (m, k).
        """
        count, joints = postures.shape
        point = np.broadcast_to(self._point, (count, 3))
        normal = np.broadcast_to(self._normal, (count, 3))
        reach = np.ones((count, joints))
        sines = np.zeros((count, joints))
        moves = postures - self._start[self._joints]
        for joint in range(joints - 1, -1, -1):
            axis = self._axes[joint]
            if self._slides[joint]:
                point = point + moves[:, joint, None] * axis
                continue
            arm = point - self._anchors[joint]
            reach[:, joint] = np.linalg.norm(np.cross(arm, axis), axis=1)
            sines[:, joint] = np.linalg.norm(np.cross(normal, axis), axis=1)
            point = self._anchors[joint] + _turned(arm, axis, moves[:, joint])
            normal = _turned(normal, axis, moves[:, joint])
        off = np.linalg.norm(point - self._goal.point, axis=1)
        angle = np.arccos(np.clip(normal @ self._goal.normal, -1, 1))
        return off, angle, reach, sines

    def _whole(self, part: FloatArray) -> FloatArray:
        posture = self._start.copy()
        posture[self._joints] = part
        return posture


def _turned(arms: FloatArray, axis: FloatArray, angles: FloatArray) -> FloatArray:
    """Return vectors (m, 3) rotated about a unit axis (3,) by angles (m,) (Rodrigues)."""
    cos = np.cos(angles)[:, None]
    sin = np.sin(angles)[:, None]
    return arms * cos + np.cross(axis, arms) * sin + np.outer(arms @ axis, axis) * (1 - cos)


def _spread_out(middles: FloatArray, order: FloatArray) -> list[int]:
    """Return the best box, then those farthest from all chosen."""
    chosen = [int(order.argmin())]
    away = np.abs(middles - middles[chosen[0]]).max(axis=1)
    while len(chosen) < min(_SEEDS, len(middles)):
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.abs(middles - middles[chosen[-1]]).max(axis=1))
    return chosen
