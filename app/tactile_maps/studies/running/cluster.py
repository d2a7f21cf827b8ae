"""Cases measured by the workers of a Dask cluster, which machines may join and leave during the run.

Only a case (some hundred bytes) is sent to a worker, and only its rows are sent back. The worker creates robot, skin
and map from the case and keeps them (``tactile_maps.session.prepared_cache``). The cases of a worker that dies are
measured by another one; a worker that joins late receives cases too. A worker with another version of the program ends
the run with an error, because its rows would belong to another study.
"""

from __future__ import annotations

import logging
import platform
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

from tactile_maps.core.errors import ClusterError, install_line
from tactile_maps.studies.base.rows import Case, Measure, Row
from tactile_maps.studies.running.case_log import measuring_program
from tactile_maps.studies.running.workers import Results, Workers, measure_case

_WAIT = 15.0
"""Maximum wait for the scheduler, and for the first worker [s]."""
_START = "Start 'dask scheduler' there and 'dask worker ADDRESS --nthreads 1' on each machine, or check the address"
_RESUME = "Finished cases are stored: continue with --resume"
_one_at_a_time = threading.Lock()
"""Measurements share caches of their process, so a worker with several threads runs one at a time."""


def on_cluster(address: str) -> Workers:
    """Return the workers of the scheduler at ``address``, for example ``tcp://host:8786``.

    A case during which several workers died (three by default of the scheduler) becomes a row with a ``problem``.
    """
    return lambda measure, cases: _on_cluster(address, measure, cases)


def _on_cluster(address: str, measure: Measure, cases: Sequence[Case]) -> Results:
    with _connected(address) as client:
        from distributed import as_completed

        program = measuring_program(measure)
        futures = client.map(_measure_there, [(measure, case, program) for case in cases], pure=False)
        numbers = {future.key: number for number, future in enumerate(futures)}
        try:
            for future in as_completed(futures, loop=client.loop):
                number = numbers[future.key]
                yield number, _rows_of(future, cases[number])
                future.release()  # the rows are stored here, so scheduler and worker need not keep them
        finally:
            client.cancel(futures)


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """Connect to the scheduler and wait for a worker.

    Raises:
        ClusterError: The package is missing, no scheduler responds, or it has no worker.
    """
    try:
        from distributed import Client
    except ImportError as error:
        remedy = install_line("cluster")
        raise ClusterError(
            "a cluster needs a package that is not installed", value=error.name, remedy=remedy
        ) from error
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # its messages are raised as errors here
    try:
        client = Client(address, timeout=_WAIT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError("no scheduler responds", place="--cluster", value=address, remedy=_START) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_WAIT)
        except TimeoutError as error:
            raise ClusterError(
                "the scheduler has no worker", place="--cluster", value=address, remedy=_START
            ) from error
        yield client


def _measure_there(task: tuple[Measure, Case, str]) -> list[Row]:
    measure, case, program = task
    if measuring_program(measure) != program:
        remedy = "Install the same program, Python and libraries on every machine"
        raise ClusterError("this worker has another version of the program", value=platform.node(), remedy=remedy)
    with _one_at_a_time:
        return measure_case(measure, case)


def _rows_of(future: Any, case: Case) -> list[Row]:
    """Rows from a worker.

    Raises:
        ClusterError: The worker has no or another program, or the scheduler has stopped.
        Exception: The case failed with another error.
    """
    from distributed import KilledWorker

    try:
        rows: list[Row] = future.result()
    except KilledWorker:
        return [{**case, "problem": "Several workers in succession died while measuring it."}]
    except CancelledError as error:
        raise ClusterError("the scheduler has stopped", remedy=_RESUME) from error
    except ImportError as error:
        remedy = "Install the same program on every machine"
        raise ClusterError("a worker cannot import the measurement", value=error, remedy=remedy) from error
    return rows
