"""``calibrate``: fit the curve of each taxel to a log of known loads, or its matrix to one of force vectors."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import LiveError, counted, names_text
from tactile_maps.core.progress import Progress, part_of_progress
from tactile_maps.live.calibration.calibration import Calibration, save_calibration
from tactile_maps.live.calibration.calibration_log import read_calibration_log
from tactile_maps.live.calibration.force_calibration import ForceCalibration, fit_force
from tactile_maps.live.calibration.force_curves import CurveKind
from tactile_maps.live.calibration.matrix_calibration import (
    MatrixCalibration,
    fit_matrices,
    has_force_vectors,
    read_force_vectors,
)
from tactile_maps.session.prepare import load_robot_and_skin
from tactile_maps.skin.model.skin import Skin

_PARTS = ("p", "t1", "t2")
"""Channels of a taxel with three axes, and the parts of its traction."""
_BRANCHES = 0.1
"""Gain of separate curves for rising and falling load from which hysteresis is reported as a warning."""


class _Fitted(NamedTuple):
    """A calibration and what is said about it.

    Attributes:
        calibration: The calibration.
        rows: Number of rows of the log.
        facts: Facts for a person.
        taxels: Rows of the report, one for each taxel.
        figures: Figures for a program.
        warnings: Warnings.
    """

    calibration: Calibration
    rows: int
    facts: dict[str, str]
    taxels: list[dict[str, Any]]
    figures: dict[str, Any]
    warnings: list[str]


def execute(arguments: argparse.Namespace) -> int:
    """Fit a calibration to a log, print how good it is, and save it."""
    progress = progress_line()
    scene = scene_from_arguments(arguments)
    # Before the skin, so that a missing log is reported at once.
    fit = _fit_matrices if has_force_vectors(arguments.input) else _fit_curves
    _, skin = load_robot_and_skin(scene, progress=part_of_progress(progress, 0.0, 0.5))
    try:
        fitted = fit(arguments, skin, part_of_progress(progress, 0.5, 1.0))
    except LiveError as error:
        raise error.at(file=arguments.input) from error
    progress("", 1.0)
    if arguments.output:
        save_calibration(fitted.calibration, arguments.output)
    for warning in fitted.warnings:
        print_warning(warning)
    if arguments.report:
        from tactile_maps.cli.shared.pages import write_fact_page

        title = f"Calibration with {arguments.input}"
        write_fact_page(arguments.report, title, fitted.facts, tables={"Taxels": fitted.taxels})
    result = {**fitted.figures, "rows": fitted.rows, "file": arguments.output}
    print_result(result, {**fitted.facts, "Written to": arguments.output}, as_json=arguments.json)
    return 0


def _fit_matrices(arguments: argparse.Namespace, skin: Skin, progress: Progress) -> _Fitted:
    """Fit matrices to a log of force vectors."""
    log = read_force_vectors(arguments.input, skin)
    found = fit_matrices(log, skin, folds=arguments.folds, seed=arguments.seed, changes=arguments.changes)
    figures = {
        "taxels": len(skin),
        "error": found.error.tolist(),
        "independent_error": found.independent_error.tolist(),
        "unit": "N",
        "largest": found.largest,
        "pooled": found.pooled.tolist(),
        "uncertainty": found.uncertainty.tolist(),
    }
    warnings = [_too_few_rows(found.pooled, skin, "matrix")] if len(found.pooled) else []
    rows = len(log.forces)
    return _Fitted(found.calibration, rows, _matrix_facts(found, rows), _matrix_rows(found, skin), figures, warnings)


def _fit_curves(arguments: argparse.Namespace, skin: Skin, progress: Progress) -> _Fitted:
    """Fit curves to a log of loads."""
    log = read_calibration_log(arguments.input, skin)
    found = fit_force(
        log, skin, folds=arguments.folds, seed=arguments.seed, changes=arguments.changes, progress=progress
    )
    rows = len(log.loads)
    return _Fitted(
        found.calibration, rows, _facts(found, rows), _rows(found, skin), _figures(found), _warnings(found, skin)
    )


def _matrix_facts(found: MatrixCalibration, rows: int) -> dict[str, str]:
    parts = ("normal", "t1", "t2")
    errors, independent = (
        ", ".join(f"{part} {error:.3g}" for part, error in zip(parts, values.tolist(), strict=True)) + " N"
        for values in (found.error, found.independent_error)
    )
    own = np.isfinite(found.uncertainty)
    return {
        "Rows": f"{rows}, up to {found.largest:.3g} N",
        "Matrices": f"{own.sum()} of single taxels",
        "Error": f"{errors} (root mean square of held-out rows)",
        "Independent": f"{independent} with a gain for each channel",
        "Uncertainty": f"{100 * np.median(found.uncertainty[own]):.2g} % of the matrix (standard error, median)",
    }


def _matrix_rows(found: MatrixCalibration, skin: Skin) -> list[dict[str, Any]]:
    """Rows of the report, one for each taxel with three axes."""
    deviation, matrix = found.calibration.deviation, found.calibration.matrix
    assert deviation is not None
    assert matrix is not None
    return [
        {
            "taxel": str(skin.taxel_name(taxel)) or str(taxel),
            "matrix": "common" if taxel in found.pooled else "own",
            "rows": int(found.rows[taxel]),
            "error_Pa": float(deviation[taxel]),
            "uncertainty_percent": 100 * float(found.uncertainty[taxel]),
            **{
                f"{to}_by_{channel}": float(matrix[taxel, row, column])
                for row, to in enumerate(_PARTS)
                for column, channel in enumerate(_PARTS)
            },
        }
        for taxel in np.flatnonzero(skin.three_axis).tolist()
    ]


def _too_few_rows(pooled: IntArray, skin: Skin, kind: str) -> str:
    text = names_text([skin.taxel_text(one) for one in pooled.tolist()])
    return f"too few rows of {counted(len(pooled), 'taxel')}, with the common {kind} of the others: {text}"


def _facts(found: ForceCalibration, rows: int) -> dict[str, str]:
    unit = "Pa" if found.pressure else "N"
    kinds = Counter(found.kinds)
    errors = ", ".join(f"{kind} {error:.3g}" for kind, error in found.errors.items())
    hysteresis = found.hysteresis[np.isfinite(found.hysteresis)]
    width = "not measured: the load does not rise and fall"
    if len(hysteresis):
        width = f"{100 * np.median(hysteresis):.1f} % of the largest pressure, at most {100 * hysteresis.max():.1f} %"
    return {
        "Rows": f"{rows}, up to {found.largest:.3g} {unit}",
        "Curves": ", ".join(f"{kinds[kind]} {kind}" for kind in CurveKind if kinds[kind]),
        "Error": f"{found.error:.3g} {unit} (root mean square of held-out rows)",
        "By kind": f"{errors} {unit}",
        "Uncertainty": f"{100 * np.nanmedian(found.uncertainty):.2g} % at half of the range (standard error, median)",
        "Hysteresis": width,
    }


def _warnings(found: ForceCalibration, skin: Skin) -> list[str]:
    warnings = []
    if len(found.pooled):
        warnings.append(_too_few_rows(found.pooled, skin, "curve"))
    count = int((found.branch_gain > _BRANCHES).sum())
    if count:
        share = 100 * np.nanmedian(found.branch_gain[found.branch_gain > _BRANCHES])
        warnings.append(
            f"hysteresis of {counted(count, 'taxel')}: separate curves for rising and falling load would "
            f"reduce the error by {share:.0f} %; the saved curve is between them"
        )
    return warnings


def _rows(found: ForceCalibration, skin: Skin) -> list[dict[str, Any]]:
    """Rows of the report, one for each taxel."""
    calibration = found.calibration
    assert calibration.deviation is not None
    return [
        {
            "taxel": str(skin.taxel_name(taxel)) or str(taxel),
            "curve": f"{kind}, common" if taxel in found.pooled else kind,
            "rows": int(found.rows[taxel]),
            "error_Pa": float(calibration.deviation[taxel]),
            "uncertainty_percent": 100 * float(found.uncertainty[taxel]),
            "hysteresis_percent": 100 * float(found.hysteresis[taxel]),
        }
        for taxel, kind in enumerate(found.kinds)
    ]


def _figures(found: ForceCalibration) -> dict[str, Any]:
    calibration = found.calibration
    assert calibration.deviation is not None
    return {
        "taxels": len(found.kinds),
        "curves": dict(Counter(found.kinds)),
        "error": found.error,
        "errors": dict(found.errors),
        "unit": "Pa" if found.pressure else "N",
        "largest": found.largest,
        "pooled": found.pooled.tolist(),
        "kinds": list(found.kinds),
        "deviation_Pa": calibration.deviation.tolist(),
        "uncertainty": found.uncertainty.tolist(),
        "hysteresis": found.hysteresis.tolist(),
        "branch_gain": found.branch_gain.tolist(),
    }
