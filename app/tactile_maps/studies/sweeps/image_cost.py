"""What does accuracy cost in the tactile image, by interpolation and numbers of taxels and pixels?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator, griddata
from scipy.spatial import Delaunay

from tactile_maps.core.arrays import FloatArray
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.stages.image import KnownField, frame_trial, hertz
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.study.work_precision import ErrorKind, Setting, timed, trial_row, work_precision_figures
from tactile_maps.studies.testbeds.reference_bodies import SIDE, flat_map

GRIDDATA = "scipy griddata"
PREBUILT = "scipy LinearNDInterpolator"
METHODS = (*INTERPOLATIONS, GRIDDATA, PREBUILT)
_MARGIN_PITCHES = 1.5
"""Distance from the border within which errors are ignored [pitches]: the field is unknown beyond the last taxels."""

Render = Callable[[FloatArray], NDArray[np.floating]]


def smooth(points: FloatArray) -> FloatArray:
    """Return a field from 0 to 1 of waves about 60 mm long, at ``points`` (k, 2) [m]."""
    x, y = points.T / SIDE
    return np.asarray(0.5 + 0.5 * np.sin(10 * x + 1) * np.cos(9 * y))


def sharp(points: FloatArray) -> FloatArray:
    """Return the pressure of a ball over a contact of 25 mm radius, from 0 to 1."""
    return hertz(np.linalg.norm(points - 0.5 * SIDE, axis=1) / (0.25 * SIDE))


FIELDS: Mapping[str, Callable[[FloatArray], FloatArray]] = {"smooth": smooth, "sharp": sharp}
ERRORS = (
    ErrorKind("smooth", "Error of a smooth field", "% of its range", "Root mean square over the pixels.", 1e-5),
    ErrorKind("sharp", "Error of a sharp contact", "% of its peak", "Root mean square over the pixels.", 1e-5),
)


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every method with every number of taxels and pixels."""
    taxels, widths = ((100, 400), (64,)) if quick else ((100, 316, 1000, 3162, 10_000), (64, 128, 256, 512))
    repeats = 3 if quick else 15
    return [
        {"method": method, "taxels": n, "width": width, "repeats": repeats, "seed": seed}
        for width in widths
        for n in taxels
        for method in METHODS
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: the error of each field, and the times to build and for a frame [ms]."""
    map_ = flat_map(case["taxels"], seed=case["seed"])
    method = case["method"]
    width = case["width"]
    repeats = case["repeats"]
    centres = TactileImage(map_, width=width, interpolation="nearest").centres()
    built = timed(lambda: _renderer(method, map_, width, centres), repeats=min(repeats, 3), warm_up=True)
    within = np.abs(centres / SIDE - 0.5).max(axis=1) < 0.5 - _MARGIN_PITCHES / np.sqrt(len(map_.skin))
    pixels = np.flatnonzero(within)
    fields = {
        kind.key: KnownField(FIELDS[kind.key](map_.taxel_points), pixels, FIELDS[kind.key](centres[pixels]))
        for kind in ERRORS
    }
    trial = frame_trial(Setting("image", method, {"width": width}), built.result, fields, repeats=repeats)
    return [{**trial_row(trial), "build_ms": 0.0 if method == GRIDDATA else built.ms}]


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return error against the time of a frame and against the time to build; taxels increase along a curve."""
    times = {"ms": "{} against the time of a frame", "build_ms": "{} against the time to build"}
    return [
        figure
        for x, title in times.items()
        for figure in work_precision_figures(
            rows, ERRORS, panel=lambda row: f"{row['width']} × {row['width']} pixels", x=x, title=title
        )
    ]


def _renderer(method: str, map_: TactileMap, width: int, centres: FloatArray) -> Render:
    """Function from values at the taxels to an image (rows, columns) with pixels at ``centres``."""
    if method in INTERPOLATIONS:
        image = TactileImage(map_, width=width, interpolation=method)
        return lambda values: image.render(1e3 * values)
    points = map_.taxel_points
    if method == GRIDDATA:
        return lambda values: np.asarray(griddata(points, values, centres))
    triangles = Delaunay(points)
    return lambda values: np.asarray(LinearNDInterpolator(triangles, values)(centres))


STUDY = Study(
    "image-cost",
    "How large is the error of each interpolation, and what does a frame cost?",
    "Taxels at random in the cells of a grid on a flat square of 100 mm, whose map is the square itself, read a known "
    "field between 0 and 1: smooth waves, and the pressure under a ball, steep at its rim. The error is that of the "
    "pixels more than 1.5 pitches inside the border. Times are medians, after one warm-up run.",
    cases,
    measure,
    figures,
)
