"""Mean of the loads of several steps, so that a reading includes all contacts since the previous one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.tactile.mechanics.loads import NO_SHEAR, Load

ONE_LOAD = 0.5
"""Cosine between the normals of two contacts of one body above which they are one load."""


@dataclass(eq=False)
class _Sum:
    """Strongest load of a body on one wall of a link, and sums of forces, torques, force times point and normal."""

    strongest: Load
    force: float
    moment: FloatArray
    direction: FloatArray
    shear: FloatArray
    torque: float


class MeanLoads:
    """Mean of the loads over the steps of one tick. Mutable.

    The mean load of a body on a link has the mean force, so that force times duration is the impulse, and the mean
    shear and torque. It acts at the force-weighted mean point. The pose of the body is that of the largest force:
    within a tick it hardly moves. A body that presses two walls has a mean load on each.
    """

    def __init__(self) -> None:
        self.begin()

    @property
    def steps(self) -> int:
        """Number of added steps."""
        return self._steps

    def begin(self) -> None:
        """Clear all steps."""
        self._steps = 0
        self._sums: dict[tuple[str, str, int], list[_Sum]] = {}

    def add(self, loads: Iterable[Load]) -> None:
        """Add one step with its loads, possibly empty. Cost: 5 us a load."""
        self._steps += 1
        for load in loads:
            key = load.link, load.by, id(load.shape)
            walls = self._sums.setdefault(key, [])
            found = next((wall for wall in walls if load.normal @ wall.strongest.normal > ONE_LOAD), None)
            if found is None:
                moment = load.force * load.point
                walls.append(_Sum(load, load.force, moment, load.force * load.normal, load.shear, load.torque))
                continue
            found.force += load.force
            found.moment += load.force * load.point
            found.direction += load.force * load.normal
            found.shear = found.shear + load.shear
            found.torque += load.torque
            if load.force > found.strongest.force:
                found.strongest = load

    def loads(self) -> list[Load]:
        """Return the mean loads; none without a step."""
        return [self._mean(found) for walls in self._sums.values() for found in walls if found.force > 0]

    def _mean(self, found: _Sum) -> Load:
        normal = found.direction / np.linalg.norm(found.direction)
        shear = found.shear / self._steps
        return replace(
            found.strongest,
            point=found.moment / found.force,
            normal=normal,
            force=found.force / self._steps,
            shear=shear - (shear @ normal) * normal if shear.any() else NO_SHEAR,
            torque=found.torque / self._steps,
        )
