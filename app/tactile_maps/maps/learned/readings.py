"""Preparation of readings for learning: noise is separated from touch, and taxels never touched are reported."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, MapError

_SIGMAS = 5.0
"""Threshold of touch in standard deviations above rest: noise exceeds it 3 times in ten million readings."""
_NAMED = 12


@dataclass(frozen=True, eq=False)
class TouchReadings(ArrayFields):
    """Readings of touched taxels.

    Attributes:
        pressures: Sparse (t, k) [Pa]: readings above the noise, of taxels that were touched.
        taxels: (k,) numbers of these taxels.
        count: Number of all taxels.
        findings: Names taxels that were never touched.
    """

    pressures: csr_matrix
    taxels: IntArray
    count: int
    findings: tuple[Finding, ...]

    @property
    def together(self) -> BoolArray:
        """(k, k) whether two taxels are touched at the same time more often than by chance.

        Proximity can be learned only for such pairs. Two taxels that are never touched together, like the ends of a
        small sheet under a large finger, have much mutual information and are distant.
        """
        touched = (self.pressures > 0).astype(np.float64)
        alone = np.asarray(touched.sum(axis=0)).ravel()
        return (touched.T @ touched).toarray() * touched.shape[0] > np.outer(alone, alone)

    def everywhere(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return points (n, 2) of all taxels from those (k, 2) of touched ones, others at the mean, and a mask (n,)."""
        full = np.tile(points.mean(axis=0), (self.count, 1))
        placed = np.zeros(self.count, dtype=bool)
        full[self.taxels] = points
        placed[self.taxels] = True
        return full, placed


def detect_touch(readings: FloatArray) -> TouchReadings:
    """Separate touch from rest.

    Pressure is never negative, so readings below zero are noise, and their mean square is that of the noise. Unlike a
    median, this holds however often a taxel is touched.

    Args:
        readings: (t, n) [Pa].

    Raises:
        MapError: The readings are not a finite table, or fewer than three taxels were touched.
    """
    values = np.asarray(readings, dtype=np.float64)
    if values.ndim != 2 or not np.isfinite(values).all():
        raise MapError("readings must be a table of finite numbers with one row per time", value=values.shape)
    below = values[values < 0]
    threshold = _SIGMAS * float(np.sqrt(np.mean(below**2))) if below.size else 0.0
    touch = np.where(values > threshold, values, 0.0)
    # Noise can exceed the threshold once in a recording, but hardly more than once.
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
