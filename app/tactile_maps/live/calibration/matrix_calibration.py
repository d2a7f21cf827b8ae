"""Calibration of three-axis taxels: the matrix of each taxel from a log of known force vectors.

The log is a CSV table with a row for each measurement of one taxel: ``force_t1``, ``force_t2`` and ``force_n`` [N],
the force of the touching body along t1 and t2 of the taxel and against its normal (positive presses); ``p``, ``t1`` and
``t2``, the readings of its channels; and ``taxel`` (number) or ``id``. Rows are in the order of the measurement.

The readings of a taxel are fitted as offset + crosstalk @ force / area by least squares, since the forces are known and
the readings are noisy; the matrix is the inverse of the cross-talk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import Calibration
from tactile_maps.live.calibration.force_curves import folds_of
from tactile_maps.live.channels.matching import taxel_in_row
from tactile_maps.live.readings.tables import decimal_number, read_cells
from tactile_maps.skin.model.skin import Skin

FORCES = ("force_n", "force_t1", "force_t2")
"""Columns of the force [N], in the order of the channels."""
CHANNELS = ("p", "t1", "t2")
"""Columns of the readings."""
LEAST_ROWS = 12
"""Least number of loaded rows from which a taxel gets a matrix of its own: four for each number of a row."""
_NO_FORCE = 0.01
"""Forces below this share of the largest one count as none."""
_SMALLEST_SHARE = 0.02
"""Least singular value of the forces, as a share of the largest one, from which they determine a matrix."""
_DEAD = 1e-6
"""Least singular value of the cross-talk, as a share of the largest one, from which it can be inverted."""


@dataclass(frozen=True, eq=False)
class ForceVectorLog(ArrayFields):
    """Force vectors on single taxels and the readings under them, in the order of the measurement.

    Attributes:
        taxels: (m,) taxel of each row.
        forces: (m, 3) forces against the normal and along t1 and t2 [N].
        readings: (m, 3) readings of the channels.
    """

    taxels: IntArray
    forces: FloatArray
    readings: FloatArray


@dataclass(frozen=True, eq=False)
class MatrixCalibration(ArrayFields):
    """Matrices fitted to a log, and their quality.

    Attributes:
        calibration: The calibration; its deviations are those of the pressures of held-out rows.
        rows: (taxels,) number of rows under load.
        uncertainty: (taxels,) standard error of the matrix by the jackknife over the folds, as a share of its norm;
            NaN for pooled taxels.
        pooled: (k,) taxels with too few rows, which have the common matrix of all others.
        error: (3,) root mean square error of the held-out forces against the normal and along t1 and t2 [N].
        independent_error: (3,) the same if each channel only had a gain of its own.
        largest: Largest force of the log [N].
    """

    calibration: Calibration
    rows: IntArray
    uncertainty: FloatArray
    pooled: IntArray
    error: FloatArray
    independent_error: FloatArray
    largest: float


def has_force_vectors(path: str | Path) -> bool:
    """Return whether the CSV file at ``path`` has a column of this module's forces.

    Raises:
        LiveError: The file cannot be read.
    """
    (_, header), *_ = read_cells(Path(path))
    return any(word.lower() in FORCES for word in header)


def read_force_vectors(path: str | Path, skin: Skin) -> ForceVectorLog:
    """Read a log of force vectors from CSV; see this module for its columns.

    Raises:
        LiveError: The file cannot be read, a column is missing, or a row names an unknown taxel or one with one axis.
    """
    file = Path(path)
    (_, header), *rows = read_cells(file)
    columns = {word.lower(): at for at, word in enumerate(header)}
    missing = [word for word in (*FORCES, *CHANNELS) if word not in columns]
    if missing or not {"taxel", "id"} & columns.keys():
        remedy = f"Columns are {', '.join((*FORCES, *CHANNELS))}, and taxel or id"
        value = ", ".join(missing) or "taxel or id"
        raise LiveError(
            "columns of the force vectors are missing", file=file, place="header", value=value, remedy=remedy
        )
    taxels = np.array([_taxel(cells, columns, skin, file, line) for line, cells in rows], dtype=np.int64)

    def numbers(names: Sequence[str]) -> FloatArray:
        return np.array(
            [[decimal_number(cells[columns[one]], file, line, one) for one in names] for line, cells in rows]
        ).reshape(-1, 3)

    log = ForceVectorLog(taxels, numbers(FORCES), numbers(CHANNELS))
    if not (np.isfinite(log.forces).all() and np.isfinite(log.readings).all()):
        row = int(np.isfinite(np.hstack([log.forces, log.readings])).all(axis=1).argmin())
        raise LiveError("a cell is empty or not finite", file=file, place=f"line {rows[row][0]}")
    return log


def _taxel(cells: Sequence[str], columns: dict[str, int], skin: Skin, file: Path, line: int) -> int:
    taxel = taxel_in_row(cells, columns, skin, file, line)
    if not skin.three_axis[taxel]:
        remedy = "Log it by force and reading, or state three axes in the skin"
        raise LiveError(
            "a taxel with one axis has no matrix", file=file, place=f"line {line}", value=taxel, remedy=remedy
        )
    return taxel


def fit_matrices(
    log: ForceVectorLog, skin: Skin, *, folds: int = 5, seed: int = 0, changes: bool = False
) -> MatrixCalibration:
    """Fit the matrix of each three-axis taxel to a log of known force vectors.

    The folds of the cross-validation consist of blocks of consecutive rows of a taxel.

    Args:
        log: The log.
        skin: The skin; the areas of its taxels [m²] relate forces to tractions.
        folds: Number of folds, 2 to 20.
        seed: Seed of the assignment of blocks to folds.
        changes: Whether the readings are changes from the untouched skin, so that their offset is 0.

    Raises:
        LiveError: The number of folds is out of range, no taxel has enough rows, the forces on a taxel do not have
            three independent directions, or its channels do not respond to them independently.

    Cost: 0.2 ms for each taxel and fold.
    """
    strength = np.linalg.norm(log.forces, axis=1)
    loaded = strength > _NO_FORCE * strength.max(initial=0.0)
    rows = np.bincount(log.taxels[loaded], minlength=len(skin))
    own = np.flatnonzero(rows >= LEAST_ROWS)
    if not len(own):
        remedy = f"Log at least {LEAST_ROWS} rows of one taxel under load"
        raise LiveError("no taxel has enough rows", value=f"at most {rows.max(initial=0)}", remedy=remedy)
    random = np.random.default_rng(seed)
    fits = {}
    for taxel in own.tolist():
        part = log.taxels == taxel
        fold = folds_of(np.arange(part.sum()), folds, random)
        fits[taxel] = _fit(log.readings[part], log.forces[part] / skin.areas[taxel], fold, taxel, changes=changes)
    matrices = np.tile(np.mean([fit.matrix for fit in fits.values()], axis=0), (len(skin), 1, 1))
    matrices[~skin.three_axis] = np.eye(3)
    offset = np.full(len(skin), np.median([fit.offset[0] for fit in fits.values()]))
    uncertainty = np.full(len(skin), np.nan)
    deviation = np.full(len(skin), np.nan)
    for taxel, fit in fits.items():
        matrices[taxel] = fit.matrix
        offset[taxel] = fit.offset[0]
        uncertainty[taxel] = fit.uncertainty
        deviation[taxel] = np.sqrt(np.mean(fit.errors[0, :, 0] ** 2))
    errors = np.concatenate([skin.areas[taxel] * fit.errors for taxel, fit in fits.items()], axis=1)
    total, independent = np.sqrt((errors**2).mean(axis=1))
    pooled = np.setdiff1d(np.flatnonzero(skin.three_axis), own)
    calibration = Calibration(np.ones(len(skin)), offset, deviation=deviation, matrix=matrices)
    return MatrixCalibration(calibration, rows, uncertainty, pooled, total, independent, float(strength.max()))


class _Fit(NamedTuple):
    """Matrix of one taxel.

    Attributes:
        matrix: (3, 3) from changes of the channels to tractions [Pa].
        offset: (3,) readings of the untouched taxel.
        errors: (2, m, 3) errors of held-out rows [Pa], with the matrix and with a gain for each channel.
        uncertainty: Standard error of the matrix as a share of its norm.
    """

    matrix: FloatArray
    offset: FloatArray
    errors: FloatArray
    uncertainty: float


def _fit(readings: FloatArray, traction: FloatArray, fold: IntArray, taxel: int, *, changes: bool) -> _Fit:
    """Fit the matrix of a taxel to readings (m, 3) under tractions (m, 3) [Pa], with cross-validation."""
    parts = np.unique(fold).tolist()
    for kept in (fold >= 0, *(fold != part for part in parts)):
        _check_directions(traction[kept], taxel)
    matrix, offset = _solve(readings, traction, taxel, changes=changes)
    errors = np.zeros((2, *readings.shape))
    matrices = []
    for part in parts:
        out = fold == part
        without, start = _solve(readings[~out], traction[~out], taxel, changes=changes)
        gains, starts = _gains(readings[~out], traction[~out], changes=changes)
        errors[0, out] = (readings[out] - start) @ without.T - traction[out]
        errors[1, out] = (readings[out] - starts) * gains - traction[out]
        matrices.append(without)
    spread = np.sqrt((len(parts) - 1) * np.var(matrices, axis=0).sum())
    return _Fit(matrix, offset, errors, float(spread / np.linalg.norm(matrix)))


def _solve(readings: FloatArray, traction: FloatArray, taxel: int, *, changes: bool) -> tuple[FloatArray, FloatArray]:
    """Return the matrix (3, 3) [Pa] and the offset (3,) of readings (m, 3) under tractions (m, 3) [Pa]."""
    design = traction if changes else np.column_stack([traction, np.ones(len(traction))])
    found = np.linalg.lstsq(design, readings)[0]
    crosstalk = found[:3].T
    values = np.linalg.svd(crosstalk, compute_uv=False)
    if not values[2] > _DEAD * values[0]:
        remedy = "Check its channels: one does not respond, or two are the same"
        raise LiveError("the channels do not determine a force", value=f"taxel {taxel}", remedy=remedy)
    return np.linalg.inv(crosstalk), np.zeros(3) if changes else found[3]


def _gains(readings: FloatArray, traction: FloatArray, *, changes: bool) -> tuple[FloatArray, FloatArray]:
    """Return gains (3,) [Pa per unit] and offsets (3,) if each channel only follows its own traction."""
    middle = np.zeros((2, 3)) if changes else np.stack([readings.mean(axis=0), traction.mean(axis=0)])
    reading = readings - middle[0]
    load = traction - middle[1]
    gains = (load**2).sum(axis=0) / (load * reading).sum(axis=0)
    return gains, middle[0] - middle[1] / gains


def _check_directions(traction: FloatArray, taxel: int) -> None:
    values = np.linalg.svd(traction, compute_uv=False)
    if len(values) < 3 or not values[2] > _SMALLEST_SHARE * values[0]:
        remedy = "Press it, and push it along t1 and along t2, independently of each other"
        raise LiveError("the forces do not determine a matrix", value=f"taxel {taxel}", remedy=remedy)
