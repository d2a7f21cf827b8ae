"""Loads of several steps as their mean, so that a reading counts all that happened since the one before."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.tactile.mechanics.loads import Load

ONE_LOAD = 0.5
"""Cosine between the normals of one body's contacts from which on they are one load."""


@dataclass(eq=False)
class _Sum:
    """One body's loads on one wall of a link: the strongest, and the sums of force, force times point or normal."""

    strongest: Load
    force: float
    moment: FloatArray
    direction: FloatArray


class MeanLoads:
    """Adds up the loads of the steps of one tick. Mutable.

    The mean load of a body on a link has the mean force, so that force times duration is the impulse. It acts at the
    mean point by force, and the body is where it pressed hardest: within a tick it hardly moves. A body that presses
    two walls has a mean load on each.
    """

    def __init__(self) -> None:
        self.begin()

    @property
    def steps(self) -> int:
        """How many were added."""
        return self._steps

    def begin(self) -> None:
        """Forget all steps."""
        self._steps = 0
        self._sums: dict[tuple[str, str, int], list[_Sum]] = {}

    def add(self, loads: Iterable[Load]) -> None:
        """Count one step with these loads, which may be none. Cost: 5 us a load."""
        self._steps += 1
        for load in loads:
            key = load.link, load.by, id(load.shape)
            walls = self._sums.setdefault(key, [])
            found = next((wall for wall in walls if load.normal @ wall.strongest.normal > ONE_LOAD), None)
            if found is None:
                walls.append(_Sum(load, load.force, load.force * load.point, load.force * load.normal))
                continue
            found.force += load.force
            found.moment += load.force * load.point
            found.direction += load.force * load.normal
            if load.force > found.strongest.force:
                found.strongest = load

    def loads(self) -> list[Load]:
        """Return the mean loads; none without a step."""
        return [
            replace(
                found.strongest,
                point=found.moment / found.force,
                normal=found.direction / np.linalg.norm(found.direction),
                force=found.force / self._steps,
            )
            for walls in self._sums.values()
            for found in walls
            if found.force > 0
        ]
