"""Pressures that are not negative and explain a region's readings best."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from app.arrays import FloatArray
from app.contacts.estimators.blur import Blur
from app.contacts.estimators.unblurred import Solution


def nonnegative(blur: Blur, readings: FloatArray, _noise: float) -> Solution:
    """Non-negative least squares (Lawson and Hanson, 1974).

    On a region and its ring alone: over a whole map the constraint turns noise into force, up to 80 % too much. Contact
    cannot pull, and that alone tames the blur's inverse. What is pressed is then found by plain least squares among
    what is pressed, which gives the slope.

    Cost: 0.1 ms for 30 x 30.
    """
    pressures, _ = nnls(blur.matrix, readings)
    pressed = np.flatnonzero(pressures)
    slope = np.zeros(blur.matrix.T.shape)
    if len(pressed):
        slope[pressed] = np.linalg.pinv(blur.matrix[:, pressed])
    return Solution(np.asarray(pressures, dtype=np.float64), slope)
