"""Result of all builders: a position in the plane for each taxel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray
from tactile_maps.core.errors import Finding, MapError
from tactile_maps.core.progress import Progress, no_progress


@dataclass(frozen=True, eq=False)
class LearnedMap(ArrayFields, points=2):
    """Taxel positions in the plane.

    A taxel that was never touched has no learned position: ``placed`` is False, its point is the mean of all others as
    a placeholder, and a finding names it.

    Attributes:
        points: (n, 2) in a unit of the builder; rotation and mirroring are arbitrary, since touch does not determine
            them.
        placed: (n,) whether the position of the taxel was learned.
        method: Name of the builder.
        seconds: Wall time.
        stress: Kruskal's stress-1 of the points against their target distances, at the best scale; None for a method
            without distances, and if all points coincide.
        findings: Anything unusual.
    """

    points: FloatArray
    placed: BoolArray
    method: str
    seconds: float
    stress: float | None
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.points) != len(self.placed) or not np.isfinite(self.points).all():
            raise MapError("a learned map needs a finite position for each taxel", value=self.points.shape)


class Builder(Protocol):
    """A method of learning a map."""

    def __call__(self, readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress) -> LearnedMap:
        """Learn a map.

        Args:
            readings: (t, n) pressures [Pa] in temporal order, zero at rest except for noise.
            seed: Random seed; deterministic methods ignore it.
            progress: Receives the current step and the fraction done; may raise to cancel.

        Raises:
            MapError: The readings are not such numbers, or fewer than three taxels were touched.
        """
