"""Cases measured by the workers of a Dask cluster: machines that come and go while the run goes on.

Only a case travels to a worker (some hundred bytes) and only its rows back: robot, skin and map are made there, from
the case, and kept on that machine (``tactile_maps.session.prepared_cache``).
A worker that dies has its cases measured by
another; one that joins late takes its share. Each answer says which program measured it: a worker with another version
of it ends the run by name, as its rows would be of another study.
"""

from __future__ import annotations

import logging
import platform
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

from tactile_maps.core.errors import ClusterError
from tactile_maps.studies.base.rows import Case, Measure, Row
from tactile_maps.studies.running.case_log import measuring_program
from tactile_maps.studies.running.workers import Results, Workers, measure_case

_WAIT = 15.0
"""For the scheduler, and for the first worker [s]."""
_START = "Start 'dask scheduler' there and 'dask worker ADDRESS --nthreads 1' on each machine, or check the address"
_RESUME = "What is done is kept: --resume goes on with it"
_one_at_a_time = threading.Lock()
"""Measurements share what a process keeps: a worker with several threads takes one after another."""


def on_cluster(address: str) -> Workers:
    """The workers of the scheduler at ``address``, as ``tcp://host:8786``.

    A case over which several workers died (three, if the scheduler is not told otherwise) is a row with a ``problem``.
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
                future.release()  # neither scheduler nor worker keeps what is known here
        finally:
            client.cancel(futures)


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A client of the scheduler, once it has a worker.

    Raises:
        ClusterError: The package is missing, nothing answers there, or no worker is there.
    """
    try:
        from distributed import Client
    except ImportError as error:
        remedy = "pip install 'tactile-maps[cluster]'"
        raise ClusterError(
            "a cluster needs a package that is not installed", value=error.name, remedy=remedy
        ) from error
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it would print is raised here by name
    try:
        client = Client(address, timeout=_WAIT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError("no scheduler answers", place="--cluster", value=address, remedy=_START) from error
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
    """What a worker answered.

    Raises:
        ClusterError: It has no program or another one, or the scheduler has gone.
        Exception: The case failed by no named error.
    """
    from distributed import KilledWorker

    try:
        rows: list[Row] = future.result()
    except KilledWorker:
        return [{**case, "problem": "The workers that measured it died, several one after another."}]
    except CancelledError as error:
        raise ClusterError("the scheduler has gone", remedy=_RESUME) from error
    except ImportError as error:
        remedy = "Install the same program on every machine"
        raise ClusterError("a worker has not what measures", value=error, remedy=remedy) from error
    return rows
