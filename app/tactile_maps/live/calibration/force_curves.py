"""Curves from the readings of taxels to pressures, fitted and chosen by cross-validation.

Three kinds of curves compete: proportional, a power, and piecewise linear. All pass through 0 and increase. The
simplest is used unless another has a clearly smaller error in a cross-validation, by two standard errors (after Hastie,
Tibshirani and Friedman, The Elements of Statistical Learning, 2009, section 7.10, who use one).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize_scalar, nnls

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError, check_range
from tactile_maps.core.progress import Progress

_LEAST_LEVELS = 5
"""Least number of different loads from which a curve need not be proportional."""
_POINTS = 12
"""Number of points of a stored power curve."""
_SEGMENTS = 5
"""Largest number of segments of a piecewise linear curve."""
_BLOCKS_PER_FOLD = 4
_FLATTEST = 1e-3
"""Least slope within a piecewise linear curve, as a share of its mean slope: a curve must increase."""
_CLEAR = 2.0
"""Standard errors, over the folds, by which a less simple curve must reduce the squared error."""
_EXPONENTS = (0.2, 5.0)
_PULL = 1e-3
"""Error of the load, as a share of the largest one, that counts as much as a curve of twice the common gain."""


class CurveKind(StrEnum):
    """Kinds of curves, from the simplest one."""

    LINEAR = "linear"
    POWER = "power"
    PIECEWISE = "piecewise"


class CurveFit(NamedTuple):
    """Curve of one taxel.

    Attributes:
        kind: Its kind.
        points: (2, k) its points.
        fold: (m,) fold of each row.
        targets: (m,) pressures to which it was fitted [Pa].
        held: (m,) pressures predicted for rows while they were held out [Pa].
        squares: Mean squared error of held-out rows by kind [Pa²]; empty if it was fitted jointly with others.
        uncertainty: Standard error at half of the range, as a share.
    """

    kind: CurveKind
    points: FloatArray
    fold: IntArray
    targets: FloatArray
    held: FloatArray
    squares: Mapping[CurveKind, float]
    uncertainty: float

    def uncertainty_with(self, offset: float) -> float:
        """Return the standard error at half of the range, as a share, with that of the offset of the reading."""
        middle = self.points[0, -1] / 2
        low, high = on_curve(self.points, np.array([middle, middle + offset]))
        return float(np.hypot(self.uncertainty, (high - low) / low))

    @property
    def deviation(self) -> float:
        """Root mean square error of held-out rows [Pa]."""
        return float(np.sqrt(np.mean((self.held - self.targets) ** 2)))


def folds_of(loads: FloatArray | IntArray, folds: int, random: np.random.Generator) -> IntArray:
    """Return the fold (m,) of each row, assigned in blocks of consecutive rows between changes of the load.

    Raises:
        LiveError: The number of folds is not 2 to 20.
    """
    check_range("the number of folds", folds, 2, 20, error=LiveError)
    level = np.concatenate([[0], np.cumsum(np.diff(loads) != 0)])
    blocks = min(_BLOCKS_PER_FOLD * folds, int(level[-1]) + 1)
    block = level * blocks // (int(level[-1]) + 1)
    return np.asarray((random.permutation(blocks) % folds)[block], dtype=np.int64)


def fit_curve(x: FloatArray, y: FloatArray, fold: IntArray) -> CurveFit:
    """Fit the best kind of curve.

    Args:
        x: (m,) changes of the readings, at least 0.
        y: (m,) pressures at these changes [Pa].
        fold: (m,) fold of each row.
    """
    parts = np.unique(fold).tolist() if len(np.unique(fold)) > 1 else []
    kinds = list(CurveKind) if parts and len(np.unique(y)) >= _LEAST_LEVELS else [CurveKind.LINEAR]
    held = {kind: np.zeros_like(y) for kind in kinds}
    left_out: dict[CurveKind, list[FloatArray]] = {kind: [] for kind in kinds}
    for kind in kinds:
        for part in parts:
            out = fold == part
            left_out[kind].append(_CURVES[kind](x[~out], y[~out]))
            held[kind][out] = on_curve(left_out[kind][-1], x[out])
    squares = {kind: np.array([np.mean((held[kind] - y)[fold == part] ** 2) for part in parts]) for kind in kinds}
    kind = _best_kind(squares)
    points = _CURVES[kind](x, y)
    means = {one: float(np.mean((held[one if one in held else kind] - y) ** 2)) for one in CurveKind}
    return CurveFit(kind, points, fold, y, held[kind], means, _jackknife(points, left_out[kind]))


def force_shares(loads: FloatArray, pressures: FloatArray, areas: FloatArray) -> FloatArray:
    """Return pressures (m, taxels) in the proportions of the given ones whose forces sum up to the loads (m,)."""
    force = pressures @ areas
    return np.asarray(pressures * (np.divide(loads, force, out=np.zeros_like(force), where=force > 0))[:, None])


def fit_jointly(
    loads: FloatArray, felt: FloatArray, areas: FloatArray, loaded: BoolArray, fold: IntArray, progress: Progress
) -> tuple[dict[int, CurveFit], dict[CurveKind | None, float]]:
    """Fit curves of one kind for all taxels to the loads on all of them together.

    Args:
        loads: (m,) loads [N].
        felt: (m, taxels) changes of the readings, at least 0.
        areas: (taxels,) areas [m²].
        loaded: (m, taxels) rows that count for each taxel; a taxel without rows gets no curve.
        fold: (m,) fold of each row.
        progress: Receives the progress.

    Returns:
        The fits, and the root mean square error of held-out loads by kind; None for the chosen kind.
    """
    parts = np.unique(fold).tolist() if len(np.unique(fold)) > 1 else []
    kinds = list(CurveKind) if parts and len(np.unique(loads)) >= _LEAST_LEVELS else [CurveKind.LINEAR]
    taxels = np.flatnonzero(loaded.any(axis=0)).tolist()
    knots = {taxel: _knots(felt[loaded[:, taxel], taxel]) for taxel in taxels}
    curves: dict[CurveKind, dict[int, FloatArray]] = {}
    left_out: dict[CurveKind, list[dict[int, FloatArray]]] = {kind: [] for kind in kinds}
    squares = {}
    for number, kind in enumerate(kinds):
        curves[kind] = _fit_together(kind, loads, felt, areas, knots)
        errors = np.zeros(len(loads))
        for part in parts:
            progress("Fitting curves", (number + part / len(parts)) / len(kinds))
            out = fold == part
            left_out[kind].append(_fit_together(kind, loads[~out], felt[~out], areas, knots))
            errors[out] = _pressures(left_out[kind][-1], felt[out]) @ areas - loads[out]
        squares[kind] = np.array([np.mean(errors[fold == part] ** 2) for part in parts])
    kind = _best_kind(squares)
    targets = force_shares(loads, _pressures(curves[kind], felt), areas)
    held = np.zeros_like(felt)
    for part, found in zip(parts, left_out[kind], strict=True):
        held[fold == part] = _pressures(found, felt[fold == part])
    fits = {}
    for taxel, points in curves[kind].items():
        rows = loaded[:, taxel]
        spread = _jackknife(points, [found[taxel] for found in left_out[kind]])
        fits[taxel] = CurveFit(kind, points, fold[rows], targets[rows, taxel], held[rows, taxel], {}, spread)
    by_kind: dict[CurveKind | None, float] = {
        one: float(np.sqrt(squares[one if one in squares else kind].mean())) for one in (*CurveKind, None)
    }
    return fits, by_kind


def _fit_together(
    kind: CurveKind, loads: FloatArray, felt: FloatArray, areas: FloatArray, knots: Mapping[int, FloatArray]
) -> dict[int, FloatArray]:
    """Return the points of each taxel's curve by least squares of the loads (m,) on all taxels together.

    A weak pull to a common proportional curve keeps taxels defined that few rows load.

    Args:
        kind: Kind of the curves.
        loads: (m,) loads [N].
        felt: (m, taxels) changes of the readings.
        areas: (taxels,) areas [m²].
        knots: (k,) changes between the segments of each taxel that gets a curve, from 0 to its largest one.
    """
    total = felt @ areas
    gain = (total @ loads) / (total @ total)
    pull = _PULL * loads.max()
    taxels = list(knots)
    if kind is CurveKind.POWER:
        largest = np.array([one[-1] for one in knots.values()])
        scaled = felt[:, taxels] / largest
        logs = np.log(np.maximum(scaled, 1e-12))
        factors = gain * largest * areas[taxels]

        def forces(parameters: FloatArray) -> FloatArray:
            scale, exponents = parameters.reshape(2, -1)
            return np.asarray(np.exp(exponents * logs + scale) * factors * (scaled > 0))

        def residuals(parameters: FloatArray) -> FloatArray:
            away = pull * (parameters - start)
            return np.concatenate([forces(parameters).sum(axis=1) - loads, away])

        def jacobian(parameters: FloatArray) -> FloatArray:
            each = forces(parameters)
            return np.vstack([np.hstack([each, each * logs]), pull * np.eye(len(parameters))])

        start = np.repeat([0.0, 1.0], len(taxels))
        low = np.repeat([-7.0, _EXPONENTS[0]], len(taxels))
        high = np.repeat([7.0, _EXPONENTS[1]], len(taxels))
        scale, exponents = least_squares(residuals, start, jacobian, (low, high), tr_solver="lsmr").x.reshape(2, -1)
        heights = gain * largest * np.exp(scale)
        shapes = zip(largest.tolist(), heights.tolist(), exponents.tolist(), strict=True)
        return {taxel: _power_points(*shape) for taxel, shape in zip(taxels, shapes, strict=True)}
    used = {taxel: one if kind is CurveKind.PIECEWISE else one[[0, -1]] for taxel, one in knots.items()}
    parts = [gain * areas[taxel] * np.diff(one) * _segments(felt[:, taxel], one) for taxel, one in used.items()]
    design = np.hstack(parts)
    design = np.vstack([design, pull * np.eye(design.shape[1])])
    target = np.concatenate([loads, np.full(design.shape[1], pull)])
    factors = nnls(design, target - _FLATTEST * design.sum(axis=1))[0] + _FLATTEST
    ends = np.cumsum([part.shape[1] for part in parts])[:-1]
    slopes = zip(used.items(), np.split(gain * factors, ends), strict=True)
    return {taxel: np.array([one, np.append(0.0, np.cumsum(slope * np.diff(one)))]) for (taxel, one), slope in slopes}


def _pressures(curves: Mapping[int, FloatArray], felt: FloatArray) -> FloatArray:
    """Return the pressures (m, taxels) of changes (m, taxels); 0 for taxels without a curve."""
    found = np.zeros_like(felt)
    for taxel, points in curves.items():
        found[:, taxel] = on_curve(points, felt[:, taxel])
    return found


def _jackknife(points: FloatArray, left_out: Sequence[FloatArray]) -> float:
    """Return the standard error at half of the range, as a share, by curves fitted without one fold each."""
    middle = points[0, -1:] / 2
    found = np.array([on_curve(one, middle)[0] for one in left_out])
    if len(found) < 2:
        return np.nan
    return float(np.sqrt((len(found) - 1) * found.var()) / on_curve(points, middle)[0])


def _best_kind(squares: Mapping[CurveKind, FloatArray]) -> CurveKind:
    """Return the simplest kind on which no other one improves clearly, by the mean squared error of each fold."""
    best = CurveKind.LINEAR
    for kind in list(squares)[1:]:
        gained = squares[best] - squares[kind]
        if gained.mean() > _CLEAR * gained.std(ddof=1) / np.sqrt(len(gained)):
            best = kind
    return best


def on_curve(points: FloatArray, values: FloatArray) -> FloatArray:
    """Return the pressures (m,) of one curve (2, k)."""
    start = np.clip(np.searchsorted(points[0], values, side="right") - 1, 0, points.shape[1] - 2)
    low, base = points[:, start]
    high, top = points[:, start + 1]
    return np.asarray(base + (values - low) * (top - base) / (high - low))


def _linear(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.array([[0.0, x.max()], [0.0, x.max() * (x @ y) / (x @ x)]])


def _power(x: FloatArray, y: FloatArray) -> FloatArray:
    scaled = x / x.max()

    def height(exponent: float) -> tuple[FloatArray, float]:
        shape = scaled**exponent
        return shape, float(shape @ y / (shape @ shape))

    def squares(exponent: float) -> float:
        shape, found = height(exponent)
        return float(((y - found * shape) ** 2).sum())

    exponent = float(minimize_scalar(squares, bounds=_EXPONENTS, method="bounded", options={"xatol": 1e-4}).x)
    return _power_points(float(x.max()), height(exponent)[1], exponent)


def _power_points(largest: float, height: float, exponent: float) -> FloatArray:
    """Return points (2, k) of a power curve, at squares of equal steps: it bends most near 0."""
    steps = np.linspace(0, 1, _POINTS) ** 2
    return np.array([largest * steps, height * np.maximum(steps**exponent, 1e-9 * steps)])


def piecewise(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the points (2, k) of increasing line segments, fitted by non-negative least squares."""
    knots = _knots(x)
    design = _segments(x, knots)
    least = _FLATTEST * np.diff(knots) * (x @ y) / (x @ x)
    increments = nnls(design, y - design @ least)[0] + least
    return np.array([knots, np.append(0.0, np.cumsum(increments))])


def _knots(x: FloatArray) -> FloatArray:
    """Return 0 and quantiles (k,) of the changes ``x`` (m,) up to the largest one."""
    return np.unique(np.append(0.0, np.quantile(x, np.linspace(0, 1, _SEGMENTS + 1)[1:])))


def _segments(x: FloatArray, knots: FloatArray) -> FloatArray:
    """Return how far changes ``x`` (m,) have passed each segment between ``knots`` (k,), 0 to 1: (m, k - 1)."""
    return np.asarray(np.clip((x[:, None] - knots[:-1]) / np.diff(knots), 0.0, 1.0))


_CURVES: Mapping[CurveKind, Callable[[FloatArray, FloatArray], FloatArray]] = {
    CurveKind.LINEAR: _linear,
    CurveKind.POWER: _power,
    CurveKind.PIECEWISE: piecewise,
}
