"""Taxels placed by correlation over recorded human touch.

After Noda, Miyashita, Ishiguro and Hagita (Robotics: Science and Systems 2008), whose robot with a soft skin is stroked
and patted by people: the cross-correlation of all pairs of sensors gives a somatosensory map by multidimensional
scaling. A stroke reaches a taxel's neighbour a moment later, so the highest correlation within a few readings counts.
Scaled directly, all pairs beyond a contact's reach would be equally far; so distances are completed along paths first.
"""

from __future__ import annotations

import time

import numpy as np

from app.arrays import FloatArray
from app.maps.learned.correlation import cross_correlation
from app.maps.learned.learned_map import LearnedMap, Progress, silent
from app.maps.learned.placing import place
from app.maps.learned.readings import Felt, felt

NAME = "human-touch"
LAGS = 2
"""Readings by which one taxel may be ahead of another."""


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = silent, lags: int = LAGS) -> LearnedMap:
    """See ``Builder``; made for strokes, evenly sampled in time. There is no chance in it.

    Args:
        readings: As in ``Builder``.
        seed: As in ``Builder``.
        progress: As in ``Builder``.
        lags: Readings by which one taxel may be ahead of another, >= 0.
    """
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = felt(readings)
    placed = place(unlikeness(touch, lags=lags), progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def unlikeness(touch: Felt, *, lags: int) -> FloatArray:
    """(k, k) root of 2 (1 - correlation), the distance of normed signals; inf for pairs never touched together."""
    pressures = touch.pressures
    likeness = np.zeros((len(touch.taxels),) * 2)
    for lag in range(lags + 1):
        ahead = cross_correlation(pressures, pressures, lag=lag)
        likeness = np.maximum(likeness, np.maximum(ahead, ahead.T))
    unlike = np.sqrt(2 * np.maximum(1 - likeness, 0.0))
    # Of 300 pokes some pairs coincide with a lag by chance and on no other ground.
    return np.where(touch.together, unlike, np.inf)
