"""Tells what an experiment found: a table for programs, and one page for people that needs nothing else to be shown."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from app.errors import UsageError
from app.experiments.bars import Bars, bars_svg
from app.experiments.experiment import Experiment
from app.experiments.plot import Figure, svg
from app.experiments.sweep import Row

_STYLE = """body{font:14px/1.5 sans-serif;max-width:1060px;margin:2em auto;padding:0 1em;color:#222}
h1{margin-bottom:0}h2{margin-top:2em}table{border-collapse:collapse;font-size:12px}
th,td{padding:2px 8px;text-align:right;border-bottom:1px solid #ddd;white-space:nowrap}
th{position:sticky;top:0;background:#fff}td:first-child,th:first-child{text-align:left}
.table{max-height:32em;overflow:auto}svg{max-width:100%;height:auto}
.note{color:#555;max-width:60em}"""


@dataclass(frozen=True)
class Outcome:
    """What came out of a run.

    Attributes:
        experiment: What was asked.
        rows: The table.
        machine: What it ran on.
        seconds: How long it took.
        seed: What everything random was made from.
        jobs: Processes that ran at once.
        quick: Whether only the small cases were run.
    """

    experiment: Experiment
    rows: Sequence[Row]
    machine: Mapping[str, str]
    seconds: float
    seed: int
    jobs: int
    quick: bool


def write_report(outcome: Outcome, folder: Path) -> tuple[Path, ...]:
    """Write ``NAME.csv``, ``NAME.json`` and ``NAME.html`` into ``folder``, which is made where it is missing.

    Returns:
        The files.

    Raises:
        UsageError: They cannot be written there.
    """
    name = outcome.experiment.name
    texts = {"csv": _csv(outcome.rows), "json": _json(outcome), "html": _html(outcome)}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for ending, text in texts.items():
            (folder / f"{name}.{ending}").write_text(text, encoding="utf8", newline="")
    except OSError as error:
        raise UsageError("the report cannot be written", file=folder, value=error.strerror) from error
    return tuple(folder / f"{name}.{ending}" for ending in texts)


def columns(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, in the order in which they first come."""
    return list(dict.fromkeys(key for row in rows for key in row))


def _csv(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), restval="")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _json(outcome: Outcome) -> str:
    facts = {
        "name": outcome.experiment.name,
        "seconds": outcome.seconds,
        "seed": outcome.seed,
        "jobs": outcome.jobs,
        "quick": outcome.quick,
        "machine": dict(outcome.machine),
        "rows": [{key: _finite(value) for key, value in row.items()} for row in outcome.rows],
    }
    return json.dumps(facts, indent=1, allow_nan=False)


def _html(outcome: Outcome) -> str:
    experiment = outcome.experiment
    drawn = [
        f"<h2>{escape(figure.title)}</h2>{_drawn(figure)}"
        for figure in experiment.figures([row for row in outcome.rows if "problem" not in row])
    ]
    run = {
        **outcome.machine,
        "seed": str(outcome.seed),
        "jobs": f"{outcome.jobs} at once",
        "cases": "the quick ones only" if outcome.quick else "all",
        "took": f"{outcome.seconds:.0f} s",
    }
    facts = "".join(f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>" for name, value in run.items())
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{escape(experiment.name)}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{escape(experiment.name)}</h1>"
        f"<p><strong>{escape(experiment.question)}</strong></p><p>{escape(experiment.method)}</p>"
        f"{''.join(drawn)}<h2>Measured on</h2><table>{facts}</table>"
        f'<h2>All rows</h2><div class="table">{_table(outcome.rows)}</div></body></html>\n'
    )


def _drawn(figure: Figure | Bars) -> str:
    note = f'<p class="note">{escape(figure.note)}</p>' if figure.note else ""
    return (bars_svg(figure) if isinstance(figure, Bars) else svg(figure)) + note


def _table(rows: Sequence[Row]) -> str:
    names = columns(rows)
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(row.get(name))}</td>' for name in names)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" if isinstance(value, float) else escape(str(value))


def _finite(value: object) -> object:
    """JSON knows no nan and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
