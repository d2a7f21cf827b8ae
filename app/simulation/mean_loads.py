"""Loads of several steps as their mean, so that a reading counts all that happened since the one before."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from app.core.arrays import FloatArray
from app.tactile.loads import Load


@dataclass(eq=False)
class _Sum:
    """Of one body's loads on one link: the strongest, and the sums of force, force times point, force times normal."""

    strongest: Load
    force: float
    moment: FloatArray
    direction: FloatArray


class MeanLoads:
    """Adds up the loads of the steps of one tick. Mutable.

    The mean load of a body on a link has the mean force, so that force times duration is the impulse. It acts at the
    mean point by force, and the body is where it pressed hardest: within a tick it hardly moves.
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
        self._sums: dict[tuple[str, str, int], _Sum] = {}

    def add(self, loads: Iterable[Load]) -> None:
        """Count one step with these loads, which may be none. Cost: 5 us a load."""
        self._steps += 1
        for load in loads:
            key = load.link, load.by, id(load.shape)
            found = self._sums.get(key)
            if found is None:
                self._sums[key] = _Sum(load, load.force, load.force * load.point, load.force * load.normal)
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
            for found in self._sums.values()
            if found.force > 0
        ]
