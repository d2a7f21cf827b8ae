"""What every builder gives: a place in the plane for each taxel, and what it was worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, freeze_arrays
from tactile_maps.core.errors import Finding, MapError
from tactile_maps.core.progress import Progress, no_progress


@dataclass(frozen=True, eq=False)
class LearnedMap:
    """Taxels in the plane.

    A taxel that felt nothing cannot be placed by touch. It is not invented a place: ``placed`` is False, its point is
    the middle of all others (a number must stand there), and a finding names it.

    Attributes:
        points: (n, 2) in a unit of the builder's own; turned and mirrored as it happens, for touch cannot tell.
        placed: (n,) whether touch said where the taxel lies.
        method: Which builder.
        seconds: Wall time.
        stress: Kruskal's stress-1 of the points against the distances they were made from, at the best scale; None
            for a method without distances, and where all points are one.
        findings: What was noticed.
    """

    points: FloatArray
    placed: BoolArray
    method: str
    seconds: float
    stress: float | None
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, "points", columns=2)
        freeze_arrays(self, "placed", dtype=bool)
        if len(self.points) != len(self.placed) or not np.isfinite(self.points).all():
            raise MapError("a learned map needs a finite place for each taxel", value=self.points.shape)


class Builder(Protocol):
    """One way to learn a map."""

    def __call__(self, readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress) -> LearnedMap:
        """Learn a map.

        Args:
            readings: (t, n) pressures [Pa] in the order of time, zero at rest but for noise.
            seed: Of all chance in it; a method without chance gives the same map for every seed.
            progress: Told what is being done and how far it is, 0 to 1; may raise to cancel.

        Raises:
            MapError: The readings are no such numbers, or fewer than three taxels felt anything.
        """
