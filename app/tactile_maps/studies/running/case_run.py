"""A run of the cases of a study: known cases are not measured again, and results are stored as they arrive.

The table is the same, row by row, for any workers, any number of them and any interruptions: rows are in the order of
the cases, and all random numbers of a measurement depend only on its case.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing

from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.studies.base.rows import Case, Measure, Row
from tactile_maps.studies.running.case_log import CaseLog, case_key
from tactile_maps.studies.running.workers import Workers, in_this_process


class CaseRun:
    """Cases, their rows so far, and the workers that measure the others.

    A case that fails with a TactileMapsError becomes a row with a ``problem``; the other cases continue.

    Attributes:
        cases: All cases.
        known: Number of cases that were finished before.
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
        """Take over finished cases from the log, except failed ones, which are measured again.

        Args:
            name: Name of the study.
            measure: Measures one case: a function of a module, which other processes find by name. Its random numbers
                depend only on the case.
            cases: Cases to measure; the keys of a case are the first columns of its rows.
            workers: Workers that measure.
            log: Stores the cases; without one they are lost at the end of the program.
            progress: Receives each finished case and the remaining time; may raise to cancel.
            watch: Called after each finished case.
            holds: Whether the rows of a finished case are still valid; they may describe a file that was removed.
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
        """Rows of the finished cases, in the order of the cases."""
        return [row for number in sorted(self._rows) for row in self._rows[number]]

    @property
    def done(self) -> int:
        """Number of finished cases."""
        return len(self._rows)

    @property
    def remaining(self) -> float | None:
        """Estimated time for the other cases at the present pace [s]; None before the first measurement."""
        measured = self.done - self.known
        return (len(self.cases) - self.done) * (time.monotonic() - self._began) / measured if measured else None

    @property
    def missing(self) -> list[int]:
        """Indices of the unfinished cases."""
        return [number for number in range(len(self.cases)) if number not in self._rows]

    def go_on(self, numbers: Sequence[int] | None = None, *, until: float | None = None) -> None:
        """Measure unfinished cases.

        Args:
            numbers: Indices of the cases in the order in which they begin; all by default.
            until: Time to stop, by ``time.monotonic``; unfinished measurements are abandoned.

        Raises:
            TactileMapsError: A case cannot be stored.
            Exception: A case failed with another error.
        """
        pending = [n for n in (range(len(self.cases)) if numbers is None else numbers) if n not in self._rows]
        if not pending or _is_over(until):
            return
        with closing(self._workers(self._measure, [self.cases[number] for number in pending])) as results:
            for place, rows in results:
                self._finish(pending[place], rows)
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
    """Return a duration as text: 40 s, 12 min, 3.5 h."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def paced(write: Callable[[], object], *, least: float = 5.0, share: float = 0.02) -> Callable[[], None]:
    """Return a function that may be called often and calls ``write`` occasionally.

    Args:
        write: Function to call.
        least: Minimum time between two calls, and before the first [s].
        share: Maximum share of the time that the calls may take.
    """
    due = time.monotonic() + least

    def write_if_due() -> None:
        nonlocal due
        began = time.monotonic()
        if began >= due:
            write()
            spent = time.monotonic() - began
            due = began + spent + max(least, spent / share)

    return write_if_due
