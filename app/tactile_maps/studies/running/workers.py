"""Workers that measure the cases of a study: this process, or several processes of this machine.

``Workers`` yields the index of each case in ``cases`` and its rows, in the order in which they finish. Closing it
cancels unfinished measurements and leaves no process behind.
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
"""Time between two trims [s]."""
Results: TypeAlias = Generator[tuple[int, list[Row]]]
Workers: TypeAlias = Callable[[Measure, Sequence[Case]], Results]


def in_this_process(measure: Measure, cases: Sequence[Case]) -> Results:
    """Measure one case after another."""
    yield from ((number, measure_case(measure, case)) for number, case in enumerate(cases))


def in_processes(jobs: int) -> Workers:
    """Return workers in the given number of processes, of which this is one; they distort each other's times.

    Cost: about 2 s to start them.
    """
    if jobs == 1:
        return in_this_process
    return lambda measure, cases: _in_processes(measure, cases, jobs)


def measure_case(measure: Measure, case: Case) -> list[Row]:
    """Return the rows of one case, each preceded by the case; a TactileMapsError becomes a row with a ``problem``.

    Rows are converted to plain JSON values (numbers, words and lists), so that they do not depend on the worker or on
    the storage.
    """
    try:
        rows = [{**case, **row} for row in measure(case)]
    except TactileMapsError as error:
        rows = [{**case, "problem": str(error)}]
    plain: list[Row] = json.loads(json.dumps(rows, default=_plain))
    _release_memory()
    return plain


_trimmed = time.monotonic()


def _release_memory() -> None:
    """Return freed memory to the system every few seconds, where the C library supports it. Cost: 20 ms.

    Otherwise a fragmented heap stays with the process: after 500 cases of path time it had 3 GB and used a tenth.
    """
    global _trimmed
    if sys.platform == "linux" and time.monotonic() - _trimmed > _TRIM_EVERY:
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's
        if trim is not None:
            trim(0)
        _trimmed = time.monotonic()


def _plain(value: Any) -> Any:
    """Convert a NumPy value to a plain Python value."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a row contains a {type(value).__name__}: rows consist of numbers, words and None")


def _in_processes(measure: Measure, cases: Sequence[Case], jobs: int) -> Results:
    found: Results | None = None
    with warnings.catch_warnings():
        # joblib replaces a process that has loaded much, such as three robots, by a fresh one: expected.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        try:
            with _starting_processes():
                from joblib import Parallel, delayed
                from joblib.externals.loky import get_reusable_executor
                from joblib.externals.loky.backend import resource_tracker as lokys

                for tracker in (resource_tracker, lokys):
                    tracker.ensure_running()
                _block_interrupts()  # the start of a tracker unblocks interrupts; workers would receive them
                parallel = Parallel(n_jobs=jobs, return_as="generator_unordered")
                found = parallel(delayed(_numbered)(measure, number, case) for number, case in enumerate(cases))
            for result in found:  # noqa: UP028 - "yield from" would close it before the guard below
                yield result
        finally:
            with _starting_processes(), warnings.catch_warnings():
                # Cancelled cases are expected here.
                warnings.simplefilter("ignore", UserWarning)
                if found is not None:
                    found.close()
                    get_reusable_executor().shutdown(wait=True, kill_workers=True)


def _numbered(measure: Measure, number: int, case: Case) -> tuple[int, list[Row]]:
    return number, measure_case(measure, case)


@contextmanager
def _starting_processes() -> Generator[None]:
    """Delay Ctrl-C to the end of the block, because joblib loses it while it starts and stops its processes.

    Processes that start in the block never receive Ctrl-C, which a terminal sends to all; each would print a traceback.
    """
    with interrupts_held():
        mask = _block_interrupts()
        try:
            yield
        finally:
            if mask is not None:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _block_interrupts() -> set[int | signal.Signals] | None:
    """Block the signals that a terminal sends to all its processes; return those that were blocked before.

    None on systems without a signal mask.
    """
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        return None
    return signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP, signal.SIGQUIT})
