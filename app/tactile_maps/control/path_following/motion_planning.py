"""Collision-free paths of the arm between postures: straight ones, and sampled ones around obstacles.

``straight`` checks the straight line of the joints. If that is not clear, ``RrtConnect`` grows two trees towards each
other (Kuffner and LaValle, RRT-Connect: an efficient approach to single-query path planning, 2000), and shortcuts
straighten the result. All random numbers are seeded and counted: the same problem has the same solution.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Sequence

import numpy as np

from tactile_maps.control.path_following.clearance import Clearance
from tactile_maps.core.arrays import FloatArray

SAMPLES = 600
"""Largest number of random postures."""
SHORTCUTS = 40
"""Number of shortcuts tried on a path."""
_STEP = 0.35
"""Largest step of any joint in a tree [rad]."""
_AROUND = 0.8
"""Half of the samples are at most this far beyond the two ends [rad]."""

Pair = tuple[str, str]
Steps = Generator[int, None, bool]


def straight(clearance: Clearance, start: FloatArray, end: FloatArray, met: Counter[Pair]) -> Steps:
    """Return whether the straight line of the joints is clear; yields the cost of each posture checked.

    Args:
        clearance: Clearance to be kept.
        start: (n,) posture.
        end: (n,) posture.
        met: Counts the pairs that collide.
    """
    for gap in clearance.along(start, end):
        if gap.room < 0:
            met[gap.between] += 1
            return False
        yield clearance.cost
    return True


class RrtConnect:
    """Search for a path. Mutable.

    Args:
        clearance: Clearance to be kept.
        start: (n,) clear posture.
        goals: (n,) clear postures, any of which is a goal.
        lower: (n,) lower limits of the joints.
        upper: (n,) upper limits of the joints.
        met: Counts the pairs that collide.
    """

    def __init__(
        self,
        clearance: Clearance,
        start: FloatArray,
        goals: Sequence[FloatArray],
        lower: FloatArray,
        upper: FloatArray,
        met: Counter[Pair],
    ) -> None:
        self._clearance = clearance
        self._met = met
        self._lot = np.random.default_rng(0)
        self._trees = (_Tree([start]), _Tree(goals))
        ends = np.array([start, *goals])
        low = ends.min(axis=0)
        high = ends.max(axis=0)
        self._low = np.maximum(lower, low - np.pi)
        self._high = np.minimum(upper, high + np.pi)
        self._near = np.maximum(lower, low - _AROUND), np.minimum(upper, high + _AROUND)

    def search(self) -> Generator[int, None, list[FloatArray] | None]:
        """Return the postures (n,) from the start to a goal, both included; None if no path was found."""
        one, other = self._trees
        for number in range(SAMPLES):
            low, high = self._near if number % 2 else (self._low, self._high)
            drawn = self._lot.uniform(low, high)
            node = yield from self._grow(one, drawn, once=True)
            if node is not None:
                met = yield from self._grow(other, one.postures[node], once=False)
                if met is not None and np.array_equal(other.postures[met], one.postures[node]):
                    way = [*one.to_root(node)[::-1], *other.to_root(met)[1:]]
                    if one is not self._trees[0]:
                        way = way[::-1]
                    return (yield from self._shortened(way))
            one, other = other, one
        return None

    def _grow(self, tree: _Tree, towards: FloatArray, *, once: bool) -> Generator[int, None, int | None]:
        """Grow from the nearest node by one step, or as far as the way is clear; return the last node added."""
        node = tree.nearest(towards)
        added = None
        while True:
            here = tree.postures[node]
            off = towards - here
            far = float(np.abs(off).max())
            if far < 1e-12:
                return node
            arrives = far <= _STEP
            posture = towards if arrives else here + off * (_STEP / far)
            if not (yield from straight(self._clearance, here, posture, self._met)):
                return added
            node = added = tree.add(posture, node)
            if once or arrives:
                return added

    def _shortened(self, way: list[FloatArray]) -> Generator[int, None, list[FloatArray]]:
        ignored: Counter[Pair] = Counter()
        for _ in range(SHORTCUTS):
            if len(way) < 3:
                break
            i, j = sorted(int(k) for k in self._lot.integers(0, len(way), 2))
            if j - i > 1 and (yield from straight(self._clearance, way[i], way[j], ignored)):
                way = [*way[: i + 1], *way[j:]]
        return way


class _Tree:
    """Postures, each reached from an earlier one. Mutable."""

    def __init__(self, roots: Sequence[FloatArray]) -> None:
        self.postures: list[FloatArray] = list(roots)
        self._parents = [-1] * len(self.postures)

    def nearest(self, posture: FloatArray) -> int:
        return int(np.linalg.norm(np.array(self.postures) - posture, axis=1).argmin())

    def add(self, posture: FloatArray, parent: int) -> int:
        self.postures.append(posture)
        self._parents.append(parent)
        return len(self.postures) - 1

    def to_root(self, node: int) -> list[FloatArray]:
        found = []
        while node >= 0:
            found.append(self.postures[node])
            node = self._parents[node]
        return found
