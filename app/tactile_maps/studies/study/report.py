"""Writes what a study found: a table for programs (CSV, JSON, Parquet), and one HTML page for people that needs nothing
else to be shown. The page of a study that still runs loads itself anew.

The machine on which it was measured is named in all of them: without it no time means anything.
"""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from html import escape
from importlib.metadata import version
from pathlib import Path

from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import make_output_folder, write_atomically
from tactile_maps.studies.base.figures import BarChart, Figure, figure_svg
from tactile_maps.studies.base.hypotheses import Hypothesis, Judgement, Verdict
from tactile_maps.studies.base.rows import Cell, Row
from tactile_maps.studies.running.case_run import duration_text
from tactile_maps.studies.running.tables import columns, csv_table, parquet_table
from tactile_maps.studies.study.study import Study

_LIBRARIES = ("tactile-maps", "numpy", "scipy", "libigl")
_REFRESH = 10
"""Between two times that the page of a study that runs loads itself anew [s]."""
_LINUX_NAMES = Path("/proc/cpuinfo")


def describe_machine() -> dict[str, str]:
    """Processor, cores, system and versions, as text."""
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {_release()} {platform.machine()}",
        "Python": platform.python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }


def _release() -> str:
    """The system's version without what its distributor adds to it."""
    return ".".join(platform.release().split(".")[:2])


def _processor() -> str:
    """The processor's name; on Linux ``platform`` does not know it."""
    if _LINUX_NAMES.is_file():
        for line in _LINUX_NAMES.read_text(encoding="utf8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


_STYLE = """:root{color-scheme:light dark;--text:#222;--page:#fff;--line:#ddd;--note:#555}
@media(prefers-color-scheme:dark){:root{--text:#ddd;--page:#16191d;--line:#3a3f45;--note:#aaa}}
body{font:14px/1.5 sans-serif;max-width:1060px;margin:2em auto;padding:0 1em;color:var(--text);background:var(--page)}
h1{margin-bottom:0}h2{margin-top:2em}table{border-collapse:collapse;font-size:12px}
th,td{padding:2px 8px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{position:sticky;top:0;background:var(--page)}td:first-child,th:first-child{text-align:left}
.table{max-height:32em;overflow:auto}svg{max-width:100%;height:auto}
tbody tr:hover td{background:var(--line)}.note{color:var(--note);max-width:60em}
@media print{:root{color-scheme:light;--text:#000;--page:#fff;--line:#ccc;--note:#444}body{margin:0;max-width:none}
.table{max-height:none;overflow:visible}th{position:static}h2{break-after:avoid}svg,tr{break-inside:avoid}}"""


@dataclass(frozen=True)
class RunState:
    """How far a run is.

    Attributes:
        done: How many cases are.
        total: How many there are.
        known: Those of the done that were measured by earlier runs.
        remaining: How long the others take [s]; None where nothing is measured any more.
        spared: How many were not measured since what they ask was settled without them.
        undecided: What the table does not decide, and why, as sentences.
    """

    done: int
    total: int
    known: int = 0
    remaining: float | None = None
    spared: int = 0
    undecided: Sequence[str] = ()


@dataclass(frozen=True)
class StudyResult:
    """What came out of a run.

    Attributes:
        study: What was asked.
        rows: The table.
        machine: What it ran on.
        seconds: How long it took.
        seed: What everything random was made from.
        jobs: Processes that ran at once; None on a cluster.
        quick: Whether only the small cases were run.
        state: How far it is; None where all is done in one run.
    """

    study: Study
    rows: Sequence[Row]
    machine: Mapping[str, str]
    seconds: float
    seed: int
    jobs: int | None
    quick: bool
    state: RunState | None = None


def write_report(outcome: StudyResult, folder: Path) -> tuple[Path, ...]:
    """Write ``NAME.csv``, ``NAME.json`` and ``NAME.html`` into ``folder``, which is made where it is missing.

    Returns:
        The files.

    Raises:
        ExportError: They cannot be written there.
    """
    known = _finite_rows(outcome)
    files = {
        "csv": csv_table(known),
        "json": _json(outcome, known).encode(),
        "html": _html(outcome, known).encode(),
    }
    return tuple(_write(outcome, folder, ending, data) for ending, data in files.items())


def write_page(outcome: StudyResult, folder: Path) -> Path:
    """Write ``NAME.html`` alone; arguments and errors as ``write_report``."""
    return _write(outcome, folder, "html", _html(outcome, _finite_rows(outcome)).encode())


def _finite_rows(outcome: StudyResult) -> list[dict[str, Cell]]:
    return [{key: _finite_or_none(value) for key, value in row.items()} for row in outcome.rows]


def _write(outcome: StudyResult, folder: Path, ending: str, data: bytes) -> Path:
    path = make_output_folder(folder, error=ExportError) / f"{outcome.study.name}.{ending}"
    write_atomically(path, data, error=ExportError)
    return path


def report_files(study: Study) -> tuple[str, ...]:
    """Names of all files that ``write_report`` and ``write_parquet`` write."""
    return tuple(f"{study.name}.{ending}" for ending in ("csv", "json", "html", "parquet"))


def write_parquet(outcome: StudyResult, folder: Path) -> tuple[Path, ...]:
    """Write ``NAME.parquet``, which other programs read fastest; nothing where pyarrow is not installed or no row is.

    A column of numbers or of truth values is one there; any other is text. Arguments, return and errors as
    ``write_report``.
    """
    data = parquet_table(_finite_rows(outcome))
    return () if data is None else (_write(outcome, folder, "parquet", data),)


def _json(outcome: StudyResult, rows: Sequence[Row]) -> str:
    facts = {
        "name": outcome.study.name,
        "seconds": outcome.seconds,
        "seed": outcome.seed,
        "jobs": outcome.jobs,
        "quick": outcome.quick,
        "machine": dict(outcome.machine),
        **({} if outcome.state is None else asdict(outcome.state)),
        "hypotheses": judgements(outcome),
        "rows": [dict(row) for row in rows],
    }
    return json.dumps(facts, indent=1, allow_nan=False)


def _html(outcome: StudyResult, rows: Sequence[Row]) -> str:
    study = outcome.study
    run = {
        **outcome.machine,
        "seed": str(outcome.seed),
        "jobs": f"{outcome.jobs} at once" if outcome.jobs else "on a cluster; the machine is the one that asked",
        "cases": "the quick ones only" if outcome.quick else "all",
        "took": f"{outcome.seconds:.0f} s",
    }
    said = f"<p><strong>{escape(study.question)}</strong></p><p>{escape(study.method)}</p>{_state(outcome.state)}"
    found = _hypotheses_html(outcome) + _figures_html(outcome)
    tables = f"<h2>Measured on</h2>{facts_html(run)}<h2>All rows</h2>{rows_html(rows)}"
    return page_html(study.name, said + found + tables, head=_refresh(outcome.state))


def page_html(title: str, body: str, *, head: str = "") -> str:
    """A whole page in the look of all reports: light and dark, printable, and nothing else is needed to show it.

    Args:
        title: Its heading.
        body: HTML.
        head: More HTML for its head.
    """
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">{head}<title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{escape(title)}</h1>{body}</body></html>\n"
    )


def facts_html(facts: Mapping[str, object]) -> str:
    """Names and what they are, as a table."""
    rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in facts.items())
    return f"<table><tbody>{rows}</tbody></table>"


def rows_html(rows: Sequence[Row]) -> str:
    """A table of rows with a head; the row under the pointer is marked."""
    return f'<div class="table">{_table(rows)}</div>'


def _refresh(state: RunState | None) -> str:
    """Of a page that is going to be written anew."""
    running = state is not None and state.remaining is not None
    return f'<meta http-equiv="refresh" content="{_REFRESH}">' if running else ""


def _state(state: RunState | None) -> str:
    """How far it is, and what is not decided; nothing where all is."""
    if state is None:
        return ""
    told = []
    if state.remaining is not None:
        told.append(f"Still running: {duration_text(state.remaining)} left.")
    if state.done < state.total:
        told.append(f"{state.done} of {state.total} cases are done.")
    if state.known:
        told.append(f"{state.known} cases were measured by earlier runs.")
    if state.spared:
        told.append(f"{state.spared} were spared: what they ask was settled before.")
    undecided = "".join(f"<li>{escape(text)}</li>" for text in state.undecided)
    return f'<p class="note">{escape(" ".join(told))}</p>' + (
        f"<h2>Undecided</h2><ul>{undecided}</ul>" if undecided else ""
    )


def _figures_html(outcome: StudyResult) -> str:
    """All diagrams; of a table that is not whole those that can be drawn of it."""
    rows = [row for row in outcome.rows if "problem" not in row]
    try:
        return "".join(figure_html(figure) for figure in outcome.study.figures(rows))
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        if outcome.state is None or outcome.state.done == outcome.state.total:
            raise
        return f'<p class="note">These rows alone cannot be drawn yet ({escape(repr(error))}).</p>'


def figure_html(figure: Figure | BarChart) -> str:
    """A diagram under its title, with its note."""
    note = f'<p class="note">{escape(figure.note)}</p>' if figure.note else ""
    return f"<h2>{escape(figure.title)}</h2>{figure_svg(figure)}{note}"


def judgements(outcome: StudyResult) -> list[dict[str, Cell]]:
    """Of each hypothesis of the study its statement, the verdict, and the figures behind it."""
    known = [row for row in outcome.rows if "problem" not in row]
    judged = [(hypothesis, _judged(hypothesis, known, outcome.state)) for hypothesis in outcome.study.hypotheses]
    return [
        {
            "hypothesis": hypothesis.name,
            "statement": hypothesis.statement,
            "verdict": judgement.verdict.value,
            "figures": judgement.figures,
            "rows": judgement.rows,
        }
        for hypothesis, judgement in judged
    ]


def _judged(hypothesis: Hypothesis, rows: Sequence[Row], state: RunState | None) -> Judgement:
    """What rows say; of a table that is not whole nothing where a row is missing that it takes for granted."""
    try:
        return hypothesis.judge(rows)
    except (ArithmeticError, LookupError, TypeError, ValueError):
        if state is None or state.done == state.total:
            raise
        return Judgement(Verdict.NOT_DECIDED, "rows are missing", len(rows))


def _hypotheses_html(outcome: StudyResult) -> str:
    found = judgements(outcome)
    if not found:
        return ""
    rows = "".join(
        f"<dt><strong>{escape(str(row['hypothesis']))}: {escape(str(row['verdict']))}.</strong> "
        f"{escape(str(row['statement']))}</dt>"
        f'<dd class="note">{escape(str(row["figures"]))} ({row["rows"]} rows)</dd>'
        for row in found
    )
    return f"<h2>What was expected</h2><dl>{rows}</dl>"


def _table(rows: Sequence[Row]) -> str:
    names = columns(rows)
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(row.get(name))}</td>' for name in names)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" if isinstance(value, float) else escape(str(value))


def _finite_or_none(value: Cell) -> Cell:
    """What has no number is an empty cell in every table; JSON knows no nan and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
