"""Readings made fit to learn from: noise told from touch, taxels that felt nothing named."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import Finding, MapError

_SIGMAS = 5.0
"""Touch begins so many standard deviations above rest: noise alone gets there 3 times in ten million readings."""
_NAMED = 12


@dataclass(frozen=True, eq=False)
class TouchReadings:
    """What was felt.

    Attributes:
        pressures: Sparse (t, k) [Pa]: readings that are touch, of the taxels that felt any.
        taxels: (k,) which taxels they are.
        count: How many taxels there are in all.
        findings: Names those that felt nothing.
    """

    pressures: csr_matrix
    taxels: IntArray
    count: int
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxels", dtype=np.int64)

    @property
    def together(self) -> BoolArray:
        """(k, k) whether two taxels are touched at the same time more often than by chance.

        Only of such pairs can nearness be learned: two that keep out of each other's way, as the ends of a small sheet
        under a large finger do, tell much of each other and are far.
        """
        touched = (self.pressures > 0).astype(np.float64)
        alone = np.asarray(touched.sum(axis=0)).ravel()
        return (touched.T @ touched).toarray() * touched.shape[0] > np.outer(alone, alone)

    def everywhere(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Points (n, 2) of all taxels from those (k, 2) of the felt, the others in the middle; and which are placed."""
        full = np.tile(points.mean(axis=0), (self.count, 1))
        placed = np.zeros(self.count, dtype=bool)
        full[self.taxels] = points
        placed[self.taxels] = True
        return full, placed


def detect_touch(readings: FloatArray) -> TouchReadings:
    """Tell touch from rest.

    Pressure is never negative, so what lies below zero is noise alone; its mean square is the noise's. This holds
    however often a taxel is touched, which a median does not.

    Args:
        readings: (t, n) [Pa].

    Raises:
        MapError: Not such an array, not finite, or fewer than three taxels felt anything.
    """
    values = np.asarray(readings, dtype=np.float64)
    if values.ndim != 2 or not np.isfinite(values).all():
        raise MapError("readings must be a table of finite numbers, one row a moment", value=values.shape)
    below = values[values < 0]
    threshold = _SIGMAS * float(np.sqrt(np.mean(below**2))) if below.size else 0.0
    touch = np.where(values > threshold, values, 0.0)
    # A reading that exceeds the noise once in the whole recording is what noise does; more than once it does not.
    alive = (touch > 0).sum(axis=0) > (1 if threshold else 0)
    taxels = np.flatnonzero(alive)
    if len(taxels) < 3:
        raise MapError(
            "too few taxels were touched to learn a map from",
            value=f"{len(taxels)} of {values.shape[1]}",
            remedy="Record more touches, all over the skin",
        )
    return TouchReadings(csr_matrix(touch[:, taxels]), taxels, values.shape[1], _findings(np.flatnonzero(~alive)))


def _findings(dead: IntArray) -> tuple[Finding, ...]:
    if not dead.size:
        return ()
    names = ", ".join(str(number) for number in dead[:_NAMED]) + (", ..." if dead.size > _NAMED else "")
    action = "never in contact, so their positions are unknown; placed at the centre of the map"
    return (Finding("taxels-never-touched", f"taxels {names}", action, int(dead.size)),)
