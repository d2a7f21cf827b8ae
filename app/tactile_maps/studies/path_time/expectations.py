"""Theoretical expectations of the times on a contact path, judged for our own arm; see the theory of sampled loops."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from tactile_maps.studies.base.hypotheses import (
    Hypothesis,
    Interval,
    Judgement,
    Verdict,
    all_of,
    paired_difference,
    paired_ratio,
    within,
)
from tactile_maps.studies.base.rows import Row, distinct, number_or
from tactile_maps.studies.path_time.factors import Level
from tactile_maps.studies.path_time.path_time import NOMINAL, ROBOTS
from tactile_maps.studies.running.sequential import PairedEffect

SAME = 1.1
"""Ratio up to which times count as equal: the speed is found to 9 %."""
NO_SLOWER = (0.0, SAME)
LEAST_SEEDS = 3
"""Minimum number of seeds for an interval."""


def time_ratio(rows: Sequence[Row], factor: str, level: Level, jacobian: str = "smoothed") -> Interval | None:
    """Return the time at a level over that in nominal conditions, by seed; None if a seed is missing between others.

    The last seeds may be missing, because a settled level needs no more seeds and a time budget may end a run; fewer
    than ``LEAST_SEEDS`` seeds are not enough. Seeds that fail in nominal conditions have no ratio and are left out.
    """
    times = _paired_times(rows, factor, level, jacobian)
    return None if times is None else paired_ratio(*times)


def time_effect(rows: Sequence[Row], factor: str, level: Level, jacobian: str = "smoothed") -> Interval | None:
    """Return the time at a level minus that in nominal conditions [s], by seed, under the rules of ``time_ratio``."""
    times = _paired_times(rows, factor, level, jacobian)
    return None if times is None else paired_difference(*times)


def _paired_times(
    rows: Sequence[Row], factor: str, level: Level, jacobian: str
) -> tuple[list[float], list[float]] | None:
    """Times at a level and in nominal conditions [s], one a seed."""
    ours = [row for row in rows if row["robot"] == ROBOTS[0]]
    nominal = {row["seed"]: _seconds(row) for row in ours if _is(row, NOMINAL, "", "smoothed")}
    there = {row["seed"]: _seconds(row) for row in ours if _is(row, factor, level, jacobian)}
    seeds = [seed for seed, time in nominal.items() if math.isfinite(time)]
    known = [seed for seed in seeds if seed in there]
    if len(known) < LEAST_SEEDS or known != seeds[: len(known)]:
        return None
    return [there[seed] for seed in known], [nominal[seed] for seed in known]


def _is(row: Row, factor: str, level: Level, jacobian: str) -> bool:
    return (row["factor"], row["level"], row["jacobian"]) == (factor, level, jacobian)


def _seconds(row: Row) -> float:
    return number_or(row["seconds"], math.inf)


def _log_seconds(row: Row) -> float:
    return math.log(_seconds(row))


EFFECT = PairedEffect(
    ("robot", "factor", "level", "jacobian"),
    _log_seconds,
    {"factor": NOMINAL, "level": "", "jacobian": "smoothed"},
    band=math.log(SAME),
    words=lambda effect: f"{math.exp(effect):.3g} times nominal",
)
"""Decision of the seeds of a level: whether it takes as long as nominal conditions."""


class _Part(NamedTuple):
    """A comparison: factor, description, ratio of times, and whether the ratio is as expected."""

    factor: str
    words: str
    ratio: Interval | None
    verdict: Verdict


def _expect(
    rows: Sequence[Row], factor: str, level: Level, bounds: tuple[float, float], jacobian: str = "smoothed"
) -> _Part:
    ratio = time_ratio(rows, factor, level, jacobian)
    name = f"{level:g}" if isinstance(level, float) else level
    words = f"{factor} {name}" + (f", {jacobian}" if jacobian != "smoothed" else "")
    return _Part(factor, words, ratio, Verdict.NOT_DECIDED if ratio is None else within(ratio, *bounds))


def _fails(part: _Part) -> _Part:
    """The same comparison where most seeds are expected to fail."""
    if part.ratio is None:
        return part
    cannot = Verdict.HELD if math.isinf(part.ratio.low) else Verdict.NOT_DECIDED
    return part._replace(verdict=Verdict.NOT_HELD if math.isfinite(part.ratio.high) else cannot)


def _judged(rows: Sequence[Row], parts: Sequence[_Part]) -> Judgement:
    factors = {NOMINAL, *(part.factor for part in parts)}
    figures = "; ".join(f"{part.words}: {'too few seeds' if part.ratio is None else part.ratio}" for part in parts)
    count = sum(row["factor"] in factors and row["robot"] == ROBOTS[0] for row in rows)
    return Judgement(all_of([part.verdict for part in parts]), f"times the nominal time: {figures or 'no rows'}", count)


def _levels(rows: Sequence[Row], factor: str) -> list[Level]:
    levels = distinct([row for row in rows if row["factor"] == factor and row["robot"] == ROBOTS[0]], "level")
    return [level for level in levels if isinstance(level, str | float)]


def _no_slower(*factors: str) -> Callable[[Sequence[Row]], Judgement]:
    """Return a judge that expects nominal times at all levels of some factors."""

    def judge(rows: Sequence[Row]) -> Judgement:
        parts = [_expect(rows, factor, level, NO_SLOWER) for factor in factors for level in _levels(rows, factor)]
        return _judged(rows, parts)

    return judge


def _jacobians(rows: Sequence[Row]) -> Judgement:
    factor = "taxels misplaced"
    parts = [_expect(rows, factor, 2.0, (0.0, 3.0), "raw"), _fails(_expect(rows, factor, 3.0, (0.0, 3.0), "raw"))]
    return _judged(rows, [*parts, _expect(rows, factor, 7.0, (0.0, 3.0))])


def _learned(rows: Sequence[Row]) -> Judgement:
    factor = "map learned"
    levels = sorted(_levels(rows, factor), key=_is_biased)
    parts = [_expect(rows, factor, level, NO_SLOWER) for level in levels]
    return _judged(
        rows, [_fails(part) if _is_biased(level) else part for level, part in zip(levels, parts, strict=True)]
    )


def _is_biased(level: Level) -> bool:
    return "together" in str(level)


OF_REPRESENTATION = (
    Hypothesis(
        "H1",
        "Maps made by geometry differ in time only through their stretch: a controller that knows the stretch needs no "
        "more time on any of them.",
        _no_slower("map by geometry"),
    ),
    Hypothesis(
        "H2",
        "A Jacobian from single triangles fails where taxels are misplaced by 2 to 3 mm; one fitted over two rings "
        "works up to 7 mm, two to three times slower.",
        _jacobians,
    ),
    Hypothesis(
        "H6",
        "A constant error of place costs no time: its floor is the error itself.",
        _no_slower("sleeve shifted", "sleeve turned"),
    ),
    Hypothesis(
        "H7",
        "Maps learned from unbiased touch need as much time as those made by geometry; maps learned where two distant "
        "places are always touched together fail.",
        _learned,
    ),
)
OF_FORCE_FEEDBACK = (
    Hypothesis(
        "H6, of force",
        "A constant error of force costs no time: its floor is the error itself.",
        _no_slower("gain error"),
    ),
)
