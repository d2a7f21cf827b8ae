"""How the answers of ``control-cost`` are drawn: seconds against each factor, with what theory says beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from app.experiments.bars import Bars
from app.experiments.control_factors import NOMINAL
from app.experiments.plot import Figure, Panel
from app.experiments.sweep import Row

BOUND = "theory, speed not told"
_DRAWS, _SURE = 2000, (2.5, 97.5)
_ALONG = {
    "tolerance": (
        "Time against the tolerance on the body",
        "mm, 95 % of the errors within",
        "Theory's l T / (L* e) counts the skin's readings alone. Here the posture loop lags by 50 ms besides, which "
        "the path's speed, told ahead, does not make good: so it takes several times longer, and less so for more "
        "tolerance, until it is the force that limits.",
    ),
    "rate": (
        "Time against the rate at which the skin is read",
        "readings a second",
        "Where readings are slow it takes about as long as theory says; where they are fast, the posture loop's lag of "
        "50 ms, which theory's ideal servo has not, sets the time, and more readings buy nothing.",
    ),
    "delay": (
        "Time against the delay of the readings",
        "readings late, and a half",
        "Readings that come at once are waited for less long than the posture loop's lag of 50 ms, which theory's "
        "ideal servo has not. With more delay theory's wait is the longer one; what is then faster than theory is so "
        "since laws are told the path's speed.",
    ),
    "noise": (
        "Time against noise on every taxel",
        "Pa (none at 10)",
        "Theory has no time for noise, only ripple: it moves the centre of pressure and the force that is read, and "
        "takes from the tolerance what is then missing for speed.",
    ),
    "misplaced": (
        "Time against the error of the calibration",
        "mm along each axis (none at 0.25)",
        "Theory has the map's Jacobian alone in mind, which single triangles turn over from 2 mm on and two rings of "
        "taxels survive. The normal departs sooner: along a wrong one a push slides and a slide presses, so that the "
        "force limits the speed before the Jacobian does; two rings keep some degrees of the error where a triangle "
        "keeps tens.",
    ),
}
_NOTHING = {"noise": 10.0, "misplaced": 0.25}
_NAMED = {"map": "how the map is made", "estimator": "how readings become a force"}


def figures(rows: Sequence[Row]) -> list[Figure | Bars]:
    """Seconds against each factor, a panel a robot; bars where levels are names."""
    made: list[Figure | Bars] = []
    for factor, (title, x, note) in _ALONG.items():
        of = _with_nominal(rows, factor)
        if of:
            made.append(Figure(title, x, "seconds for the path", _panels(of, factor), note=note))
    for factor, words in _NAMED.items():
        of = _with_nominal(rows, factor)
        made += [
            Bars(
                f"Time by {words}, {robot}",
                "seconds for the path, median over seeds",
                {f"{row_law}, {level}": middle for (row_law, level), middle in _by_name(of, robot).items()},
                note=_impossible(of, robot),
            )
            for robot in _each(of, "robot")
        ]
    return made


def _with_nominal(rows: Sequence[Row], factor: str) -> list[Row]:
    """The rows of a factor, levels rising, with those of the nominal as one of its levels."""
    of = [row for row in rows if row["factor"] == factor and row["level"] != NOMINAL[factor]]
    # What is misplaced by nothing is so by taxel and by module; the raw Jacobian's nominal stands with the misplaced.
    nominal = [row for row in rows if row["level"] in ("", 0.0) and row["factor"] in ("nominal", "misplaced")]
    for by, jacobian in dict.fromkeys((row["by"], row["jacobian"]) for row in of):
        same = {"factor": factor, "level": NOMINAL[factor], "by": by}
        of += [{**row, **same} for row in nominal if row["jacobian"] == jacobian]
    return of if isinstance(NOMINAL[factor], str) else sorted(of, key=lambda row: _number(row["level"]))


def _panels(rows: Sequence[Row], factor: str) -> list[Panel]:
    panels = []
    for kind in dict.fromkeys((row["robot"], row["by"], row["jacobian"]) for row in rows):
        robot, by, jacobian = kind
        of = [row for row in rows if (row["robot"], row["by"], row["jacobian"]) == kind]
        said = f"{robot}, by {by}, {jacobian} Jacobian" if factor == "misplaced" else str(robot)
        panels.append(_panel(said, of, factor))
    return panels


def _panel(title: str, rows: Sequence[Row], factor: str) -> Panel:
    curves, spreads = {}, {}
    for law in _each(rows, "law"):
        of = [row for row in rows if row["law"] == law]
        found = [(_place(factor, level), *sure(_seconds(of, level))) for level in _each(of, "level")]
        curves[str(law)] = [(x, middle) for x, middle, _, _ in found]
        spreads[str(law)] = [(x, low, high) for x, _, low, high in found]
    if factor in ("tolerance", "rate", "delay"):
        curves[BOUND] = [(_place(factor, level), _bound(rows, level)) for level in _each(rows, "level")]
    return Panel(title, curves, spreads)


def sure(seconds: Sequence[float]) -> tuple[float, float, float]:
    """Median over seeds, and its 95 % bootstrap interval; infinite where most of them cannot.

    Args:
        seconds: One a seed; inf where it cannot.
    """
    values = np.asarray(seconds, dtype=np.float64)
    drawn = np.sort(np.random.default_rng(0).choice(values, (_DRAWS, len(values))), axis=1)
    # Percentiles between inf and a number are no number: the nearest value counts.
    low, high = np.percentile(drawn[:, len(values) // 2], _SURE, method="nearest")
    return float(np.sort(values)[len(values) // 2]), float(low), float(high)


def _seconds(rows: Sequence[Row], level: object) -> list[float]:
    return [_number(row["seconds"]) for row in rows if row["level"] == level]


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else math.inf


def _bound(rows: Sequence[Row], level: object) -> float:
    return next(_number(row["bound_s"]) for row in rows if row["level"] == level)


def _place(factor: str, level: object) -> float:
    """Where a level is drawn: a logarithm knows no zero."""
    value = _number(level)
    return value + 0.5 if factor == "delay" else max(value, _NOTHING.get(factor, value))


def _each(rows: Sequence[Row], key: str) -> list[str | float | int | bool | None]:
    return list(dict.fromkeys(row[key] for row in rows))


def _by_name(rows: Sequence[Row], robot: object) -> dict[tuple[str, str], float]:
    """The median over seeds by law and level."""
    of = [row for row in rows if row["robot"] == robot]
    kinds = dict.fromkeys((str(row["law"]), str(row["level"])) for row in of)
    return {
        (law, level): sure([_number(row["seconds"]) for row in of if (row["law"], row["level"]) == (law, level)])[0]
        for law, level in kinds
    }


def _impossible(rows: Sequence[Row], robot: object) -> str:
    """What most seeds cannot do at any speed."""
    names = [f"{law}, {level}" for (law, level), middle in _by_name(rows, robot).items() if math.isinf(middle)]
    return f"Not possible at any speed: {'; '.join(names)}." if names else ""
