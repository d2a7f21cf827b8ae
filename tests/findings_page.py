"""Writes the guide's page of findings from the tables in ``assets/findings``: ``python -m tests.findings_page``.

Every figure on the page is worked out here, from rows that a command made; a test writes it again and compares.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from app.studies.catalogue import load_study
from app.studies.hypotheses import Interval, bootstrap_median
from app.studies.path_time import force_feedback, representation
from app.studies.path_time.charts import rows_with_nominal, seconds_of
from app.studies.path_time.factors import Factor
from app.studies.path_time.path_time import ROBOTS
from app.studies.rows import Cell, Row, distinct

ASSETS = Path(__file__).resolve().parent.parent / "assets"
TABLES, PAGE = ASSETS / "findings", ASSETS / "guide" / "findings.md"
PATH_TIME = {"representation": representation.FACTORS, "force-feedback": force_feedback.FACTORS}
JUDGED = ("representation", "force-feedback", "loop-laws", "force-estimators")
_TEXTS = ("controller", "estimator", "law", "plant", "what", "robot", "factor", "jacobian", "verdict", "limited_by")


def table(study: str) -> list[Row]:
    """The rows of a study as they ship, numbers as numbers."""
    with (TABLES / f"{study}.csv").open(newline="", encoding="utf8") as file:
        return [{name: _cell(name, text) for name, text in row.items()} for row in csv.DictReader(file)]


def _cell(name: str, text: str) -> Cell:
    if name in _TEXTS:
        return text
    try:
        return json.loads(text) if text else ("" if name == "level" else None)
    except ValueError:
        return text


def page() -> str:
    """The whole page."""
    facts = json.loads((TABLES / "machine.json").read_text(encoding="utf8"))
    parts = [_HEAD.format(machine=", ".join(f"{name} {value}" for name, value in facts.items())), *_hypotheses()]
    for study, factors in PATH_TIME.items():
        rows = table(study)
        parts += [f"## {_TITLES[study]}", _made_by(study, rows)]
        for factor in factors:
            if any(row["factor"] == factor.name for row in rows):
                parts += _factor(factor, rows)
    return "\n\n".join(parts) + "\n"


_HEAD = """# What accuracy costs in time: findings

This page is written from the tables in `assets/findings` by `python -m tests.findings_page`, and a test writes it
again; each table is made by the command that stands beside it. `tactile-maps study NAME` draws the same as figures,
and says how it measures. Measured with {machine}.

The measure is the least time for a figure of eight of 91 mm on the forearm's skin, pressed on a ball with 3 N, such
that 95 % of the errors on the body are within 3 mm and the force is within 0.6 N for 95 % of the time, contact never
lost. Times are medians over seeds with their 95 % bootstrap interval, to 9 %; *cannot* means that most seeds can at no
speed from 4 to 128 mm/s."""
_TITLES = {"representation": "How the skin is known and made", "force-feedback": "How the force is felt"}


def _made_by(study: str, rows: Sequence[Row]) -> str:
    seeds = {robot: len(distinct([row for row in rows if row["robot"] == robot], "seed")) for robot in ROBOTS}
    told = ", ".join(f"{count} seed{'s' * (count > 1)} on {robot}" for robot, count in seeds.items() if count)
    return f"`tactile-maps study {study}`: {len(rows)} cases, {told} ([rows](../findings/{study}.csv))."


def _hypotheses() -> Iterator[str]:
    yield "## What theory expects"
    lines = ["| | expected | verdict | figures |", "|---|---|---|---|"]
    for study in JUDGED:
        rows = table(study)
        for hypothesis in load_study(study).hypotheses:
            found = hypothesis.judge(rows)
            cells = (
                hypothesis.name,
                hypothesis.statement,
                f"**{found.verdict}**",
                f"{found.figures} ({found.rows} rows)",
            )
            lines.append(f"| {' | '.join(cells)} |")
    yield "\n".join(lines)
    yield (
        "H1, H2, H6 and H7 are judged on our own arm by `tactile-maps study representation` and `force-feedback`, H3 "
        "to H5 by `loop-laws` ([rows](../findings/loop-laws.csv)), H8 by `force-estimators` "
        "([rows](../findings/force-estimators.csv)). An interval decides, never a middle alone."
    )


def _factor(factor: Factor, rows: Sequence[Row]) -> Iterator[str]:
    of = rows_with_nominal(rows, factor)
    levels, robots = distinct(of, "level"), distinct(of, "robot")
    kinds = [(robot, jacobian) for robot in robots for jacobian in factor.jacobians]
    several = len(factor.jacobians) > 1
    titles = [f"{robot}, {jacobian}" if several else str(robot) for robot, jacobian in kinds]
    yield f"### {factor.name.capitalize()}: {factor.axis.partition(' (')[0]}"
    lines = [f"| | {' | '.join(titles)} |", f"|---|{'---|' * len(titles)}"]
    for level in levels:
        cells = [
            _time(seconds_of([row for row in of if (row["robot"], row["jacobian"]) == kind], level)) for kind in kinds
        ]
        lines.append(f"| {_level(level)}{' (nominal)' * (level == factor.nominal)} | {' | '.join(cells)} |")
    yield "\n".join(lines)
    if factor.note:
        yield factor.note


def _level(level: Cell) -> str:
    return f"{level:g}" if isinstance(level, int | float) else str(level)


def _time(seconds: Sequence[float]) -> str:
    if not seconds:
        return ""
    found = bootstrap_median(seconds)
    if math.isinf(found.middle):
        return "cannot"
    return _interval(found) if len(seconds) > 1 else f"{found.middle:.3g} s"


def _interval(found: Interval) -> str:
    high = "cannot" if math.isinf(found.high) else f"{found.high:.3g}"
    return f"{found.middle:.3g} s [{found.low:.3g}, {high}]"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf8")
