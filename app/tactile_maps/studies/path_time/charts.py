"""Figures of path time: seconds against each factor, a panel for each robot; bars where levels are names."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tactile_maps.studies.base.figures import BarChart, Figure, Panel
from tactile_maps.studies.base.hypotheses import Interval, bootstrap_median
from tactile_maps.studies.base.rows import Cell, Row, distinct, number_or
from tactile_maps.studies.path_time.factors import Factor
from tactile_maps.studies.path_time.path_time import NOMINAL

BOUND = "theory, without feed-forward of the speed"
_BOUNDED = ("tolerance", "rate", "delay")
"""Factors with a theoretical time."""


def factor_figures(factors: Sequence[Factor], rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Return the figures of each factor that has rows."""
    made: list[Figure | BarChart] = []
    for factor in factors:
        own = rows_with_nominal(rows, factor)
        if any(row["factor"] == factor.name for row in rows):
            made += _bars(factor, own) if factor.named else [_curves(factor, own)]
    return made


def rows_with_nominal(rows: Sequence[Row], factor: Factor) -> list[Row]:
    """Return the rows of a factor by rising level, including those in nominal conditions as one of its levels."""
    own = [row for row in rows if row["factor"] == factor.name]
    robots = {row["robot"] for row in own}
    if factor.nominal is not None:
        own += [
            {**row, "factor": factor.name, "level": factor.nominal}
            for row in rows
            if row["factor"] == NOMINAL and row["jacobian"] in factor.jacobians and row["robot"] in robots
        ]
    return own if factor.named else sorted(own, key=lambda row: number_or(row["level"], 0.0))


def seconds_of(rows: Sequence[Row], level: object) -> list[float]:
    """Return the times of a level, one a seed [s]; inf for a failure."""
    return [number_or(row["seconds"], math.inf) for row in rows if row["level"] == level]


def _curves(factor: Factor, rows: Sequence[Row]) -> Figure:
    panels = [
        _panel(factor, robot, [row for row in rows if row["robot"] == robot]) for robot in distinct(rows, "robot")
    ]
    title = f"Time against {factor.name}"
    return Figure(title, factor.axis, "seconds for the path", panels, note=factor.note)


def _panel(factor: Factor, robot: Cell, rows: Sequence[Row]) -> Panel:
    curves = {}
    intervals = {}
    for jacobian in distinct(rows, "jacobian"):
        own = [row for row in rows if row["jacobian"] == jacobian]
        found = [
            (_position(factor, level), bootstrap_median(seconds_of(own, level))) for level in distinct(own, "level")
        ]
        name = f"{jacobian} Jacobian" if len(factor.jacobians) > 1 else "measured"
        curves[name] = [(x, interval.middle) for x, interval in found]
        intervals[name] = [(x, interval.low, interval.high) for x, interval in found]
    if factor.name in _BOUNDED:
        each = [next(row for row in rows if row["level"] == level) for level in distinct(rows, "level")]
        curves[BOUND] = [(_position(factor, row["level"]), number_or(row["bound_s"], math.inf)) for row in each]
    return Panel(str(robot), curves, intervals)


def _position(factor: Factor, level: Cell) -> float:
    return factor.position(number_or(level, 0.0))


def _bars(factor: Factor, rows: Sequence[Row]) -> list[BarChart]:
    return [
        BarChart(
            f"Time by {factor.name}, {robot}",
            "seconds for the path, median over seeds and its 95 % interval",
            {name: interval.middle for name, interval in times.items()},
            _impossible(times),
            {name: (interval.low, interval.high) for name, interval in times.items()},
        )
        for robot in distinct(rows, "robot")
        for times in [by_name(factor, [row for row in rows if row["robot"] == robot])]
    ]


def by_name(factor: Factor, rows: Sequence[Row]) -> dict[str, Interval]:
    """Return the median over seeds by level and, where there are several, Jacobian."""
    kinds = dict.fromkeys((row["level"], row["jacobian"]) for row in rows)
    return {
        f"{level}, {jacobian}" if len(factor.jacobians) > 1 else str(level): bootstrap_median(
            seconds_of([row for row in rows if row["jacobian"] == jacobian], level)
        )
        for level, jacobian in kinds
    }


def _impossible(times: dict[str, Interval]) -> str:
    """Names of the levels at which most seeds fail at any speed."""
    names = [name for name, interval in times.items() if math.isinf(interval.middle)]
    return f"Not possible at any speed: {'; '.join(names)}." if names else ""
