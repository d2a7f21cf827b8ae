"""SMACOF: points moved until their distances fit the wanted ones best, by a majorant that never overshoots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from app.arrays import FloatArray
from app.maps.learned.learned_map import Progress, silent


@dataclass(frozen=True, eq=False)
class Fitted:
    """Points (n, d) and the weighted sum of squared misfits after each round, falling."""

    points: FloatArray
    losses: tuple[float, ...]


def smacof(
    wanted: FloatArray, start: FloatArray, *, rounds: int = 300, tolerance: float = 1e-6, progress: Progress = silent
) -> Fitted:
    """Minimise  sum_ij w_ij (|x_i - x_j| - d_ij)²  with  w = 1 / d², so that relative errors count alike.

    De Leeuw 1977; Borg and Groenen, Modern Multidimensional Scaling, 8.6. Each round is the exact minimum of a
    quadratic that touches the loss and nowhere lies below it, so the loss never rises. Without the weights the many
    long distances, which are the least certain, would decide where neighbours lie.

    Args:
        wanted: (n, n) symmetric, > 0 off the diagonal.
        start: (n, d).
        rounds: At most.
        tolerance: Stop when a round lowers the loss by less than this share.
        progress: Told the share of ``rounds`` done.

    Cost: 0.1 s once and 20 ms a round for 1000 points.
    """
    weights = _weights(wanted)
    laplacian = np.diag(weights.sum(axis=1)) - weights
    # Adding a constant to all entries fixes the one direction it leaves free, all points moved alike.
    inverse = np.linalg.inv(laplacian + laplacian.trace() / len(wanted) ** 2)
    points, losses = start - start.mean(axis=0), [np.inf]
    for number in range(rounds):
        apart = cdist(points, points)
        losses.append(0.5 * float((weights * (apart - wanted) ** 2).sum()))
        if losses[-2] - losses[-1] <= tolerance * losses[-1]:
            break
        progress("Fitting distances", number / rounds)
        pull = -weights * np.divide(wanted, apart, out=np.zeros_like(apart), where=apart > 0)
        pull[np.diag_indices_from(pull)] -= pull.sum(axis=1)
        points = inverse @ (pull @ points)
    return Fitted(points, tuple(losses[1:]))


def _weights(wanted: FloatArray) -> FloatArray:
    return np.divide(1.0, wanted**2, out=np.zeros_like(wanted), where=wanted > 0)


def kruskal_stress(points: FloatArray, wanted: FloatArray) -> float:
    """Kruskal's stress-1 of the points' distances against ``wanted`` (n, n), at the best common scale."""
    apart = cdist(points, points)
    square = (apart**2).sum()
    if square == 0:
        return float("nan")
    scale = (apart * wanted).sum() / square
    return float(np.sqrt(((scale * apart - wanted) ** 2).sum() / (wanted**2).sum()))
