"""Writes the guide's page of findings from the tables in ``assets/findings``: ``python -m tests.findings_page``.

With ``--tables DIR`` it first takes the tables that ``tactile-maps study NAME -o DIR`` wrote in the place of those that
ship: the columns that ship, numbers to five digits.

Every number on the page is worked out here, from rows that a command made, and so are the figures beside it; a test
writes the page again and compares, and asks of each figure whether it is of the rows that are there.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

from tactile_maps.studies.base.figures import BarChart, Figure, figure_svg
from tactile_maps.studies.base.hypotheses import Interval, bootstrap_median
from tactile_maps.studies.base.rows import Cell, Row, distinct
from tactile_maps.studies.catalogue import load_study
from tactile_maps.studies.path_time import force_feedback, representation
from tactile_maps.studies.path_time.charts import factor_figures, rows_with_nominal, seconds_of
from tactile_maps.studies.path_time.expectations import EFFECT, time_effect
from tactile_maps.studies.path_time.factors import Factor
from tactile_maps.studies.path_time.path_time import ROBOTS
from tactile_maps.studies.running.case_run import CaseRun
from tactile_maps.studies.running.sequential import SEED, Settled, run_within

ASSETS = Path(__file__).resolve().parent.parent / "assets"
TABLES = ASSETS / "findings"
PAGE = ASSETS / "guide" / "findings.md"
PATH_TIME = {"representation": representation.FACTORS, "force-feedback": force_feedback.FACTORS}
FIGURES = TABLES / "figures"
_COLOURS = "<style>svg{color:#333}@media(prefers-color-scheme:dark){svg{color:#ccc}}</style>"
"""A picture has no colours of the page that it stands on."""
JUDGED = ("representation", "force-feedback", "loop-laws", "force-estimators")
_TEXTS = ("controller", "estimator", "law", "plant", "what", "robot", "factor", "jacobian", "verdict", "limited_by")


def table(study: str, folder: Path = TABLES) -> list[Row]:
    """Return the rows of a study as they ship, numbers as numbers."""
    with (folder / f"{study}.csv").open(newline="", encoding="utf8") as file:
        return [{name: _cell(name, text) for name, text in row.items()} for row in csv.DictReader(file)]


def _cell(name: str, text: str) -> Cell:
    if name in _TEXTS:
        return text
    try:
        return json.loads(text) if text else ("" if name == "level" else None)
    except ValueError:
        return text


def as_shipped(text: str, kept: Sequence[str]) -> str:
    """A study's table with the columns ``kept`` and numbers to five digits: a tenth of the size, for every figure."""
    short = io.StringIO()
    writer = csv.DictWriter(short, kept, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for row in csv.DictReader(io.StringIO(text, newline="")):
        writer.writerow({name: _five_digits(cell) for name, cell in row.items()})
    return short.getvalue()


def _five_digits(text: str) -> str:
    try:
        number = json.loads(text)
    except ValueError:
        return text
    return repr(float(f"{number:.5g}")) if isinstance(number, float) else text


def take_tables(folder: Path) -> None:
    """Ship the tables of ``folder``; those it has not stay, and ``needs`` ships whole."""
    for study in JUDGED:
        made = folder / f"{study}.csv"
        shipped = TABLES / f"{study}.csv"
        if made.is_file():
            kept = shipped.read_text(encoding="utf8").partition("\n")[0].split(",")
            shipped.write_text(as_shipped(made.read_text(encoding="utf8"), kept), encoding="utf8", newline="")


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
    parts += _racing()
    for study in (study for study in JUDGED if study not in PATH_TIME):
        drawn = load_study(study).figures(table(study))
        parts += [f"## {_TITLES[study]}", f"`tactile-maps study {study}` ([rows](../findings/{study}.csv))."]
        parts += ["\n".join(map(_picture, drawn))]
    return "\n\n".join(parts) + "\n"


def figures() -> Mapping[str, Figure | BarChart]:
    """What is drawn, by the name of its file: each factor of path time, and all figures of the other studies."""
    of_factors = [figure for study, factors in PATH_TIME.items() for figure in _drawn(factors, table(study))]
    others = [
        figure for study in JUDGED if study not in PATH_TIME for figure in load_study(study).figures(table(study))
    ]
    return {_file_name(figure): figure for figure in (*of_factors, *others)}


def _drawn(factors: Sequence[Factor], rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Without the bars of what is at all levels impossible."""
    made = factor_figures(factors, rows)
    return [
        one
        for one in made
        if not isinstance(one, BarChart)
        or any(amount is not None and math.isfinite(amount) for amount in one.amounts.values())
    ]


def _file_name(figure: Figure | BarChart) -> str:
    return re.sub(r"[^a-z0-9]+", "-", figure.title.lower()).strip("-") + ".svg"


def mark(figure: Figure | BarChart) -> str:
    """Stands in a picture, and says what was drawn."""
    return f"<!-- {blake2b(repr(figure).encode(), digest_size=8).hexdigest()} -->"


def _picture(figure: Figure | BarChart) -> str:
    return f"![{figure.title}](../findings/figures/{_file_name(figure)})"


def write() -> None:
    """The page, and a picture of each figure; others that lie there are taken away."""
    PAGE.write_text(page(), encoding="utf8")
    FIGURES.mkdir(exist_ok=True)
    drawn = figures()
    for old in FIGURES.glob("*.svg"):
        if old.name not in drawn:
            old.unlink()
    for name, figure in drawn.items():
        head, _, body = figure_svg(figure).partition(">")
        (FIGURES / name).write_text(f"{head}>{mark(figure)}{_COLOURS}{body}\n", encoding="utf8")


_HEAD = """# What accuracy costs in time: findings

This page is written from the tables in `assets/findings` by `python -m tests.findings_page`, and a test writes it
again; each table is made by the command that stands beside it. `tactile-maps study NAME` draws the same figures, and
says how it measures. Measured with {machine}.

The measure is the least time for a figure of eight of 91 mm on the forearm's skin, pressed on a ball with 3 N, such
that 95 % of the errors on the body are within 3 mm and the force is within 0.6 N for 95 % of the time, contact never
lost. Times are medians over seeds with their 95 % bootstrap interval, to 9 %; *cannot* means that most seeds can at no
speed from 4 to 128 mm/s. *Effect* is the time on the arm minus that in nominal conditions: the median of the
differences between runs of the same seed, with its interval.

T is the time between two readings of the skin and d their delay in such times; k_f is the force gain [m/s/N], k the
contact's stiffness and L = k k_f T the loop gain, whose limit of stability is L_max = 2 sin(π/(2(2d+1))), and
L* = d^d/(d+1)^(d+1) the greatest without overshoot; l is the path's length, e the tolerance. The map's Jacobian is
*smoothed* (fitted over two rings of taxels), *raw* (of the single triangle) or *isometric* (as if the map were free of
stretch)."""
_TITLES = {
    "representation": "How the skin is known and made",
    "force-feedback": "How the force is felt",
    "loop-laws": "Laws of the sampled loop",
    "force-estimators": "From readings to a force",
}


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


class Race(NamedTuple):
    """What ``--budget`` with time enough asks of the rows that ship, of our arm.

    Attributes:
        run: Cases that it asks for, until all is settled that it can settle.
        cases: All.
        answers: Of each level: what all seeds say of its effect, and what those do that were asked for.
    """

    run: int
    cases: int
    answers: Mapping[str, tuple[Settled, Settled]]


@cache
def race(study: str) -> Race:
    """Of a study of path time: each case that is asked for answers with the row that ships."""
    rows = [row for row in table(study) if row["robot"] == ROBOTS[0]]
    known = {_case_key(row): row for row in rows}
    cases = [{name: row[name] for name in (*EFFECT.keys, SEED)} for row in rows]
    run = CaseRun(study, lambda case: [known[_case_key(case)]], cases)
    run_within(run, until=math.inf, effect=EFFECT)
    full = EFFECT.effects(rows)
    raced = EFFECT.effects(run.rows)
    answers = {group: (EFFECT.verdict(full[group])[0], EFFECT.verdict(raced[group])[0]) for group in full}
    return Race(run.done, len(cases), answers)


def _case_key(case: Row) -> tuple[Cell, ...]:
    return tuple(case[name] for name in (*EFFECT.keys, SEED))


def _racing() -> Iterator[str]:
    yield "## Fewer runs"
    races = [race(study) for study in PATH_TIME]
    told = [answer for one in races for answer in one.answers.values()]
    same = sum(full is raced for full, raced in told)
    sooner = sum(full is Settled.OPEN is not raced for full, raced in told)
    later = sum(raced is Settled.OPEN is not full for full, raced in told)
    yield (
        "`--budget` asks no more seeds of what is settled. Asked of the rows above on the arm, with time enough, it "
        f"takes {sum(one.run for one in races)} of {sum(one.cases for one in races)} cases. Whether a level takes "
        "longer than nominal conditions, or as long to 10 %, it answers as all seeds do for "
        f"{same} of {len(told)} levels; {sooner} are settled by few seeds and open by all, {later} are left open and "
        f"settled by all, {len(told) - same - sooner - later} have the opposite answer."
    )


def _factor(factor: Factor, rows: Sequence[Row]) -> Iterator[str]:
    of = rows_with_nominal(rows, factor)
    levels = distinct(of, "level")
    robots = distinct(of, "robot")
    kinds = [(robot, jacobian) for robot in robots for jacobian in factor.jacobians]
    several = len(factor.jacobians) > 1
    titles = [f"{robot}, {jacobian}" if several else str(robot) for robot, jacobian in kinds]
    yield f"### {factor.name.capitalize()}: {factor.axis.partition(' (')[0]}"
    effects = [jacobian for jacobian in factor.jacobians if robots[0] == ROBOTS[0]]
    titles += [f"effect, {jacobian}" if several else "effect" for jacobian in effects]
    lines = [f"| | {' | '.join(titles)} |", f"|---|{'---|' * len(titles)}"]
    for level in levels:
        cells = [
            _time(seconds_of([row for row in of if (row["robot"], row["jacobian"]) == kind], level)) for kind in kinds
        ]
        cells += [_effect(time_effect(rows, factor.name, level, jacobian)) for jacobian in effects]
        lines.append(f"| {_level(level)}{' (nominal)' * (level == factor.nominal)} | {' | '.join(cells)} |")
    yield "\n".join(lines)
    yield "\n".join(map(_picture, _drawn([factor], rows)))
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


def _effect(found: Interval | None) -> str:
    """Paired, in seconds; empty in nominal conditions, of which there is none."""
    if found is None:
        return ""
    if math.isinf(found.middle):
        return "cannot"
    high = "cannot" if math.isinf(found.high) else f"{found.high:+.2f}"
    return f"{found.middle:+.2f} s [{found.low:+.2f}, {high}]"


def _interval(found: Interval) -> str:
    high = "cannot" if math.isinf(found.high) else f"{found.high:.3g}"
    return f"{found.middle:.3g} s [{found.low:.3g}, {high}]"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tables", type=Path, metavar="DIR", help="take the tables of this folder first")
    folder = parser.parse_args().tables
    if folder is not None:
        take_tables(folder)
    write()
