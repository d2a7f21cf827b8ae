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

Noise that is not normal has a longer tail: clipped at zero, Laplace, spikes. ``tail_of_readings`` measures the upper
tail of all taxels together. Each reading of the tare is compared with the other readings of its taxel (externally
studentized residuals; R. D. Cook and S. Weisberg, Residuals and Influence in Regression, 1982, section 2.2.1):

    z_ij = (x_ij - mean of the others) / (sd from the others and the prior, times (1 + 1/(n - 1))^½)

For normal noise z follows Student's t with f_d = f_0 + n_i - 2 degrees of freedom. A scaled t distribution with ν
degrees of freedom is fitted to the z above their 97 % quantile u, a share p of all, by their mean (plus half its
standard error). T is the upper quantile of t at p and g its density (A. J. McNeil, R. Frey, P. Embrechts, Quantitative
Risk Management, 2005, example 2.19):

    mean z above u / u = g(T) (ν + T²) / ((ν - 1) p T),    scale c = u / T

All limits are c times as wide (c at least 1), with 1/(1/(f_0 + f_i) + h) degrees of freedom, h = max(0, 1/ν - 1/f_d),
but not fewer than 4. A polynomial tail is the cautious choice: 15,000 values cannot show what is exceeded once in
10⁹.

The baseline is the mean of the same n readings, so readings above it have (1 + 1/n) times the variance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import beta, chdtrc, digamma, ndtr, polygamma, stdtr, stdtrit

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, dot, readonly

_EXACT_FREEDOM = 1e6
"""Degrees of freedom from which on a standard deviation counts as known exactly."""
_LEAST_FREEDOM = 4.0
"""Degrees of freedom of the heaviest tail."""
_SEVERAL = 3
"""Number of taxels from which on they exceed the noise together: one or two may be underestimated."""
_SMALLEST_CHANCE = 1e-300
_TAIL = 0.03
"""Share of the readings that the tail is fitted to."""
_FEWEST = 10
"""Number of readings in a tail from which on it is fitted."""


@dataclass(frozen=True)
class TailShape:
    """Upper tail of the noise compared with a normal distribution's, which the defaults describe.

    Attributes:
        scale: Factor of the limits, at least 1.
        heaviness: Reciprocal of the tail's degrees of freedom; 0 for a normal tail.
    """

    scale: float = 1.0
    heaviness: float = 0.0


_NORMAL = TailShape()


@dataclass(frozen=True, eq=False)
class TaxelNoise(ArrayFields):
    """Noise of each of n taxels.

    Attributes:
        sd: (n,) standard deviation of a reading above its baseline [Pa].
        freedom: (n,) degrees of freedom of the limits: those of ``sd``, fewer where the tail is heavy.
        scale: Factor of the limits.
    """

    sd: FloatArray
    freedom: FloatArray
    scale: float = 1.0

    def limits(self, deviations: float) -> FloatArray:
        """(n,) reading [Pa] exceeded as rarely as ``deviations`` standard deviations of a normal distribution."""
        limits = self._limits.get(deviations)
        if limits is None:  # the quantiles of 500 taxels take 0.4 ms, and each reading is compared with them
            limits = readonly(self.scale * student_factor(deviations, self.freedom) * self.sd)
            self._limits[deviations] = limits
        return limits

    @cached_property
    def _limits(self) -> dict[float, FloatArray]:
        """Computed limits by their standard deviations."""
        return {}

    def exceeded(self, deviations: float, forces: FloatArray, taxels: IntArray, areas: FloatArray) -> bool:
        """Whether some of the taxels together bear more force than noise of ``deviations`` standard deviations.

        The taxels are added one by one, those with the least noise first, so that a very noisy taxel cannot hide a
        contact of its neighbours. A sum must exceed two limits: that of the sum, whose degrees of freedom are those of
        Welch and Satterthwaite (JCGM 100:2008, G.4.1), and that of each of its taxels alone, because far in the tail
        one underestimated taxel makes the sum.

        Three or more taxels exceed the noise also by their number: after few readings the limit of each alone is far
        above its threshold, but noise does not exceed several limits of neighbours at once. Their probabilities are
        combined by Fisher's method (R. A. Fisher, Statistical Methods for Research Workers, 1932, section 21.1):
        -2 sum log p_i follows the chi-squared distribution with 2 k degrees of freedom.

        Args:
            deviations: Standard deviations of a normal distribution that is exceeded as rarely.
            forces: (k,) [N].
            taxels: (k,) their numbers.
            areas: (k,) [m²].
        """
        sd = self.scale * areas * self.sd.take(taxels)
        freedom = self.freedom.take(taxels)
        alone = sd * student_factor(deviations, freedom)
        order = np.argsort(alone, kind="stable")
        variances = np.cumsum(np.square(sd[order]))
        pooled = np.square(variances) / np.maximum(np.cumsum(sd[order] ** 4 / freedom[order]), 1e-300)
        limits = np.maximum(alone[order], student_factor(deviations, pooled) * np.sqrt(variances))
        if (np.cumsum(forces[order]) >= limits).any():
            return True
        chances = np.maximum(stdtr(np.minimum(freedom, _EXACT_FREEDOM), -forces / sd), _SMALLEST_CHANCE)
        together = chdtrc(2 * len(chances), -2 * np.log(chances).sum())
        return len(chances) >= _SEVERAL and bool(together < ndtr(-deviations))

    def mean_sd(self, taxels: IntArray, areas: FloatArray) -> float:
        """Standard deviation [Pa] that, if equal for all ``taxels`` (k,), gives the same uncertainty of their force."""
        loads = areas * self.sd.take(taxels)
        return (dot(loads, loads) / dot(areas, areas)) ** 0.5


def student_factor(deviations: float, freedom: FloatArray) -> FloatArray:
    """Return the quantiles of Student's t that are exceeded as rarely as ``deviations`` by a normal distribution."""
    quantiles = -stdtrit(np.minimum(freedom, _EXACT_FREEDOM), ndtr(-deviations))
    return np.where(freedom >= _EXACT_FREEDOM, deviations, quantiles)


def estimate_noise(spread: FloatArray, counts: IntArray, tail: TailShape = _NORMAL) -> TaxelNoise | None:
    """Estimate the noise of taxels from readings of the untouched skin; None where no taxel's readings differ.

    Args:
        spread: (n,) root mean square deviation of each taxel's readings from their mean [Pa].
        counts: (n,) number of these readings. Taxels with fewer than two, or whose readings do not differ at all, get
            the noise of the others: such readings may have been held or repeated.
        tail: Upper tail of the noise, from ``tail_of_readings``.
    """
    counts = np.maximum(counts, 1)
    own: FloatArray = np.asarray(counts, dtype=np.float64) - 1.0
    variances = np.where(own > 0, np.square(spread) * counts / np.maximum(own, 1.0), 0.0)
    varied = variances > 0
    if not varied.any():
        return None
    prior, freedom = _prior(variances[varied], own[varied])
    pooled = np.where(varied, (freedom * prior + own * variances) / (freedom + own), prior)
    total = freedom + own
    heavy = np.maximum(1 / (1 / total + tail.heaviness), np.minimum(total, _LEAST_FREEDOM))
    return TaxelNoise(np.sqrt(pooled * (1 + 1 / counts)), heavy, tail.scale)


def tail_of_readings(readings: FloatArray) -> TailShape:
    """Fit the upper tail of the noise to readings of the untouched skin; see the module.

    Args:
        readings: (readings, n) values; NaN where a taxel has none. Taxels with fewer than three values, or whose values
            do not differ, are left out.
    """
    heard = np.isfinite(readings)
    usable = heard.sum(axis=0) >= 3
    values = readings[:, usable]
    values = values - np.nanmin(values, axis=0)  # exactly 0 where the values do not differ
    counts: FloatArray = heard[:, usable].sum(axis=0).astype(np.float64)
    away = values - np.nansum(values, axis=0) / counts
    squares = np.nansum(np.square(away), axis=0)
    varied = (squares > 0) & (np.nanmax(values, axis=0) > 0)
    if not varied.any():
        return _NORMAL
    away = away[:, varied]
    squares = squares[varied]
    counts = counts[varied]
    own = counts - 1
    prior, freedom = _prior(squares / own, own)
    others = np.maximum(squares - np.square(away) * counts / own, 0.0)
    variances = (freedom * prior + others) / (freedom + own - 1)
    scores = away * np.sqrt(counts / own / variances)
    return _fit_tail(scores[np.isfinite(scores)], float(np.median(freedom + own - 1)))


def _fit_tail(scores: FloatArray, freedom: float) -> TailShape:
    """Fit the tail of ``scores`` (k,), which have ``freedom`` degrees of freedom where the noise is normal."""
    start = float(np.quantile(scores, 1 - _TAIL))
    if start < 1:  # most values are equal and few differ from them
        above = scores[scores > 1]
        start = float(np.median(above)) if len(above) else 1.0
    beyond = scores[scores >= start]
    if len(beyond) < _FEWEST:
        return _NORMAL
    share = len(beyond) / len(scores)
    mean = float(beyond.mean() + 0.5 * beyond.std() / np.sqrt(len(beyond))) / start
    if mean <= _mean_beyond(_EXACT_FREEDOM, share):
        tail = _EXACT_FREEDOM
    elif mean >= _mean_beyond(_LEAST_FREEDOM, share):
        tail = _LEAST_FREEDOM
    else:
        tail = _root(lambda x: _mean_beyond(x, share) - mean, _LEAST_FREEDOM, _EXACT_FREEDOM)
    scale = start / -float(stdtrit(tail, share))
    return TailShape(max(1.0, scale), max(0.0, 1 / tail - 1 / freedom))


def _mean_beyond(freedom: float, share: float) -> float:
    """Mean of Student's t above its upper quantile at ``share``, divided by that quantile."""
    quantile = -float(stdtrit(freedom, share))
    # The density of Student's t; ``scipy.stats`` takes half of the time to import this package.
    density = (1 + quantile**2 / freedom) ** (-(freedom + 1) / 2) / (np.sqrt(freedom) * float(beta(0.5, freedom / 2)))
    return float(density * (freedom + quantile**2) / ((freedom - 1) * share * quantile))


def _prior(variances: FloatArray, freedom: FloatArray) -> tuple[float, float]:
    """Prior variance and its degrees of freedom; ``variances`` and ``freedom`` (k,) are those of the taxels."""
    logs = np.log(variances) - digamma(freedom / 2) + np.log(freedom / 2)
    mean = float(logs.mean())
    excess = float(logs.var(ddof=1) - polygamma(1, freedom / 2).mean()) if len(logs) > 1 else 0.0
    if excess <= float(polygamma(1, _EXACT_FREEDOM / 2)):
        return float(np.exp(mean)), _EXACT_FREEDOM
    half = _root(lambda x: float(polygamma(1, x)) - excess, 1e-6, _EXACT_FREEDOM / 2)
    return float(np.exp(mean + digamma(half) - np.log(half))), 2 * half


def _root(function: Callable[[float], float], lower: float, upper: float) -> float:
    """Return the root between two bounds at which the function has opposite signs."""
    from scipy.optimize import brentq  # 0.07 s to import, and only measured readings need it

    return float(brentq(function, lower, upper))
