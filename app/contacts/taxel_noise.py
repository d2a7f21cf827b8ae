"""Noise of each taxel, estimated from a few readings of the untouched skin, and the thresholds that follow from it.

A standard deviation from few readings is uncertain itself: of five readings, one in thirty is below a third of the true
value. Two things are done about that.

The variances of a skin's taxels resemble each other, so each is combined with what the others show (empirical Bayes;
G. K. Smyth, Linear models and empirical Bayes methods for assessing differential expression in microarray experiments,
Statistical Applications in Genetics and Molecular Biology 3 (2004), article 3). With the variance s_i² of taxel i from
f_i degrees of freedom (readings minus one) and a prior variance s_0² of f_0 degrees of freedom:

    variance_i = (f_0 s_0² + f_i s_i²) / (f_0 + f_i),    with f_0 + f_i degrees of freedom

Prior and degrees of freedom follow from mean and variance of log s_i² over the skin (section 6.2 there): where taxels
differ by much, f_0 is small and each keeps its own variance.

A limit of k standard deviations becomes a limit of the quantile of Student's t distribution with these degrees of
freedom that is exceeded as rarely as k is by a normal distribution. Thus the rate of false contacts does not depend on
the number of readings; few readings cost sensitivity instead. The same limit for one taxel (6 standard deviations):
112 of 5 readings where noise spreads evenly over two decades, 21 of 10, 10 of 20, 7.3 of 50; where all taxels are
alike, 6.

The baseline is the mean of the same n readings, so readings above it have (1 + 1/n) times the variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import digamma, ndtr, polygamma, stdtrit

from app.core.arrays import FloatArray, IntArray, dot, freeze_arrays

_EXACT_FREEDOM = 1e6
"""Degrees of freedom from which on a standard deviation counts as known exactly."""


@dataclass(frozen=True, eq=False)
class TaxelNoise:
    """Noise of each of n taxels.

    Attributes:
        sd: (n,) standard deviation of a reading above its baseline [Pa].
        freedom: (n,) degrees of freedom of ``sd``.
    """

    sd: FloatArray
    freedom: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "sd", "freedom")

    def limits(self, deviations: float) -> FloatArray:
        """(n,) reading [Pa] exceeded as rarely as ``deviations`` standard deviations of a normal distribution."""
        return student_factor(deviations, self.freedom) * self.sd

    def exceeded(self, deviations: float, forces: FloatArray, taxels: IntArray, areas: FloatArray) -> bool:
        """Whether some of the taxels together bear more force than noise of ``deviations`` standard deviations.

        The taxels are added one by one, those with the least noise first, so that a very noisy taxel cannot hide a
        contact of its neighbours. A sum must exceed two limits: that of the sum, whose degrees of freedom are those of
        Welch and Satterthwaite (JCGM 100:2008, G.4.1), and that of each of its taxels alone, because far in the tail
        one underestimated taxel makes the sum.

        Args:
            deviations: Standard deviations of a normal distribution that is exceeded as rarely.
            forces: (k,) [N].
            taxels: (k,) their numbers.
            areas: (k,) [m²].
        """
        sd, freedom = areas * self.sd.take(taxels), self.freedom.take(taxels)
        alone = sd * student_factor(deviations, freedom)
        order = np.argsort(alone, kind="stable")
        variances = np.cumsum(np.square(sd[order]))
        pooled = np.square(variances) / np.maximum(np.cumsum(sd[order] ** 4 / freedom[order]), 1e-300)
        limits = np.maximum(alone[order], student_factor(deviations, pooled) * np.sqrt(variances))
        return bool((np.cumsum(forces[order]) >= limits).any())

    def mean_sd(self, taxels: IntArray, areas: FloatArray) -> float:
        """Standard deviation [Pa] that, equal on all of ``taxels`` (k,), makes their force as uncertain as it is."""
        loads = areas * self.sd.take(taxels)
        return (dot(loads, loads) / dot(areas, areas)) ** 0.5


def student_factor(deviations: float, freedom: FloatArray) -> FloatArray:
    """Return the quantiles of Student's t that are exceeded as rarely as ``deviations`` by a normal distribution."""
    quantiles = -stdtrit(np.minimum(freedom, _EXACT_FREEDOM), ndtr(-deviations))
    return np.where(freedom >= _EXACT_FREEDOM, deviations, quantiles)


def estimate_noise(spread: FloatArray, counts: IntArray) -> TaxelNoise | None:
    """Estimate the noise of taxels from readings of the untouched skin; None where no taxel's readings differ.

    Args:
        spread: (n,) root mean square deviation of each taxel's readings from their mean [Pa].
        counts: (n,) number of these readings. Taxels with fewer than two, or whose readings do not differ at all, get
            the noise of the others: such readings may have been held or repeated.
    """
    counts = np.maximum(counts, 1)
    own: FloatArray = np.asarray(counts, dtype=np.float64) - 1.0
    variances = np.where(own > 0, np.square(spread) * counts / np.maximum(own, 1.0), 0.0)
    varied = variances > 0
    if not varied.any():
        return None
    prior, freedom = _prior(variances[varied], own[varied])
    pooled = np.where(varied, (freedom * prior + own * variances) / (freedom + own), prior)
    return TaxelNoise(np.sqrt(pooled * (1 + 1 / counts)), freedom + own)


def _prior(variances: FloatArray, freedom: FloatArray) -> tuple[float, float]:
    """Prior variance and its degrees of freedom; ``variances`` and ``freedom`` (k,) are those of the taxels."""
    logs = np.log(variances) - digamma(freedom / 2) + np.log(freedom / 2)
    mean = float(logs.mean())
    excess = float(logs.var(ddof=1) - polygamma(1, freedom / 2).mean()) if len(logs) > 1 else 0.0
    if excess <= float(polygamma(1, _EXACT_FREEDOM / 2)):
        return float(np.exp(mean)), _EXACT_FREEDOM
    half = float(brentq(lambda x: float(polygamma(1, x)) - excess, 1e-6, _EXACT_FREEDOM / 2))
    return float(np.exp(mean + digamma(half) - np.log(half))), 2 * half
