"""Vector functions of the plane: cross product and winding number."""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return (...,) the z component of the cross product of vectors (..., 2); positive if the second is to the left."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def winding_numbers(loop: FloatArray, points: FloatArray) -> FloatArray:
    """Return how often a closed polygon (n, 2) winds counter-clockwise around each of ``points`` (k, 2)."""
    arms = loop[None] - points[:, None]
    after = np.roll(arms, -1, axis=1)
    turned = np.arctan2(cross(arms, after), (arms * after).sum(axis=-1))
    return np.asarray(np.rint(turned.sum(axis=1) / (2 * np.pi)))
