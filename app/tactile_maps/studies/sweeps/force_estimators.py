"""How large is the error of the force from taxels below a cover, by estimator, depth of the taxels and noise?"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import nnls

from tactile_maps.contacts.force_estimation.deconvolution import (
    BlurMatrix,
    Solver,
    nonnegative_least_squares,
    share_inside,
    tikhonov,
)
from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.base.figures import Figure, Panel
from tactile_maps.studies.base.hypotheses import (
    Hypothesis,
    Interval,
    Judgement,
    Verdict,
    all_of,
    bootstrap_median,
    within,
)
from tactile_maps.studies.base.rows import Case, Row, distinct, number_or
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.testbeds.covered_lattice import AREA, PITCH, area_blur, contact_region, exact_readings

RADIUS = 8e-3
"""Radius of the contact [m]."""
DEPTHS = (0.25, 0.5, 1.0)
NOISES = (0.01, 0.02, 0.05)
SEEDS = 10
"""Depths over pitch, noise over the peak, and number of seeds."""
BETTER = 5.0
"""Expected ratio of the error of the whole map to that of the region."""
_BY_NOISE = 0.05
"""Noise at which this is expected."""


def _area_sum(depth: float, readings: FloatArray, noise: float) -> float:
    return float(AREA * readings[contact_region(readings, noise)[1]].sum())


def _regional(solver: Solver) -> Estimator:
    def estimate(depth: float, readings: FloatArray, noise: float) -> float:
        part = contact_region(readings, noise)[1]
        blur = BlurMatrix.of(area_blur(depth)[np.ix_(part, part)])
        areas = np.full(len(part), AREA)
        pressures = solver(blur, readings[part], noise)
        return float(areas @ readings[part]) / share_inside(blur, areas, readings[part], pressures)

    return estimate


def _whole_map(depth: float, readings: FloatArray, noise: float) -> float:
    return float(AREA * nnls(area_blur(depth), readings)[0].sum())


Estimator = Callable[[float, FloatArray, float], float]
WHOLE = "nnls-whole-map"
REGIONAL = "local-nnls"
ESTIMATORS: Mapping[str, Estimator] = {
    "area-sum": _area_sum,
    REGIONAL: _regional(nonnegative_least_squares),
    "tikhonov": _regional(tikhonov),
    WHOLE: _whole_map,
}
"""Force [N] from the depth of the taxels [m], readings [Pa] and their noise [Pa]; the last is a reference."""


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every estimator at every depth and noise."""
    return [
        {"estimator": estimator, "depth": depth, "noise": noise, "seed": number}
        for number in range(seed, seed + (1 if quick else SEEDS))
        for depth in (DEPTHS[1:2] if quick else DEPTHS)
        for noise in (NOISES[-1:] if quick else NOISES)
        for estimator in ESTIMATORS
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: mean and root mean square of the errors of the force over eight places."""
    random = np.random.default_rng(case["seed"])
    depth = case["depth"] * PITCH
    errors = []
    began = time.process_time()
    for exact in exact_readings(RADIUS, depth):
        noise = case["noise"] * float(exact.max())
        errors.append(ESTIMATORS[case["estimator"]](depth, exact + random.normal(0, noise, len(exact)), noise) - 1.0)
    off = np.array(errors)
    spent = 1e3 * (time.process_time() - began) / len(off)
    return [{"bias": float(off.mean()), "rms": float(np.sqrt(np.mean(off**2))), "cpu_ms": spent}]


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return the absolute bias against noise, a panel a depth."""
    panels = [
        Panel(
            f"taxels {depth} pitches deep",
            {
                str(estimator): [
                    (number_or(noise, math.nan), abs(_bias(rows, estimator, depth, noise).middle))
                    for noise in distinct(rows, "noise")
                ]
                for estimator in distinct(rows, "estimator")
            },
        )
        for depth in distinct(rows, "depth")
    ]
    return [Figure("Error of the force", "noise over the peak", "mean error over the force", panels)]


def _bias(rows: Sequence[Row], estimator: object, depth: object, noise: object) -> Interval:
    found = [
        number_or(row["bias"], math.inf)
        for row in rows
        if (row["estimator"], row["depth"], row["noise"]) == (estimator, depth, noise)
    ]
    return bootstrap_median(found)


def _judge(rows: Sequence[Row]) -> Judgement:
    """Ratio of the biases at the highest noise, by depth and seed."""
    relevant = [row for row in rows if row["noise"] == _BY_NOISE]
    ratios = {
        depth: _bias_ratios([row for row in relevant if row["depth"] == depth]) for depth in distinct(relevant, "depth")
    }
    parts = {depth: bootstrap_median(found) for depth, found in ratios.items() if found}
    figures = "; ".join(f"{depth} pitches deep: {ratio}" for depth, ratio in parts.items())
    verdict = all_of([within(ratio, BETTER, math.inf) for ratio in parts.values()])
    if len(parts) < len(ratios):
        verdict = all_of([verdict, Verdict.NOT_DECIDED])
    words = "bias over the whole map by that over the region and its ring"
    return Judgement(verdict, f"{words}: {figures or 'no rows'}", len(relevant))


def _bias_ratios(rows: Sequence[Row]) -> list[float]:
    """Ratios for the seeds that have both estimators."""
    by = {(row["estimator"], row["seed"]): abs(number_or(row["bias"], math.inf)) for row in rows}
    seeds = [seed for name, seed in by if name == WHOLE and (REGIONAL, seed) in by]
    return [by[WHOLE, seed] / max(by[REGIONAL, seed], 1e-9) for seed in seeds]


STUDY = Study(
    "force-estimators",
    "How large is the error of the force from taxels below a cover?",
    "A contact of 1 N and 8 mm radius (Hertz's ellipsoid of pressure) at eight places over 15 x 15 taxels 7 mm apart, "
    "each sensing a disc of 1.9 mm below an elastic half-space; readings are exact except for noise. The estimators "
    "read the strongest region above 3 sigma and a tenth of the peak with its ring; non-negative least squares over "
    "the whole map is the reference. Seeds differ in the noise alone, the same for all estimators.",
    cases,
    measure,
    figures,
    (
        Hypothesis(
            "H8",
            "The error of the force from the touched region and its ring is less than a fifth of the error of least "
            "squares over the whole map, at 5 % noise.",
            _judge,
        ),
    ),
)
