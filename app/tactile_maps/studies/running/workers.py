"""Who measures the cases of a study: this process, or several of this machine.

A ``Workers`` gives the place of each case among ``cases`` and its rows, in whatever order they are finished. Closing it
ends what is still being measured and leaves no process behind.
"""

from __future__ import annotations

import ctypes
import json
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any, TypeAlias

import numpy as np

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.interrupts import interrupts_held
from tactile_maps.studies.base.rows import Case, Measure, Row

_TRIM_EVERY = 20.0
"""[s]"""
Results: TypeAlias = Generator[tuple[int, list[Row]]]
Workers: TypeAlias = Callable[[Measure, Sequence[Case]], Results]


def in_this_process(measure: Measure, cases: Sequence[Case]) -> Results:
    """One after another."""
    yield from ((number, measure_case(measure, case)) for number, case in enumerate(cases))


def in_processes(jobs: int) -> Workers:
    """In so many processes at once, which disturb each other's times; one is this process.

    Cost: about 2 s to start them.
    """
    if jobs == 1:
        return in_this_process
    return lambda measure, cases: _in_processes(measure, cases, jobs)


def measure_case(measure: Measure, case: Case) -> list[Row]:
    """The rows of one case, each begun by the case; one that fails with a named error is a row with a ``problem``.

    Rows are what JSON makes of them: plain numbers, words and lists, so that they are the same whoever measured them
    and wherever they were kept.
    """
    try:
        rows = [{**case, **row} for row in measure(case)]
    except TactileMapsError as error:
        rows = [{**case, "problem": str(error)}]
    plain: list[Row] = json.loads(json.dumps(rows, default=_plain))
    _give_back_memory()
    return plain


_trimmed = time.monotonic()


def _give_back_memory() -> None:
    """Every few seconds, where the C library can: what is freed stays with the process otherwise, between what is not.

    A process that had measured 500 cases of path time held 3 GB, of which it used a tenth. Cost: 20 ms.
    """
    global _trimmed
    if sys.platform == "linux" and time.monotonic() - _trimmed > _TRIM_EVERY:
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's
        if trim is not None:
            trim(0)
        _trimmed = time.monotonic()


def _plain(value: Any) -> Any:
    """A number of NumPy as Python has it."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a row holds a {type(value).__name__}: rows are made of numbers, words and None")


def _in_processes(measure: Measure, cases: Sequence[Case], jobs: int) -> Results:
    found: Results | None = None
    with warnings.catch_warnings():
        # A process that has loaded much, such as three robots, is replaced by a fresh one, which is no surprise either.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        try:
            with _starting_processes():
                from joblib import Parallel, delayed
                from joblib.externals.loky import get_reusable_executor
                from joblib.externals.loky.backend import resource_tracker as lokys

                for tracker in (resource_tracker, lokys):
                    tracker.ensure_running()
                _block_interrupts()  # both trackers end their start by letting them through: workers would get them
                parallel = Parallel(n_jobs=jobs, return_as="generator_unordered")
                found = parallel(delayed(_numbered)(measure, number, case) for number, case in enumerate(cases))
            for result in found:  # noqa: UP028 - "yield from" would close it before the guard below
                yield result
        finally:
            with _starting_processes(), warnings.catch_warnings():
                # Cases that are cancelled are no surprise here.
                warnings.simplefilter("ignore", UserWarning)
                if found is not None:
                    found.close()
                    get_reusable_executor().shutdown(wait=True, kill_workers=True)


def _numbered(measure: Measure, number: int, case: Case) -> tuple[int, list[Row]]:
    return number, measure_case(measure, case)


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
    """Block the signals that a terminal sends to all its processes, and return those that were blocked before; None
    where the system has no such mask.
    """
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        return None
    return signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP, signal.SIGQUIT})
