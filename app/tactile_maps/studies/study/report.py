"""Reports of studies: a table for programs (CSV, JSON, Parquet) and a self-contained HTML page for people.

The page of a study that is still running reloads itself. All files name the machine, because times mean nothing
without it.
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

from tactile_maps.core.errors import ExportError, counted
from tactile_maps.core.files import make_output_folder, write_atomically
from tactile_maps.maps.formats.html_page import facts_html, page_html, rows_html
from tactile_maps.studies.base.figures import BarChart, Figure, figure_svg
from tactile_maps.studies.base.hypotheses import Hypothesis, Judgement, Verdict
from tactile_maps.studies.base.rows import Cell, Row
from tactile_maps.studies.running.case_run import duration_text
from tactile_maps.studies.running.tables import csv_table, parquet_table
from tactile_maps.studies.study.study import Study

_LIBRARIES = ("tactile-maps", "numpy", "scipy", "libigl")
_REFRESH = 10
"""Time between two reloads of the page of a running study [s]."""
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
    """Version of the system without the suffix of its distributor."""
    return ".".join(platform.release().split(".")[:2])


def _processor() -> str:
    """Name of the processor, which ``platform`` does not report on Linux."""
    if _LINUX_NAMES.is_file():
        for line in _LINUX_NAMES.read_text(encoding="utf8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


@dataclass(frozen=True)
class RunState:
    """Progress of a run.

    Attributes:
        done: Number of finished cases.
        total: Number of all cases.
        known: Number of finished cases that earlier runs measured.
        remaining: Time that the other cases take [s]; None when no case is being measured.
        spared: Number of cases not measured because their result was settled without them.
        undecided: Questions that the table does not decide, and why, as sentences.
    """

    done: int
    total: int
    known: int = 0
    remaining: float | None = None
    spared: int = 0
    undecided: Sequence[str] = ()


@dataclass(frozen=True)
class StudyResult:
    """Result of a run of a study.

    Attributes:
        study: The study.
        rows: Rows of the table.
        machine: Facts about the machine.
        seconds: Duration of the run [s].
        seed: Seed of all random numbers.
        jobs: Number of parallel processes; None on a cluster.
        quick: Whether only the small cases were run.
        state: Progress; None for a run that measured everything at once.
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
    """Write ``NAME.csv``, ``NAME.json`` and ``NAME.html`` into ``folder``, which is created if missing.

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
    """Write ``NAME.html`` only; arguments and errors as for ``write_report``."""
    return _write(outcome, folder, "html", _html(outcome, _finite_rows(outcome)).encode())


def _finite_rows(outcome: StudyResult) -> list[dict[str, Cell]]:
    return [{key: _finite_or_none(value) for key, value in row.items()} for row in outcome.rows]


def _write(outcome: StudyResult, folder: Path, ending: str, data: bytes) -> Path:
    path = make_output_folder(folder, error=ExportError) / f"{outcome.study.name}.{ending}"
    write_atomically(path, data, error=ExportError)
    return path


def report_files(study: Study) -> tuple[str, ...]:
    """Return the names of all files that ``write_report`` and ``write_parquet`` write."""
    return tuple(f"{study.name}.{ending}" for ending in ("csv", "json", "html", "parquet"))


def write_parquet(outcome: StudyResult, folder: Path) -> tuple[Path, ...]:
    """Write ``NAME.parquet``, the fastest table to read; write nothing without pyarrow or without rows.

    Columns of numbers or booleans keep their type; all others are text. Arguments, result and errors as for
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
        "jobs": f"{outcome.jobs} at once" if outcome.jobs else "on a cluster; the machine is the one that started it",
        "cases": "the quick ones only" if outcome.quick else "all",
        "took": f"{outcome.seconds:.0f} s",
    }
    summary = f"<p><strong>{escape(study.question)}</strong></p><p>{escape(study.method)}</p>{_state(outcome.state)}"
    results = _hypotheses_html(outcome) + _figures_html(outcome)
    tables = f"<h2>Measured on</h2>{facts_html(run)}<h2>All rows</h2>{rows_html(rows)}"
    running = outcome.state is not None and outcome.state.remaining is not None
    head = f'<meta http-equiv="refresh" content="{_REFRESH}">' if running else ""
    return page_html(study.name, summary + results + tables, head=head)


def _state(state: RunState | None) -> str:
    """Progress and undecided questions; empty for a run that measured everything at once."""
    if state is None:
        return ""
    sentences = []
    if state.remaining is not None:
        sentences.append(f"Still running: {duration_text(state.remaining)} left.")
    if state.done < state.total:
        sentences.append(f"{state.done} of {state.total} cases are done.")
    if state.known:
        sentences.append(f"{counted(state.known, 'case')} measured by earlier runs.")
    if state.spared:
        sentences.append(f"{counted(state.spared, 'case')} not needed: the result was already settled.")
    undecided = "".join(f"<li>{escape(text)}</li>" for text in state.undecided)
    return f'<p class="note">{escape(" ".join(sentences))}</p>' + (
        f"<h2>Undecided</h2><ul>{undecided}</ul>" if undecided else ""
    )


def _is_partial(state: RunState | None) -> bool:
    return state is not None and state.done < state.total


def _figures_html(outcome: StudyResult) -> str:
    """All diagrams; a note instead while the rows of a partial table do not suffice for them."""
    rows = [row for row in outcome.rows if "problem" not in row]
    try:
        return "".join(figure_html(figure) for figure in outcome.study.figures(rows))
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        if not _is_partial(outcome.state):
            raise
        return f'<p class="note">These rows alone cannot be drawn yet ({escape(repr(error))}).</p>'


def figure_html(figure: Figure | BarChart) -> str:
    """Return a diagram below its title, with its note."""
    note = f'<p class="note">{escape(figure.note)}</p>' if figure.note else ""
    return f"<h2>{escape(figure.title)}</h2>{figure_svg(figure)}{note}"


def judgements(outcome: StudyResult) -> list[dict[str, Cell]]:
    """Return the statement of each hypothesis of the study, the verdict, and the figures behind it."""
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
    """Judgement of a hypothesis; not decided while rows that it needs are missing from a partial table."""
    try:
        return hypothesis.judge(rows)
    except (ArithmeticError, LookupError, TypeError, ValueError):
        if not _is_partial(state):
            raise
        return Judgement(Verdict.NOT_DECIDED, "rows are missing", len(rows))


def _hypotheses_html(outcome: StudyResult) -> str:
    found = judgements(outcome)
    if not found:
        return ""
    rows = "".join(
        f"<dt><strong>{escape(str(row['hypothesis']))}: {escape(str(row['verdict']))}.</strong> "
        f"{escape(str(row['statement']))}</dt>"
        f'<dd class="note">{escape(str(row["figures"]))} (rows: {row["rows"]})</dd>'
        for row in found
    )
    return f"<h2>What was expected</h2><dl>{rows}</dl>"


def _finite_or_none(value: Cell) -> Cell:
    """A value for every table format: NaN and infinity, which JSON lacks, become an empty cell."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
