"""Results of the flattening benchmark: a table, and one line for each peer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

NEAR_THE_BEST = 1.01
"""A method is timed until its energy is within this factor of the lowest that any method reached."""


@dataclass(frozen=True, eq=False)
class Run:
    """Result of one method on one disk: time and energy after each round, flips and overlaps."""

    method: str
    seconds: tuple[float, ...]
    energies: tuple[float, ...]
    flips: int
    overlaps: int
    charts: int = 1

    @property
    def best(self) -> float:
        return min(self.energies)

    def seconds_to(self, energy: float) -> float:
        """Return the time until an energy was reached [s]; nan if never."""
        reached = [s for s, e in zip(self.seconds, self.energies, strict=True) if e <= energy]
        return reached[0] if reached else float("nan")


FLATTENING = pytest.StashKey[list[tuple[str, str, int, list[Run]]]]()


def write(rows: list[tuple[str, str, int, list[Run]]], line: Callable[[str], None]) -> None:
    """Write one line for each mesh and method, then the median ratio of times."""
    line(
        f"{'mesh':<24}{'faces':>8}  {'method':<22}{'energy':>10}{'over best':>10}{'ms to 1 %':>11}{'ms':>9}  one-to-one"
    )
    ratios: dict[tuple[str, bool], list[float]] = {}
    for name, _, faces, runs in rows:
        best = min(run.best for run in runs if run.charts == 1)
        goal = NEAR_THE_BEST * best
        for run in runs:
            good = "yes" if run.flips == run.overlaps == 0 else f"{run.flips} flips, {run.overlaps} crossings"
            good += f", {run.charts} charts" if run.charts > 1 else ""
            line(
                f"{name:<24}{faces:>8}  {run.method:<22}{run.best:>10.4f}{100 * (run.best / best - 1):>9.2f}%"
                f"{1e3 * run.seconds_to(goal):>11.0f}{1e3 * run.seconds[-1]:>9.0f}  {good}"
            )
            if run.charts == 1 and run is not runs[0]:
                ratios.setdefault((run.method, faces > 50_000), []).append(
                    run.seconds_to(goal) / runs[0].seconds_to(goal)
                )
    for (method, large), values in ratios.items():
        known = [value for value in values if np.isfinite(value)]
        if known:
            size = "large meshes" if large else "the others"
            line(
                f"ours against {method}, {size}: {np.median(known):.1f} times faster in the median "
                f"({min(known):.1f} to {max(known):.1f}; {len(values) - len(known)} of {len(values)} never got there)"
            )
