"""Correlation between taxels, at once or with one ahead of the other, from sparse readings."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from app.arrays import FloatArray

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
