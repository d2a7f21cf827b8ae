"""Human touch map: taxels are placed by correlation over recorded human touch.

After Noda, Miyashita, Ishiguro and Hagita (Robotics: Science and Systems 2008), whose robot with a soft skin is stroked
and patted by people: the cross-correlation of all pairs of sensors gives a somatosensory map by multidimensional
scaling. A stroke reaches a taxel's neighbour a moment later, so the highest correlation within a few readings is used,
simultaneous or with either one ahead. Scaled directly, all pairs beyond the reach of a contact would be equally
distant, so distances are completed along paths first.
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

_ROUNDING = 1e-12


def cross_correlation(first: csr_matrix, second: csr_matrix, *, lag: int = 0) -> FloatArray:
    """Return the Pearson correlation (n, n) of each column of ``first`` with each of ``second``, ``lag`` rows later.

    Means and deviations are those of all rows, so a lag only drops ``lag`` products. A constant column has correlation
    0.

    Args:
        first: Sparse (t, n).
        second: Sparse (t, n).
        lag: Rows, >= 0.
    """
    moments = first.shape[0]
    products = (first[: moments - lag].T @ second[lag:]).toarray() / max(moments - lag, 1)
    means, deviations = zip(*(_moments(values) for values in (first, second)), strict=True)
    covariance = products - np.outer(*means)
    scale = np.outer(*deviations)
    return np.divide(covariance, scale, out=np.zeros_like(covariance), where=scale > 0)


def _moments(values: csr_matrix) -> tuple[FloatArray, FloatArray]:
    mean = np.asarray(values.mean(axis=0)).ravel()
    variance = np.asarray(values.multiply(values).mean(axis=0)).ravel() - mean**2
    # The rounding error of a constant column is not a deviation.
    return mean, np.sqrt(np.where(variance > _ROUNDING * mean**2, variance, 0.0))


NAME = "human-touch"
LAGS = 2
"""Largest lag between two taxels, in readings."""


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress, lags: int = LAGS) -> LearnedMap:
    """Build a map, see ``Builder``; for strokes, evenly sampled in time. Deterministic.

    Args:
        readings: See ``Builder``.
        seed: See ``Builder``.
        progress: See ``Builder``.
        lags: Largest lag between two taxels, in readings, >= 0.
    """
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(dissimilarity(touch, lags=lags), progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def dissimilarity(touch: TouchReadings, *, lags: int) -> FloatArray:
    """Return the root (k, k) of 2 (1 - correlation), the distance of normalised signals; inf if unknown."""
    pressures = touch.pressures
    likeness = np.zeros((len(touch.taxels),) * 2)
    for lag in range(lags + 1):
        ahead = cross_correlation(pressures, pressures, lag=lag)
        likeness = np.maximum(likeness, np.maximum(ahead, ahead.T))
    unlike = np.sqrt(2 * np.maximum(1 - likeness, 0.0))
    # With 300 pokes some pairs coincide at a lag by pure chance.
    return np.where(touch.together, unlike, np.inf)
