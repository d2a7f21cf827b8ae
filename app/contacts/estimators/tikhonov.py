"""Pressures as near to the readings as noise allows: Tikhonov's regularization with the discrepancy principle."""

from __future__ import annotations

import math

import numpy as np

from app.arrays import FloatArray
from app.contacts.estimators.estimate import ForceEstimate, Reading
from app.contacts.estimators.rank import rank_of
from app.contacts.estimators.spread import Spread
from app.skin.skin import Skin

_ROUNDS = 45


class Tikhonov:
    """Least squares with a price on what differs from the readings, on the region and its ring. Built once for a skin.

    The price is the highest at which the answer still explains the readings to within their noise (Morozov, 1966). With
    exact readings there is no price, and it is plain least squares. Where the blur drowns in the noise the answer is
    the readings themselves; a price on plain size would draw the total down, by 20 to 30 % at 5 % noise. Pressures may
    come out negative at the rim. Net shear is not observable.

    Args:
        skin: The skin.
        depth: Of the taxels below the surface [m], > 0.

    Raises:
        MapError: The depth is no such number.
    """

    def __init__(self, skin: Skin, *, depth: float) -> None:
        self._areas, self._spread = skin.areas, Spread(skin, depth)

    def estimate(self, reading: Reading) -> ForceEstimate:
        """Force and, unless refused, its distribution. Cost: 0.3 ms for 30 taxels that were touched before."""
        region = reading.region
        matrix, own = self._spread.matrix(region.taxels), reading.pressures.take(region.taxels)
        change, values = discrepancy(matrix, own - matrix @ own, reading.noise)
        pressures = own + change
        rank = rank_of(values, own, reading.noise, unknowns=len(own))
        forces, refused = pressures * self._areas.take(region.taxels), rank.refusal
        none = slice(0, 0 if refused else None)
        missed = float(np.sqrt(np.mean(np.square(matrix @ pressures - own))))
        return ForceEstimate(
            float(forces.sum()), region.at, region.taxels[none], forces[none], rank.condition, rank.effective,
            rank.unknowns, missed, reading.noise, refused,
        )  # fmt: skip


def discrepancy(matrix: FloatArray, readings: FloatArray, noise: float) -> tuple[FloatArray, FloatArray]:
    """The x that minimises |A x - y|² + price |x|² with |A x - y| = noise sqrt(m); and the singular values of A.

    Where even x = 0 explains the readings to within their noise, x is 0. Where no price does, it is 0.

    Args:
        matrix: A (m, n).
        readings: y (m,) [Pa].
        noise: Standard deviation of a reading [Pa].

    Cost: one singular value decomposition.
    """
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    seen = left.T @ readings
    beyond = max(float(readings @ readings - seen @ seen), 0.0)
    allowed = noise**2 * len(readings)
    if allowed >= float(readings @ readings):
        return np.zeros(matrix.shape[1]), values
    price = _price(values, seen, allowed - beyond)
    scale = np.divide(values, values**2 + price, out=np.zeros_like(values), where=values > 1e-14 * values[0])
    return right.T @ (scale * seen), values


def _price(values: FloatArray, seen: FloatArray, allowed: float) -> float:
    """At which the squared residual is ``allowed``, by halving its logarithm; 0 where none is that small."""

    def missed(price: float) -> float:
        return float(np.square(price / (values**2 + price) * seen).sum())

    low, high = 1e-20 * values[0] ** 2, 1e8 * values[0] ** 2
    if allowed <= missed(low):
        return 0.0
    for _ in range(_ROUNDS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if missed(middle) < allowed else (low, middle)
    return high
