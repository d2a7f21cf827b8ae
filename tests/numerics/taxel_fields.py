"""Taxels of one patch at known places, and points among them, for the tests of each interpolation."""

from __future__ import annotations

import numpy as np

from app.maps.interpolation.triangles import TaxelTriangles


def jittered(side=9, *, seed=0, jitter=0.3) -> np.ndarray:
    """(side², 2) taxels about 10 mm apart, no two rows in line."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    places = np.stack([x, y], axis=-1).reshape(-1, 2) + 0.5
    return 0.01 * (places + np.random.default_rng(seed).uniform(-jitter, jitter, places.shape))


def horseshoe() -> np.ndarray:
    """(n, 2) taxels on two arms 40 mm apart, joined at one end: what a method must not reach across."""
    x, y = np.meshgrid(np.arange(16), np.arange(10))
    places = np.stack([x, y], axis=-1).reshape(-1, 2)
    arms = places[(places[:, 0] < 3) | (places[:, 1] < 3) | (places[:, 1] > 6)]
    return 0.01 * (arms + np.random.default_rng(0).uniform(-0.2, 0.2, arms.shape))


def held(triangles: TaxelTriangles, *, count=3000, seed=1) -> np.ndarray:
    """(k, 2) random points that lie in triangles."""
    low, high = triangles.sites.min(axis=0), triangles.sites.max(axis=0)
    points = np.random.default_rng(seed).uniform(low, high, (count, 2))
    kept = points[triangles.locate(points)[0] >= 0]
    assert len(kept) > 0.3 * count
    return kept
