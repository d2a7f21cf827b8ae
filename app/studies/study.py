"""A study: one question, the cases to ask it of, how to measure one, and how to draw the answer.

Studies of a stage of the program (``map_cost``, ``image_cost``, ``touch_cost``, ``step_cost``) try the stage's settings
on subjects whose truth is known; what they measure by are the stage's own trials, and their rows are those.

``run_cases`` measures the cases in this process or in several and puts their rows in one table, in the order of the
cases whatever the number of processes. Everything random in a measurement comes from its case.
"""

from __future__ import annotations

import signal
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker

from app.core.errors import TactileMapsError
from app.core.interrupts import interrupts_held
from app.core.progress import Progress
from app.studies.figures import BarChart, Figure
from app.studies.rows import Case, Row

Measure = Callable[[Case], Sequence[Row]]


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
    rows: list[Row] = []
    with warnings.catch_warnings(), closing(_each_result(measure, cases, jobs)) as results:
        # A process that has loaded much, such as three robots, is replaced by a fresh one, which is no surprise either.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        for number, found in enumerate(results):
            rows += found
            progress(_case_title(cases[number]), (number + 1) / len(cases))
    return rows


def _each_result(measure: Measure, cases: Sequence[Case], jobs: int) -> Generator[Sequence[Row]]:
    if jobs == 1:
        yield from (_measure_case(measure, case) for case in cases)
        return
    found: Generator[list[Row]] | None = None
    try:
        with _starting_processes():
            from joblib import Parallel, delayed
            from joblib.externals.loky import get_reusable_executor
            from joblib.externals.loky.backend import resource_tracker as lokys

            for tracker in (resource_tracker, lokys):
                tracker.ensure_running()
            _block_interrupts()  # both trackers end their start by letting them through: workers would get them
            parallel = Parallel(n_jobs=jobs, return_as="generator")
            found = parallel(delayed(_measure_case)(measure, case) for case in cases)
        for rows in found:  # noqa: UP028 - "yield from" would close it before the guard below
            yield rows
    finally:
        with _starting_processes(), warnings.catch_warnings():
            # Cases that are cancelled are no surprise here.
            warnings.simplefilter("ignore", UserWarning)
            if found is not None:
                found.close()
                get_reusable_executor().shutdown(wait=True, kill_workers=True)


@contextmanager
def _starting_processes() -> Generator[None]:
    """Ctrl-C comes after the block: joblib loses it while it starts and ends its processes.

    Processes that are started in it never see Ctrl-C, which a terminal sends to all: each would print where it was.
    """
    with interrupts_held():
        mask = _block_interrupts()
        try:
            yield
        finally:
            if mask is not None:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _block_interrupts() -> set[int | signal.Signals] | None:
    """Interrupts wait; which signals waited before, None where the system knows no such thing."""
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        return None
    return signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _measure_case(measure: Measure, case: Case) -> list[Row]:
    try:
        return [{**case, **row} for row in measure(case)]
    except TactileMapsError as error:
        return [{**case, "problem": str(error)}]


def _case_title(case: Case) -> str:
    return ", ".join(f"{value}" if isinstance(value, str) else f"{value} {key}" for key, value in case.items())


@dataclass(frozen=True)
class Study:
    """One question.

    Attributes:
        name: As the user writes it.
        question: What is asked, in one sentence.
        method: How it is measured, in a few sentences for the report.
        cases: What to measure, for ``quick`` (a minute's worth, for trying out) and a seed.
        measure: The rows of one case; in any process.
        figures: The diagrams of all rows.
    """

    name: str
    question: str
    method: str
    cases: Callable[[bool, int], Sequence[Case]]
    measure: Measure
    figures: Callable[[Sequence[Row]], Sequence[Figure | BarChart]]
