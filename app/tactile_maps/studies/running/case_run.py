"""One run of the cases of a study: what is known is not measured again, and what is measured is kept as it comes.

The table is the same, row by row, whatever the workers, their number, and how often the run was interrupted and gone on
with: rows stand in the order of the cases, and everything random in a measurement comes from its case.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing

from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.studies.base.rows import Case, Measure, Row
from tactile_maps.studies.running.case_log import CaseLog, case_key
from tactile_maps.studies.running.workers import Workers, in_processes, in_this_process


def run_cases(measure: Measure, cases: Sequence[Case], *, jobs: int = 1, progress: Progress) -> list[Row]:
    """The rows of all cases, in the order of the cases, whatever the number of jobs.

    A case that fails with a named error becomes a row that says so under ``problem``; the others go on.

    Args:
        measure: Of one case; known to other processes by name, so a function of a module. Everything random in it comes
            from the case.
        cases: What to measure; a case's keys begin its rows.
        jobs: Processes; with more than one they disturb each other's times.
        progress: Told each finished case; may raise to cancel, as may Ctrl-C. No process is left behind.

    Cost: about 2 s to start the processes.
    """
    run = CaseRun(measure.__qualname__, measure, cases, workers=in_processes(jobs), progress=progress)
    run.go_on()
    return run.rows


class CaseRun:
    """Cases, those that are done, and who measures the others.

    Attributes:
        cases: All of them.
        known: How many were done before.
    """

    def __init__(
        self,
        name: str,
        measure: Measure,
        cases: Sequence[Case],
        *,
        workers: Workers = in_this_process,
        log: CaseLog | None = None,
        progress: Progress = no_progress,
        watch: Callable[[], None] = lambda: None,
        holds: Callable[[Sequence[Row]], bool] = lambda rows: True,
    ) -> None:
        """Take what the log holds as done; a case that failed is not, and is measured again.

        Args:
            name: Of the study.
            measure: Of one case.
            cases: What to measure.
            workers: Who measures.
            log: Where cases are kept; without one they are lost with the program.
            progress: Told each finished case and the time that remains.
            watch: Called after each finished case.
            holds: Whether the rows of a case that is done are still true, as of a file that may be gone.
        """
        self.cases = cases
        self._measure = measure
        self._workers = workers
        self._log = log
        self._progress = progress
        self._watch = watch
        self._keys = [case_key(name, measure, case) for case in cases] if log is not None else []
        done = log.done if log is not None else {}
        kept = {n: done[key] for n, key in enumerate(self._keys) if key in done}
        self._rows = {n: rows for n, rows in kept.items() if not _failed(rows) and holds(rows)}
        self.known = len(self._rows)
        self._began = time.monotonic()

    @property
    def rows(self) -> list[Row]:
        """Of the cases that are done, in the order of the cases."""
        return [row for number in sorted(self._rows) for row in self._rows[number]]

    @property
    def done(self) -> int:
        """How many cases."""
        return len(self._rows)

    @property
    def remaining(self) -> float | None:
        """How long the others take at the pace of those measured so far [s]; None while there is none."""
        measured = self.done - self.known
        return (len(self.cases) - self.done) * (time.monotonic() - self._began) / measured if measured else None

    @property
    def missing(self) -> list[int]:
        """Places of the cases that are not done."""
        return [number for number in range(len(self.cases)) if number not in self._rows]

    def go_on(self, numbers: Sequence[int] | None = None, *, until: float | None = None) -> None:
        """Measure cases that are not done.

        Args:
            numbers: Their places among the cases, in the order in which they begin; by default all.
            until: When to stop, by ``time.monotonic``: what is still being measured then is given up.

        Raises:
            TactileMapsError: A case cannot be kept.
            Exception: A case failed by no named error.
        """
        asked = range(len(self.cases)) if numbers is None else numbers
        wanted = [number for number in asked if number not in self._rows]
        if not wanted or _is_over(until):
            return
        with closing(self._workers(self._measure, [self.cases[number] for number in wanted])) as results:
            for place, rows in results:
                self._finish(wanted[place], rows)
                if _is_over(until):
                    return

    def _finish(self, number: int, rows: list[Row]) -> None:
        self._rows[number] = rows
        if self._log is not None:
            self._log.keep(self._keys[number], rows)
        left = duration_text(self.remaining or 0.0)
        self._progress(f"{_case_title(self.cases[number])}; {left} left", self.done / len(self.cases))
        self._watch()


def _is_over(until: float | None) -> bool:
    return until is not None and time.monotonic() >= until


def _failed(rows: Sequence[Row]) -> bool:
    return any("problem" in row for row in rows)


def _case_title(case: Case) -> str:
    return ", ".join(f"{value}" if isinstance(value, str) else f"{value} {key}" for key, value in case.items())


def duration_text(seconds: float) -> str:
    """A time as one says it: 40 s, 12 min, 3.5 h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def paced(write: Callable[[], object], *, least: float = 5.0, share: float = 0.02) -> Callable[[], None]:
    """``write``, which is called as often as one likes and happens now and then.

    Args:
        write: What is to happen.
        least: Between two times [s]; also before the first.
        share: Of the time that it may take at most.
    """
    due = time.monotonic() + least

    def now_and_then() -> None:
        nonlocal due
        began = time.monotonic()
        if began >= due:
            write()
            spent = time.monotonic() - began
            due = began + spent + max(least, spent / share)

    return now_and_then
