"""The figures of a law's trace: what a table of several laws compares."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.arrays import BoolArray, FloatArray
from app.session.law_trace import NUMBERS, LawTrace

_UNITS = ("s", "N", "N", "m", "m", "rad_s", "J", "")
"""Of ``NUMBERS``, as a file's columns name them."""


@dataclass(frozen=True)
class LawFigures:
    """How well a law did. NaN where there was nothing to measure, as the error of a task without a place.

    Attributes:
        map_rms_mm: Root mean square of the error on the map, while in contact [mm].
        map_p95_mm: 95 % of the time it was below [mm].
        body_rms_mm: The same on the body.
        body_p95_mm: The same on the body.
        force_rms_N: Root mean square of the force's departure from its goal, while one was wanted [N].
        force_std_N: How much it departed from its own mean departure: ripple without the lasting error [N].
        force_max_N: Greatest force of a contact [N].
        lost: Share of the time in which a finger was there and, after the first contact, none was felt.
        joint_speed_max: Of the fastest joint [rad/s].
        energy_J: Net energy given to contacts at its greatest [J].
        limited: Share of the time in which something bounded the law.
        limit: What did most often, in words; empty where nothing did.
        control_ms: Median wall time of the law [ms].
        control_p95_ms: 95 % of the ticks took less [ms].
        seconds: How long it ran [s].
    """

    map_rms_mm: float
    map_p95_mm: float
    body_rms_mm: float
    body_p95_mm: float
    force_rms_N: float
    force_std_N: float
    force_max_N: float
    lost: float
    joint_speed_max: float
    energy_J: float
    limited: float
    limit: str
    control_ms: float
    control_p95_ms: float
    seconds: float


def law_figures(trace: LawTrace) -> LawFigures:
    """Measure a trace; one without a tick has nothing to measure."""
    felt = trace.force > 0
    departure = (trace.force - trace.force_goal)[np.isfinite(trace.force_goal)]
    said = Counter(limit_name(limit) for limits in trace.limits for limit in limits)
    return LawFigures(
        map_rms_mm=1e3 * _rms(trace.map_error),
        map_p95_mm=1e3 * _p95(trace.map_error),
        body_rms_mm=1e3 * _rms(trace.body_error),
        body_p95_mm=1e3 * _p95(trace.body_error),
        force_rms_N=_rms(departure),
        force_std_N=float(departure.std()) if departure.size else np.nan,
        force_max_N=_highest(trace.force),
        lost=_share(~felt[trace.touched & np.logical_or.accumulate(felt)]),
        joint_speed_max=_highest(trace.joint_speed),
        energy_J=_highest(trace.energy),
        limited=_share(np.array([bool(limits) for limits in trace.limits], dtype=np.bool_)),
        limit=said.most_common(1)[0][0] if said else "",
        control_ms=float(np.median(trace.control_ms)) if len(trace) else np.nan,
        control_p95_ms=_p95(trace.control_ms),
        seconds=float(trace.time[-1]) if len(trace) else 0.0,
    )


def limit_name(limit: str) -> str:
    """What a limit is called, without the numbers and the advice that it is told with: equal for one that goes on."""
    return limit.split(",")[0].split(":")[0]


def trace_csv(traces: Sequence[LawTrace]) -> bytes:
    """All traces as one table, a row a tick and law; SI units, milliseconds, and the limits in words."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    columns = [f"{name}_{unit}" if unit else name for name, unit in zip(NUMBERS, _UNITS, strict=True)]
    writer.writerow(["name", "law", *columns, "limits"])
    for trace in traces:
        numbers = [getattr(trace, name) for name in NUMBERS]
        for tick, limits in enumerate(trace.limits):
            values = [float(column[tick]) for column in numbers]
            said = ["" if np.isnan(value) else repr(value) for value in values]
            writer.writerow([trace.name, trace.settings.law, *said, "; ".join(limits)])
    return text.getvalue().encode()


def _finite(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def _rms(values: FloatArray) -> float:
    known = _finite(values)
    return float(np.sqrt(np.mean(known**2))) if known.size else np.nan


def _p95(values: FloatArray) -> float:
    known = _finite(values)
    return float(np.percentile(known, 95)) if known.size else np.nan


def _highest(values: FloatArray) -> float:
    known = _finite(values)
    return float(known.max()) if known.size else np.nan


def _share(which: BoolArray) -> float:
    return float(which.mean()) if which.size else np.nan
