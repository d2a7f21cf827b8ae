"""Writes the guide's page of findings from the tables in ``assets/findings``: ``python -m tests.findings_page``.

``--tables DIR`` first replaces the shipped tables by those that ``tactile-maps study NAME -o DIR`` wrote: the shipped
columns, numbers with five digits.

Every number and figure of the page is computed here from the rows. A test writes the page again and compares, and
checks that each figure belongs to the present rows.
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
from itertools import zip_longest
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
from tactile_maps.studies.sweeps.controller_accuracy import COMPARED, FORCE_ONLY, GOAL

ASSETS = Path(__file__).resolve().parent.parent / "assets"
TABLES = ASSETS / "findings"
PAGE = ASSETS / "guide" / "findings.md"
PATH_TIME = {"representation": representation.FACTORS, "force-feedback": force_feedback.FACTORS}
FIGURES = TABLES / "figures"
_COLOURS = "<style>svg{color:#333}@media(prefers-color-scheme:dark){svg{color:#ccc}}</style>"
"""Text colours of the pictures, which do not inherit those of the page."""
JUDGED = ("representation", "force-feedback", "loop-laws", "force-estimators")
SHEAR = ("shear-benefit", "shear-cost")
CONTROLLERS = "controller-accuracy"
SHOWN = (*JUDGED, *SHEAR, CONTROLLERS)
_TEXTS = ("controller", "estimator", "law", "plant", "what", "robot", "factor", "jacobian", "verdict", "limited_by")


def table(study: str, folder: Path = TABLES) -> list[Row]:
    """Return the shipped rows of a study, with numbers converted."""
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
    """Return a study's table with the columns ``kept`` and numbers with five digits: a tenth of the size."""
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
    """Replace the shipped tables by those in ``folder``; tables that it lacks, and ``needs``, stay unchanged."""
    for study in SHOWN:
        made = folder / f"{study}.csv"
        shipped = TABLES / f"{study}.csv"
        if made.is_file():
            kept = (shipped if shipped.is_file() else made).read_text(encoding="utf8").partition("\n")[0].split(",")
            shipped.write_text(as_shipped(made.read_text(encoding="utf8"), kept), encoding="utf8", newline="")


def page() -> str:
    """Return the text of the page."""
    facts = json.loads((TABLES / "machine.json").read_text(encoding="utf8"))
    parts = [_HEAD.format(machine=", ".join(f"{name} {value}" for name, value in facts.items())), *_hypotheses()]
    for study, factors in PATH_TIME.items():
        rows = table(study)
        parts += [f"## {_TITLES[study]}", _made_by(study, rows)]
        shown = [factor for factor in factors if any(row["factor"] == factor.name for row in rows)]
        for factor, following in zip_longest(shown, shown[1:]):
            parts += _factor(factor, rows)
            if factor.note and (following is None or following.note != factor.note):
                parts.append(factor.note)
    parts += _racing()
    for study in (study for study in SHOWN if study not in PATH_TIME):
        rows = table(study)
        parts += [f"## {_TITLES[study]}", f"`tactile-maps study {study}` ([rows](../findings/{study}.csv))."]
        parts += _SUMMARIES[study](rows) if study in _SUMMARIES else ()
        parts += ["\n".join(map(_picture, load_study(study).figures(rows)))]
    return "\n\n".join(parts) + "\n"


def figures() -> Mapping[str, Figure | BarChart]:
    """Return the figures by file name: each factor of path time, and all figures of the other studies."""
    of_factors = [figure for study, factors in PATH_TIME.items() for figure in _drawn(factors, table(study))]
    others = [figure for study in SHOWN if study not in PATH_TIME for figure in load_study(study).figures(table(study))]
    return {_file_name(figure): figure for figure in (*of_factors, *others)}


def _drawn(factors: Sequence[Factor], rows: Sequence[Row]) -> list[Figure | BarChart]:
    """Return the figures of the factors, except bar charts in which every level is impossible."""
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
    """Return a comment that identifies the contents of a figure."""
    return f"<!-- {blake2b(repr(figure).encode(), digest_size=8).hexdigest()} -->"


def _picture(figure: Figure | BarChart) -> str:
    return f"![{figure.title}](../findings/figures/{_file_name(figure)})"


def write() -> None:
    """Write the page and a picture of each figure; delete other pictures in the folder."""
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

How long does a robot need to follow a path with its skin, depending on how accurately the skin is known, made and read?
This page lists the measured times, and compares them with theory. `python -m tests.findings_page` writes it from the
tables in `assets/findings`; `tactile-maps study NAME` makes each table and draws the same figures.

Measured with {machine}.

## The measure

The measure is the shortest time for a figure of eight of 91 mm on the skin of the forearm, pressed on a ball with 3 N,
if

- 95 % of the errors on the body are within 3 mm,
- the force is within 0.6 N for 95 % of the time,
- the contact is never lost.

Times are medians over seeds with their 95 % bootstrap interval, to 9 %. *Cannot* means that most seeds fail at all
speeds from 4 to 128 mm/s. *Effect* is the additional time on the arm compared with nominal conditions: the median of
the differences between runs with the same seed, with its interval. An interval decides a verdict, never a median alone.

| symbol | meaning |
|---|---|
| T | time between two readings of the skin |
| d | delay of the readings, in units of T |
| k_f | force gain [m/s/N] |
| k | stiffness of the contact |
| L = k k_f T | loop gain |
| L_max = 2 sin(π/(2(2d+1))) | limit of stability of the loop gain |
| L* = d^d/(d+1)^(d+1) | largest loop gain without overshoot |
| l, e | length of the path, tolerance |

The Jacobian of the map is *smoothed* (fitted over two rings of taxels), *raw* (of the single triangle) or *isometric*
(assuming a map without distortion)."""
_TITLES = {
    "representation": "Effect of how the skin is known and made",
    "force-feedback": "Effect of how the force is measured",
    "loop-laws": "Laws of the sampled loop",
    "force-estimators": "Force from readings",
    "shear-benefit": "Benefit of measured shear",
    "shear-cost": "Accuracy of shear",
    CONTROLLERS: "Accuracy of the controllers",
}


def _made_by(study: str, rows: Sequence[Row]) -> str:
    seeds = {robot: len(distinct([row for row in rows if row["robot"] == robot], "seed")) for robot in ROBOTS}
    listed = ", ".join(f"{count} seed{'s' * (count > 1)} on {robot}" for robot, count in seeds.items() if count)
    return f"`tactile-maps study {study}`: {len(rows)} cases, {listed} ([rows](../findings/{study}.csv))."


def _hypotheses() -> Iterator[str]:
    yield "## What theory expects"
    lines = ["| | expected | verdict | rows |", "|---|---|---|---|"]
    details = ["| | quantity | case | value |", "|---|---|---|---|"]
    for study in JUDGED:
        rows = table(study)
        for hypothesis in load_study(study).hypotheses:
            found = hypothesis.judge(rows)
            name = hypothesis.name
            lines.append(f"| {name} | {hypothesis.statement} | **{found.verdict}** | {found.rows} |")
            quantity, _, values = found.figures.partition(": ")
            for value in values.split("; "):
                case, _, number = value.rpartition(": ")
                details.append(f"| {name} | {quantity} | {case} | {number} |")
    yield "\n".join(lines)
    yield (
        "`tactile-maps study representation` and `force-feedback` test H1, H2, H6 and H7 on our own arm, `loop-laws` "
        "H3 to H5 ([rows](../findings/loop-laws.csv)), `force-estimators` H8 "
        "([rows](../findings/force-estimators.csv)). The values behind the verdicts (*inf*: most seeds cannot):"
    )
    yield "\n".join(details)


class Race(NamedTuple):
    """Result of ``--budget`` with sufficient time on the shipped rows of our arm.

    Attributes:
        run: Number of cases run until everything that can be decided is decided.
        cases: Number of all cases.
        verdicts: For each level the decision on its effect by all seeds, and by the seeds that were run.
    """

    run: int
    cases: int
    verdicts: Mapping[str, tuple[Settled, Settled]]


@cache
def race(study: str) -> Race:
    """Run ``--budget`` on a study of path time, with the shipped row as the result of each case."""
    rows = [row for row in table(study) if row["robot"] == ROBOTS[0]]
    known = {_case_key(row): row for row in rows}
    cases = [{name: row[name] for name in (*EFFECT.keys, SEED)} for row in rows]
    run = CaseRun(study, lambda case: [known[_case_key(case)]], cases)
    run_within(run, until=math.inf, effect=EFFECT)
    full = EFFECT.effects(rows)
    raced = EFFECT.effects(run.rows)
    verdicts = {group: (EFFECT.verdict(full[group])[0], EFFECT.verdict(raced[group])[0]) for group in full}
    return Race(run.done, len(cases), verdicts)


def _case_key(case: Row) -> tuple[Cell, ...]:
    return tuple(case[name] for name in (*EFFECT.keys, SEED))


def _racing() -> Iterator[str]:
    yield "## Fewer runs"
    races = [race(study) for study in PATH_TIME]
    verdicts = [verdict for one in races for verdict in one.verdicts.values()]
    same = sum(full is raced for full, raced in verdicts)
    sooner = sum(full is Settled.OPEN is not raced for full, raced in verdicts)
    later = sum(raced is Settled.OPEN is not full for full, raced in verdicts)
    yield (
        "`--budget` runs no more seeds for levels that are decided. With the rows above on the arm and sufficient "
        f"time, it runs {sum(one.run for one in races)} of {sum(one.cases for one in races)} cases. The question is "
        "whether a level takes longer than nominal conditions, or the same time within 10 %. For "
        f"{same} of {len(verdicts)} levels the decision is the same as with all seeds; {sooner} are decided only "
        f"with few seeds, {later} only with all, {len(verdicts) - same - sooner - later} are decided in the opposite "
        "way."
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
    """Return a paired effect in seconds; empty for nominal conditions."""
    if found is None:
        return ""
    if math.isinf(found.middle):
        return "cannot"
    high = "cannot" if math.isinf(found.high) else f"{found.high:+.2f}"
    return f"{found.middle:+.2f} s [{found.low:+.2f}, {high}]"


def _interval(found: Interval) -> str:
    high = "cannot" if math.isinf(found.high) else f"{found.high:.3g}"
    return f"{found.middle:.3g} s [{found.low:.3g}, {high}]"


_BENEFITS = (
    ("guided_by_hand", "pull_n", "pull of a hand that guides the arm [N]"),
    ("guided_by_hand", "way_mm", "way of the arm for 60 mm of the hand [mm]"),
    ("carry", "slip_mm", "slip of a lifted block [mm]"),
    ("carry", "force_n", "largest force of a finger on the block, mean over time [N]"),
)


def _shear_benefit(rows: Sequence[Row]) -> Iterator[str]:
    yield (
        "The same physics and skin, with a controller that uses the measured shear and one that ignores it; medians "
        "over the places of the taxels with their 95 % bootstrap interval. With a friction of 0.3 the arm follows the "
        "place of the hand farther than its pull, and with 1.2 the block does not slip either way. No controller uses "
        "shear to follow a path: its time is the same with three axes as with one."
    )
    lines = ["| | friction | shear used | shear ignored |", "|---|---|---|---|"]
    for task, column, name in _BENEFITS:
        own = [row for row in rows if row["task"] == task]
        for friction in distinct(own, "friction"):
            cells = [_median(own, column, friction=friction, shear=shear) for shear in ("used", "ignored")]
            lines.append(f"| {name} | {friction:g} | {' | '.join(cells)} |")
    yield "\n".join(lines)


def _median(rows: Sequence[Row], column: str, **where: Cell) -> str:
    found = [row[column] for row in rows if all(row[name] == value for name, value in where.items())]
    return str(bootstrap_median([float(value) for value in found]))


def _shear_cost(rows: Sequence[Row]) -> Iterator[str]:
    yield (
        "Force on the wrong taxels as a share of the friction limit, mean over seven states of a ball that is dragged, "
        "let go and dragged back; and the time of a reading with shear. Model `water-fill`, on a square of 100 mm. The "
        "machine was shared: times vary by a factor of two."
    )
    own = [row for row in rows if row["model"] == "water-fill"]
    counts = distinct(own, "taxels")
    lines = [f"| cover | {' | '.join(f'{count:,} taxels' for count in counts)} |", f"|---|{'---|' * len(counts)}"]
    for modulus in distinct(own, "modulus_kpa"):
        cells = [
            f"{row['traction_percent']:.2g} %, {row['ms']:.2g} ms ({row['taxels_across']:.2g} across)"
            for row in own
            if row["modulus_kpa"] == modulus
        ]
        lines.append(f"| {modulus} kPa | {' | '.join(cells)} |")
    yield "\n".join(lines)


def _controllers(rows: Sequence[Row]) -> Iterator[str]:
    own = [row for row in rows if row["sensor"] == "skin"]
    compared = [row for row in own if row["path"] == COMPARED]
    seeds = len(distinct(compared, "seed"))
    finished = sum(row["finished_s"] is not None for row in compared)
    yield (
        f"A figure of eight of 30 mm on the forearm at 10 mm/s and {GOAL:g} N, next to a fixed ball; 1,000 taxels with "
        "a pitch of 8 to 10 mm and a noise of 100 Pa. Each controller has half the force gain that theory predicts to "
        f"be stable, at most its default. Medians over {seeds} seeds, which place the taxels, with their 95 % "
        f"bootstrap interval; {finished} of {len(compared)} runs finish. `{FORCE_ONLY}` has no task and holds the "
        "contact; `impedance` has no force goal and is left out. The machine was shared: computing times are upper "
        "bounds."
    )
    robots = distinct(own, "robot")
    for column, title in (
        ("body_p95_mm", "true error on the body, 95 % [mm]"),
        ("force_rms_N", "force error, rms [N]"),
    ):
        lines = [f"| {title} | {' | '.join(map(str, robots))} |", f"|---|{'---|' * len(robots)}"]
        for controller in distinct([row for row in own if row[column] is not None], "controller"):
            cells = [_median(own, column, controller=controller, robot=robot) for robot in robots]
            lines.append(f"| `{controller}` | {' | '.join(cells)} |")
        yield "\n".join(lines)


_SUMMARIES = {"shear-benefit": _shear_benefit, "shear-cost": _shear_cost, CONTROLLERS: _controllers}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tables", type=Path, metavar="DIR", help="take the tables of this folder first")
    folder = parser.parse_args().tables
    if folder is not None:
        take_tables(folder)
    write()
