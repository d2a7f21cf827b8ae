"""Force calibration: the curve of each taxel from a log of known loads.

The pressure of a taxel is fitted to the change of its reading, the direction in which it is used (``force_curves``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError, names_text
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.live.calibration.calibration import Calibration, padded
from tactile_maps.live.calibration.calibration_log import CalibrationLog
from tactile_maps.live.calibration.force_curves import (
    CurveFit,
    CurveKind,
    fit_curve,
    fit_jointly,
    folds_of,
    force_shares,
    on_curve,
    piecewise,
)
from tactile_maps.skin.model.skin import Skin

LEAST_ROWS = 8
"""Least number of loaded rows from which a taxel gets a curve of its own."""
_NO_LOAD = 0.01
"""Loads below this share of the largest one count as none."""
_TURN = 0.1
"""Change of the load that counts as a reversal, as a share of the largest load."""
_MEDIAN = 1.2533
"""Standard error of a median of normal values, relative to that of the mean."""
_COMMON = 0.9
"""Quantile of the readings up to which rising and falling load are compared: near a reversal they meet."""
_NOISE = 3.0
"""Readings that share a force must exceed this many standard deviations of those at zero load."""


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
        LiveError: Invalid ``folds``, or a log of another skin, without a row at zero load, or with too few rows.

    Cost: 15 ms for each taxel with 60 rows; 2 s for 60 taxels that share 600 forces.
    """
    if log.readings.shape[1] != len(skin):
        raise LiveError("the log is of another skin", value=f"{log.readings.shape[1]} taxels for {len(skin)}")
    loads = _felt_loads(log, skin, changes=changes)
    own = _with_enough_rows(loads.loaded)
    random = np.random.default_rng(seed)
    if loads.joint:
        fold = folds_of(log.loads, folds, random)
        loaded = loads.loaded & np.isin(np.arange(len(skin)), own)
        fits, errors = fit_jointly(log.loads, loads.felt, loads.areas, loaded, fold, progress)
    else:
        fits = _fit_each(log.loads, loads, own, folds, random, progress)
        errors = _errors(fits, loads.areas)
    hysteresis, branch_gain = _branches(log.loads, loads, fits)
    pooled = np.setdiff1d(np.arange(len(skin)), own)
    if len(pooled):
        fits |= dict.fromkeys(pooled.tolist(), _common_fit(loads, own, fits))
        loads = _with_common_offset(loads, own, pooled)
    ordered = [fits[taxel] for taxel in range(len(skin))]
    return ForceCalibration(
        _calibration(ordered, loads.sign, loads.offset),
        tuple(fit.kind for fit in ordered),
        loads.loaded.sum(axis=0),
        np.array([fit.uncertainty_with(one) for fit, one in zip(ordered, loads.offset_error.tolist(), strict=True)]),
        hysteresis,
        branch_gain,
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
        targets = force_shares(log.loads, felt, areas)
    return _FeltLoads(offset, offset_error, sign, felt, areas, targets, _loaded(targets), joint)


def _with_enough_rows(loaded: BoolArray) -> IntArray:
    """Return the taxels (k,) with enough rows under load for a curve of their own; raises LiveError without any."""
    rows = loaded.sum(axis=0)
    own = np.flatnonzero(rows >= LEAST_ROWS)
    if not len(own):
        remedy = f"Log at least {LEAST_ROWS} rows of one taxel under load"
        raise LiveError("no taxel has enough rows", value=f"at most {rows.max()}", remedy=remedy)
    return own


def _with_common_offset(loads: _FeltLoads, own: IntArray, pooled: IntArray) -> _FeltLoads:
    """Return the loads with the direction of most taxels ``own`` (k,), and their offset where none was measured."""
    sign = loads.sign.copy()
    sign[pooled] = 1.0 if sign[own].sum() >= 0 else -1.0
    offset = np.where(np.isfinite(loads.offset), loads.offset, np.median(loads.offset[own]))
    return loads._replace(sign=sign, offset=offset)


def _fit_each(
    loads: FloatArray, felt: _FeltLoads, own: IntArray, folds: int, random: np.random.Generator, progress: Progress
) -> dict[int, CurveFit]:
    """Fit the curves of taxels ``own`` (k,) one by one."""
    fits = {}
    for number, taxel in enumerate(own.tolist()):
        progress("Fitting curves", number / len(own))
        rows = felt.loaded[:, taxel]
        fold = folds_of(loads[rows], folds, random)
        fits[taxel] = fit_curve(felt.felt[rows, taxel], felt.targets[rows, taxel], fold)
    return fits


def _common_fit(loads: _FeltLoads, own: IntArray, fits: Mapping[int, CurveFit]) -> CurveFit:
    """Fit one curve to the rows of all taxels ``own`` (k,), for taxels with too few rows."""
    x = np.concatenate([loads.felt[loads.loaded[:, one], one] for one in own])
    y = np.concatenate([fit.targets for fit in fits.values()])
    common = fit_curve(x, y, np.concatenate([fit.fold for fit in fits.values()]))
    return common._replace(uncertainty=np.nan)


def _untouched(log: CalibrationLog) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return median, standard deviation and standard error of the median (taxels,) of the readings at zero load.

    The median is NaN, and the others are 0, for a taxel without readings; also the others if it has only one.
    """
    free = np.abs(log.loads) <= _NO_LOAD * log.loads.max()
    there = ~np.isnan(log.readings)
    without = np.flatnonzero(there.any(axis=0) & ~there[free].any(axis=0))
    if len(without):
        found = f"taxel {names_text(list(map(str, without)), 1)}"
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


def _loaded(targets: FloatArray) -> BoolArray:
    """Return the rows (m, taxels) that count for each taxel: more than 1 % of its largest pressure."""
    return np.asarray((targets > _NO_LOAD * targets.max(axis=0)) & (targets > 0))


def _errors(fits: Mapping[int, CurveFit], areas: FloatArray) -> dict[CurveKind | None, float]:
    """Return the root mean square error of held-out loads by kind, None for the chosen kinds."""
    rows = sum(len(fit.targets) for fit in fits.values())
    found: dict[CurveKind | None, float] = {}
    for kind in (*CurveKind, None):
        squares = (len(fit.targets) * areas[taxel] ** 2 * fit.squares[kind or fit.kind] for taxel, fit in fits.items())
        found[kind] = float(np.sqrt(sum(squares) / rows))
    return found


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


def _branches(forces: FloatArray, loads: _FeltLoads, fits: Mapping[int, CurveFit]) -> tuple[FloatArray, FloatArray]:
    """Return the results of ``_branches_of`` (taxels,) each, NaN for taxels without a fit."""
    found = np.full((2, loads.felt.shape[1]), np.nan)
    for one, fit in fits.items():
        loaded = loads.loaded[:, one]
        found[:, one] = _branches_of(forces[loaded], loads.felt[loaded, one], fit)
    return found[0], found[1]


def _branches_of(loads: FloatArray, x: FloatArray, fit: CurveFit) -> tuple[float, float]:
    """Return the width between the curves of rising and falling load, and the gain of separate curves, as shares."""
    rising = _rising(loads)
    sides = [rising, ~rising]
    if min(side.sum() for side in sides) < LEAST_ROWS or len(np.unique(fit.fold)) < 2:
        return np.nan, np.nan
    up, down = (piecewise(x[side], fit.targets[side]) for side in sides)
    at = np.linspace(0, min(np.quantile(x[side], _COMMON) for side in sides), 20)[1:]
    width = np.abs(on_curve(up, at) - on_curve(down, at)).max() / fit.targets.max()
    held = np.zeros_like(x)
    for part in np.unique(fit.fold):
        for side in sides:
            out = side & (fit.fold == part)
            kept = side & ~out
            held[out] = on_curve(piecewise(x[kept], fit.targets[kept]), x[out]) if kept.sum() > 1 else 0.0
    error = np.sqrt(np.mean((held - fit.targets) ** 2))
    return float(width), float(1 - error / max(fit.deviation, 1e-300))


def _calibration(fits: Sequence[CurveFit], sign: FloatArray, offset: FloatArray) -> Calibration:
    deviation = np.array([fit.deviation for fit in fits])
    if all(fit.kind is CurveKind.LINEAR for fit in fits):
        gain = np.array([fit.points[1, 1] / fit.points[0, 1] for fit in fits])
        return Calibration(sign * gain, offset, deviation=deviation)
    return Calibration(sign, offset, curve=padded([fit.points for fit in fits]), deviation=deviation)
