"""Force calibration: the curve of each taxel from a log of known loads.

The pressure of a taxel is fitted to the change of its reading, the direction in which it is used. Three kinds of curves
compete for each taxel: proportional, a power, and piecewise linear. All pass through 0 and increase. The simplest is
used unless another has a clearly smaller error in a cross-validation, by two standard errors (after Hastie, Tibshirani
and Friedman, The Elements of Statistical Learning, 2009, section 7.10, who use one).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize_scalar, nnls

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.live.channels.calibration import Calibration, padded
from tactile_maps.live.channels.calibration_log import CalibrationLog
from tactile_maps.skin.model.skin import Skin

LEAST_ROWS = 8
"""Least number of loaded rows from which a taxel gets a curve of its own."""
_LEAST_LEVELS = 5
"""Least number of different loads from which a curve need not be proportional."""
_POINTS = 12
"""Number of points of a stored power curve."""
_SEGMENTS = 5
"""Largest number of segments of a piecewise linear curve."""
_BLOCKS_PER_FOLD = 4
_NO_LOAD = 0.01
"""Loads below this share of the largest one count as none."""
_TURN = 0.1
"""Change of the load that counts as a reversal, as a share of the largest load."""
_MEDIAN = 1.2533
"""Standard error of a median of normal values, relative to that of the mean."""
_COMMON = 0.9
"""Quantile of the readings up to which rising and falling load are compared: near a reversal they meet."""
_FLATTEST = 1e-3
"""Least slope within a piecewise linear curve, as a share of its mean slope: a curve must increase."""
_CLEAR = 2.0
"""Standard errors, over the folds, by which a less simple curve must reduce the squared error."""
_EXPONENTS = (0.2, 5.0)
_NOISE = 3.0
"""Readings that share a force must exceed this many standard deviations of those at zero load."""
_PULL = 1e-3
"""Error of the load, as a share of the largest one, that counts as much as a curve of twice the common gain."""


class CurveKind(StrEnum):
    """Kinds of curves, from the simplest one."""

    LINEAR = "linear"
    POWER = "power"
    PIECEWISE = "piecewise"


@dataclass(frozen=True, eq=False)
class ForceCalibration(ArrayFields):
    """A calibration fitted to a log, and its quality.

    Attributes:
        calibration: The calibration; its deviations are those of held-out rows.
        kinds: Kind of each taxel's curve.
        rows: (taxels,) number of rows under load.
        uncertainty: (taxels,) standard error of the curve at half of its range, as a share of the pressure there, by
            the jackknife over the folds, and with that of the offset; NaN for pooled taxels.
        hysteresis: (taxels,) largest difference in pressure between rising and falling load at the same reading, as a
            share of the largest pressure; NaN where the log does not have both.
        branch_gain: (taxels,) share by which separate curves for rising and falling load would reduce the error of
            held-out rows; negative if they increase it, NaN where the log does not have both.
        pooled: (k,) taxels with too few rows, which have the common curve of all others.
        error: Root mean square error of the loads of held-out rows [N], or of the pressures [Pa].
        errors: The same if all curves were of one kind.
        largest: Largest load of the log [N or Pa].
        pressure: Whether the loads were pressures.
    """

    calibration: Calibration
    kinds: tuple[CurveKind, ...]
    rows: IntArray
    uncertainty: FloatArray
    hysteresis: FloatArray
    branch_gain: FloatArray
    pooled: IntArray
    error: float
    errors: Mapping[CurveKind, float]
    largest: float
    pressure: bool


def fit_force(
    log: CalibrationLog,
    skin: Skin,
    *,
    folds: int = 5,
    seed: int = 0,
    changes: bool = False,
    progress: Progress = no_progress,
) -> ForceCalibration:
    """Fit the curve of each taxel to a log of known loads.

    The offset of a taxel is the median of its readings at zero load. If several taxels feel a force, the curves of all
    taxels are of one kind and are fitted together, so that area times pressure sums up to the force. The folds consist
    of blocks of consecutive rows; rows of one load stay together, so that repeated rows are not held out and fitted at
    the same time.

    Args:
        log: The log.
        skin: The skin; the areas of its taxels [m²] relate forces to pressures.
        folds: Number of folds of the cross-validation, 2 to 20.
        seed: Seed of the assignment of blocks to folds.
        changes: Whether the readings are changes from the untouched skin, so that no row at zero load is needed.
        progress: Receives the progress.

    Raises:
        LiveError: The number of folds is out of range, the log is of another skin or has no row at zero load, or no
            taxel has enough rows.

    Cost: 15 ms for each taxel with 60 rows; 2 s for 60 taxels that share 600 forces.
    """
    if not 2 <= folds <= 20:
        raise LiveError("the number of folds is out of range", value=folds, remedy="Choose 2 to 20")
    if log.readings.shape[1] != len(skin):
        raise LiveError("the log is of another skin", value=f"{log.readings.shape[1]} taxels for {len(skin)}")
    loads = _felt_loads(log, skin, changes=changes)
    own = np.flatnonzero(loads.loaded.sum(axis=0) >= LEAST_ROWS)
    if not len(own):
        found = f"at most {loads.loaded.sum(axis=0).max()}"
        remedy = f"Log at least {LEAST_ROWS} rows of one taxel under load"
        raise LiveError("no taxel has enough rows", value=found, remedy=remedy)
    random = np.random.default_rng(seed)
    if loads.joint:
        fold = _folds_of(log.loads, folds, random)
        loaded = loads.loaded & np.isin(np.arange(len(skin)), own)
        fits, errors = _fit_jointly(log.loads, loads.felt, loads.areas, loaded, fold, progress)
    else:
        fits = _fit_each(log.loads, loads, own, folds, random, progress)
        errors = _errors(fits, loads.areas)
    branches = np.full((2, len(skin)), np.nan)
    branches[:, own] = np.transpose(
        [_branches(log.loads[loads.loaded[:, one]], loads.felt[loads.loaded[:, one], one], fits[one]) for one in fits]
    )
    pooled = np.setdiff1d(np.arange(len(skin)), own)
    offset = loads.offset
    sign = loads.sign
    if len(pooled):
        fits |= dict.fromkeys(pooled.tolist(), _common_fit(loads, own, fits))
        offset = np.where(np.isfinite(offset), offset, np.median(offset[own]))
        sign = np.where(np.isin(np.arange(len(skin)), pooled), 1.0 if sign[own].sum() >= 0 else -1.0, sign)
    ordered = [fits[taxel] for taxel in range(len(skin))]
    return ForceCalibration(
        _calibration(ordered, sign, offset),
        tuple(fit.kind for fit in ordered),
        loads.loaded.sum(axis=0),
        np.array([fit.uncertainty_with(one) for fit, one in zip(ordered, loads.offset_error.tolist(), strict=True)]),
        branches[0],
        branches[1],
        pooled,
        errors[None],
        {kind: errors[kind] for kind in CurveKind},
        float(log.loads.max()),
        log.pressure,
    )


class _FeltLoads(NamedTuple):
    """Readings and loads of a log, prepared for the fit.

    Attributes:
        offset: (taxels,) readings at zero load; NaN for taxels without readings.
        offset_error: (taxels,) their standard errors.
        sign: (taxels,) direction in which the readings change under load, 1 or -1.
        felt: (m, taxels) changes of the readings in that direction, at least 0.
        areas: (taxels,) areas [m²], or 1 if the loads are pressures.
        targets: (m, taxels) pressures at which the readings were taken [Pa].
        loaded: (m, taxels) rows that count for each taxel.
        joint: Whether several taxels share a force.
    """

    offset: FloatArray
    offset_error: FloatArray
    sign: FloatArray
    felt: FloatArray
    areas: FloatArray
    targets: FloatArray
    loaded: BoolArray
    joint: bool


def _felt_loads(log: CalibrationLog, skin: Skin, *, changes: bool) -> _FeltLoads:
    offset, noise, offset_error = (np.zeros((3, len(skin)))) if changes else _untouched(log)
    change = log.readings - offset
    sign = np.where(np.nansum(change * log.loads[:, None], axis=0) < 0, -1.0, 1.0)
    felt = np.maximum(np.nan_to_num(sign * change), 0.0)
    areas = np.ones(len(skin)) if log.pressure else skin.areas
    joint = not log.pressure and bool(((felt > 0).sum(axis=1) > 1).any())
    targets = np.where(felt > 0, log.loads[:, None], 0.0) / areas
    if joint:
        felt[felt < _NOISE * noise] = 0.0
        targets = _shares(log.loads, felt, areas)
    return _FeltLoads(offset, offset_error, sign, felt, areas, targets, _loaded(targets), joint)


def _fit_each(
    loads: FloatArray, felt: _FeltLoads, own: IntArray, folds: int, random: np.random.Generator, progress: Progress
) -> dict[int, _Fit]:
    """Fit the curves of taxels ``own`` (k,) one by one."""
    fits = {}
    for number, taxel in enumerate(own.tolist()):
        progress("Fitting curves", number / len(own))
        rows = felt.loaded[:, taxel]
        fold = _folds_of(loads[rows], folds, random)
        fits[taxel] = _fit(felt.felt[rows, taxel], felt.targets[rows, taxel], fold)
    return fits


def _common_fit(loads: _FeltLoads, own: IntArray, fits: Mapping[int, _Fit]) -> _Fit:
    """Fit one curve to the rows of all taxels ``own`` (k,), for taxels with too few rows."""
    x = np.concatenate([loads.felt[loads.loaded[:, one], one] for one in own])
    y = np.concatenate([fit.targets for fit in fits.values()])
    common = _fit(x, y, np.concatenate([fit.fold for fit in fits.values()]))
    return common._replace(uncertainty=np.nan)


class _Fit(NamedTuple):
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
        low, high = _on_curve(self.points, np.array([middle, middle + offset]))
        return float(np.hypot(self.uncertainty, (high - low) / low))

    @property
    def deviation(self) -> float:
        """Root mean square error of held-out rows [Pa]."""
        return float(np.sqrt(np.mean((self.held - self.targets) ** 2)))


def _untouched(log: CalibrationLog) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return median, standard deviation and standard error of the median (taxels,) of the readings at zero load.

    The median is NaN, and the others are 0, for a taxel without readings; also the others if it has only one.
    """
    free = np.abs(log.loads) <= _NO_LOAD * log.loads.max()
    there = ~np.isnan(log.readings)
    without = np.flatnonzero(there.any(axis=0) & ~there[free].any(axis=0))
    if len(without):
        found = f"taxel {without[0]}" + (f" and {len(without) - 1} more" if len(without) > 1 else "")
        remedy = "Log a row at load 0 for each taxel, or state that the readings are changes (--changes)"
        raise LiveError("no reading at zero load", value=found, remedy=remedy)
    offset = np.full(log.readings.shape[1], np.nan)
    noise = np.zeros(len(offset))
    for taxel in np.flatnonzero(there.any(axis=0)):
        values = log.readings[free & there[:, taxel], taxel]
        offset[taxel] = np.median(values)
        noise[taxel] = values.std(ddof=1) if len(values) > 1 else 0.0
    counts = np.maximum(there[free].sum(axis=0), 1)
    return offset, noise, _MEDIAN * noise / np.sqrt(counts)


def _shares(loads: FloatArray, pressures: FloatArray, areas: FloatArray) -> FloatArray:
    """Return pressures (m, taxels) in the proportions of the given ones whose forces sum up to the loads (m,)."""
    force = pressures @ areas
    return np.asarray(pressures * (np.divide(loads, force, out=np.zeros_like(force), where=force > 0))[:, None])


def _loaded(targets: FloatArray) -> BoolArray:
    """Return the rows (m, taxels) that count for each taxel: more than 1 % of its largest pressure."""
    return np.asarray((targets > _NO_LOAD * targets.max(axis=0)) & (targets > 0))


def _folds_of(loads: FloatArray, folds: int, random: np.random.Generator) -> IntArray:
    """Return the fold (m,) of each row, assigned in blocks of consecutive rows between changes of the load."""
    level = np.concatenate([[0], np.cumsum(np.diff(loads) != 0)])
    blocks = min(_BLOCKS_PER_FOLD * folds, int(level[-1]) + 1)
    block = level * blocks // (int(level[-1]) + 1)
    return np.asarray((random.permutation(blocks) % folds)[block], dtype=np.int64)


def _fit(x: FloatArray, y: FloatArray, fold: IntArray) -> _Fit:
    """Fit the best kind of curve to pressures ``y`` (m,) at changes ``x`` (m,)."""
    parts = np.unique(fold).tolist() if len(np.unique(fold)) > 1 else []
    kinds = list(CurveKind) if parts and len(np.unique(y)) >= _LEAST_LEVELS else [CurveKind.LINEAR]
    held = {kind: np.zeros_like(y) for kind in kinds}
    left_out: dict[CurveKind, list[FloatArray]] = {kind: [] for kind in kinds}
    for kind in kinds:
        for part in parts:
            out = fold == part
            left_out[kind].append(_CURVES[kind](x[~out], y[~out]))
            held[kind][out] = _on_curve(left_out[kind][-1], x[out])
    squares = {kind: np.array([np.mean((held[kind] - y)[fold == part] ** 2) for part in parts]) for kind in kinds}
    kind = _best_kind(squares)
    points = _CURVES[kind](x, y)
    means = {one: float(np.mean((held[one if one in held else kind] - y) ** 2)) for one in CurveKind}
    return _Fit(kind, points, fold, y, held[kind], means, _jackknife(points, left_out[kind]))


def _fit_jointly(
    loads: FloatArray, felt: FloatArray, areas: FloatArray, loaded: BoolArray, fold: IntArray, progress: Progress
) -> tuple[dict[int, _Fit], dict[CurveKind | None, float]]:
    """Fit curves of one kind for all taxels (columns of ``loaded`` with rows) to the loads on all of them together.

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
    targets = _shares(loads, _pressures(curves[kind], felt), areas)
    held = np.zeros_like(felt)
    for part, found in zip(parts, left_out[kind], strict=True):
        held[fold == part] = _pressures(found, felt[fold == part])
    fits = {}
    for taxel, points in curves[kind].items():
        rows = loaded[:, taxel]
        spread = _jackknife(points, [found[taxel] for found in left_out[kind]])
        fits[taxel] = _Fit(kind, points, fold[rows], targets[rows, taxel], held[rows, taxel], {}, spread)
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
    wanted = np.concatenate([loads, np.full(design.shape[1], pull)])
    factors = nnls(design, wanted - _FLATTEST * design.sum(axis=1))[0] + _FLATTEST
    ends = np.cumsum([part.shape[1] for part in parts])[:-1]
    slopes = zip(used.items(), np.split(gain * factors, ends), strict=True)
    return {taxel: np.array([one, np.append(0.0, np.cumsum(slope * np.diff(one)))]) for (taxel, one), slope in slopes}


def _pressures(curves: Mapping[int, FloatArray], felt: FloatArray) -> FloatArray:
    """Return the pressures (m, taxels) of changes (m, taxels); 0 for taxels without a curve."""
    found = np.zeros_like(felt)
    for taxel, points in curves.items():
        found[:, taxel] = _on_curve(points, felt[:, taxel])
    return found


def _jackknife(points: FloatArray, left_out: Sequence[FloatArray]) -> float:
    """Return the standard error at half of the range, as a share, by curves fitted without one fold each."""
    middle = points[0, -1:] / 2
    found = np.array([_on_curve(one, middle)[0] for one in left_out])
    if len(found) < 2:
        return np.nan
    return float(np.sqrt((len(found) - 1) * found.var()) / _on_curve(points, middle)[0])


def _best_kind(squares: Mapping[CurveKind, FloatArray]) -> CurveKind:
    """Return the simplest kind on which no other one improves clearly, by the mean squared error of each fold."""
    best = CurveKind.LINEAR
    for kind in list(squares)[1:]:
        gained = squares[best] - squares[kind]
        if gained.mean() > _CLEAR * gained.std(ddof=1) / np.sqrt(len(gained)):
            best = kind
    return best


def _errors(fits: Mapping[int, _Fit], areas: FloatArray) -> dict[CurveKind | None, float]:
    """Return the root mean square error of held-out loads by kind, None for the chosen kinds."""
    rows = sum(len(fit.targets) for fit in fits.values())
    found: dict[CurveKind | None, float] = {}
    for kind in (*CurveKind, None):
        squares = (len(fit.targets) * areas[taxel] ** 2 * fit.squares[kind or fit.kind] for taxel, fit in fits.items())
        found[kind] = float(np.sqrt(sum(squares) / rows))
    return found


def _on_curve(points: FloatArray, values: FloatArray) -> FloatArray:
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


def _piecewise(x: FloatArray, y: FloatArray) -> FloatArray:
    """Fit increasing line segments by non-negative least squares of their increments."""
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
    CurveKind.PIECEWISE: _piecewise,
}


def _rising(loads: FloatArray) -> BoolArray:
    """Return whether the load (m,) of each row rises, between reversals of more than a tenth of the largest load."""
    least = _TURN * loads.max()
    rising = np.ones(len(loads), dtype=bool)
    up = True
    extreme = start = 0
    for row, load in enumerate(loads.tolist()):
        if (load >= loads[extreme]) == up:
            extreme = row
        elif abs(load - loads[extreme]) > least:
            rising[start : extreme + 1] = up
            start = extreme + 1
            up = not up
            extreme = row
    rising[start:] = up
    return rising


def _branches(loads: FloatArray, x: FloatArray, fit: _Fit) -> tuple[float, float]:
    """Return the width between the curves of rising and falling load, and the gain of separate curves, as shares."""
    rising = _rising(loads)
    sides = [rising, ~rising]
    if min(side.sum() for side in sides) < LEAST_ROWS or len(np.unique(fit.fold)) < 2:
        return np.nan, np.nan
    up, down = (_piecewise(x[side], fit.targets[side]) for side in sides)
    at = np.linspace(0, min(np.quantile(x[side], _COMMON) for side in sides), 20)[1:]
    width = np.abs(_on_curve(up, at) - _on_curve(down, at)).max() / fit.targets.max()
    held = np.zeros_like(x)
    for part in np.unique(fit.fold):
        for side in sides:
            out = side & (fit.fold == part)
            kept = side & ~out
            held[out] = _on_curve(_piecewise(x[kept], fit.targets[kept]), x[out]) if kept.sum() > 1 else 0.0
    error = np.sqrt(np.mean((held - fit.targets) ** 2))
    return float(width), float(1 - error / max(fit.deviation, 1e-300))


def _calibration(fits: Sequence[_Fit], sign: FloatArray, offset: FloatArray) -> Calibration:
    deviation = np.array([fit.deviation for fit in fits])
    if all(fit.kind is CurveKind.LINEAR for fit in fits):
        gain = np.array([fit.points[1, 1] / fit.points[0, 1] for fit in fits])
        return Calibration(sign * gain, offset, deviation=deviation)
    return Calibration(sign, offset, curve=padded([fit.points for fit in fits]), deviation=deviation)
