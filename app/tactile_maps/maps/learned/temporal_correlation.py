"""Taxels placed by coincidence in time: those that feel the same shortly after each other lie near each other.

After Kuniyoshi and colleagues, whose simulated infants grow body maps from such coincidences. Each taxel leaves a trace
that fades, z <- (1 - 1/T) z + y; what fires while a trace lasts is coupled to it, c_ij <- c_ij + r (y_i z_j - c_ij).
Over a recording with a slow rate r that is the mean of y_i z_j, which is computed here at once. For blurred contacts
the coupling falls with distance like a Gaussian, so the root of minus its logarithm is taken for the distance.
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
"""Readings in which a trace fades to a third."""
_FORGOTTEN = 1e-3


def build(
    readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress, fading: float = FADING
) -> LearnedMap:
    """See ``Builder``; readings must be evenly spaced in time. There is no chance in it.

    Args:
        readings: As in ``Builder``.
        seed: As in ``Builder``.
        progress: As in ``Builder``.
        fading: Readings in which a trace falls to 1/e, >= 1; 1 is no memory.
    """
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(dissimilarity(touch, fading=fading), progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def dissimilarity(touch: TouchReadings, *, fading: float) -> FloatArray:
    """(k, k) root of minus the logarithm of the coupling, normed to 1 with oneself; inf where there is none."""
    pressures = touch.pressures
    coupling = (pressures.T @ traces(pressures, fading=fading)).toarray()
    coupling = 0.5 * (coupling + coupling.T)
    own = np.sqrt(coupling.diagonal())
    likeness = np.minimum(coupling / np.outer(own, own), 1.0)
    with np.errstate(divide="ignore"):
        return np.sqrt(-np.log(likeness))


def traces(pressures: csr_matrix, *, fading: float) -> csr_matrix:
    """Sparse (t, k): what is left of each taxel's readings; what has faded to a thousandth of its peak is forgotten."""
    from scipy.signal import lfilter  # with scipy.stats 0.3 s to import, and few learn a map

    left = np.exp(-1.0 / fading) if fading > 1 else 0.0
    trace = lfilter([1.0], [1.0, -left], pressures.toarray(), axis=0)
    return csr_matrix(np.where(trace > _FORGOTTEN * trace.max(axis=0), trace, 0.0))
