"""Taxels placed by correlation over recorded human touch.

After Noda, Miyashita, Ishiguro and Hagita (Robotics: Science and Systems 2008), whose robot with a soft skin is stroked
and patted by people: the cross-correlation of all pairs of sensors gives a somatosensory map by multidimensional
scaling. A stroke reaches a taxel's neighbour a moment later, so the highest correlation within a few readings counts,
at once or with one ahead of the other. Scaled directly, all pairs beyond a contact's reach would be equally far; so
distances are completed along paths first.
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
    """(n, n) Pearson correlation of each column of ``first`` with each of ``second``, ``lag`` rows later.

    Means and deviations are those of all rows, so a lag loses nothing but its ``lag`` products. A column that never
    changes correlates with nothing: 0.

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
    # What rounding leaves of a column that never changes is no deviation.
    return mean, np.sqrt(np.where(variance > _ROUNDING * mean**2, variance, 0.0))


NAME = "human-touch"
LAGS = 2
"""Readings by which one taxel may be ahead of another."""


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress, lags: int = LAGS) -> LearnedMap:
    """See ``Builder``; made for strokes, evenly sampled in time. There is no chance in it.

    Args:
        readings: As in ``Builder``.
        seed: As in ``Builder``.
        progress: As in ``Builder``.
        lags: Readings by which one taxel may be ahead of another, >= 0.
    """
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(dissimilarity(touch, lags=lags), progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def dissimilarity(touch: TouchReadings, *, lags: int) -> FloatArray:
    """(k, k) root of 2 (1 - correlation), the distance of normed signals; inf for pairs never touched together."""
    pressures = touch.pressures
    likeness = np.zeros((len(touch.taxels),) * 2)
    for lag in range(lags + 1):
        ahead = cross_correlation(pressures, pressures, lag=lag)
        likeness = np.maximum(likeness, np.maximum(ahead, ahead.T))
    unlike = np.sqrt(2 * np.maximum(1 - likeness, 0.0))
    # Of 300 pokes some pairs coincide with a lag by chance and on no other ground.
    return np.where(touch.together, unlike, np.inf)
