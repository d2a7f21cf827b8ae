"""Temporal correlation map: taxels that are touched shortly after each other are placed close together.

After Kuniyoshi and colleagues, whose simulated infants develop body maps from such coincidences. Each taxel leaves a
trace that fades, z <- (1 - 1/T) z + y; activity during a trace is coupled to it, c_ij <- c_ij + r (y_i z_j - c_ij).
Over a recording with a small rate r this is the mean of y_i z_j, which is computed here at once. For blurred contacts
the coupling decreases with distance like a Gaussian, so the root of minus its logarithm is used as the distance.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.sparse import csr_matrix

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.maps.learned.embedding import embed
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.learned.readings import TouchReadings, detect_touch

NAME = "temporal-correlation"
FADING = 3.0
"""Number of readings in which a trace fades to 1/e."""
_FORGOTTEN = 1e-3


def build(
    readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress, fading: float = FADING
) -> LearnedMap:
    """Build a map, see ``Builder``; readings must be evenly spaced in time. Deterministic.

    Args:
        readings: See ``Builder``.
        seed: See ``Builder``.
        progress: See ``Builder``.
        fading: Number of readings in which a trace fades to 1/e, >= 1; 1 is no memory.
    """
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(dissimilarity(touch, fading=fading), progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def dissimilarity(touch: TouchReadings, *, fading: float) -> FloatArray:
    """Return the root (k, k) of minus the logarithm of the normalised coupling; inf without coupling."""
    pressures = touch.pressures
    coupling = (pressures.T @ traces(pressures, fading=fading)).toarray()
    coupling = 0.5 * (coupling + coupling.T)
    own = np.sqrt(coupling.diagonal())
    likeness = np.minimum(coupling / np.outer(own, own), 1.0)
    with np.errstate(divide="ignore"):
        return np.sqrt(-np.log(likeness))


def traces(pressures: csr_matrix, *, fading: float) -> csr_matrix:
    """Return sparse traces (t, k) of each taxel's readings, cut off at a thousandth of their peak."""
    from scipy.signal import lfilter  # with scipy.stats 0.3 s to import, and few learn a map

    left = np.exp(-1.0 / fading) if fading > 1 else 0.0
    trace = lfilter([1.0], [1.0, -left], pressures.toarray(), axis=0)
    return csr_matrix(np.where(trace > _FORGOTTEN * trace.max(axis=0), trace, 0.0))
