"""Workers of a command that measures or records many cases: ``--jobs`` and ``--cluster``."""

from __future__ import annotations

import argparse
import os

from tactile_maps.core.errors import UsageError
from tactile_maps.studies.running.workers import Workers, in_processes

MOST_JOBS = 1024


def workers_from_arguments(arguments: argparse.Namespace) -> tuple[int | None, Workers]:
    """Return the number of parallel jobs (None on a cluster, where it varies) and the workers.

    Raises:
        UsageError: The number is out of range.
    """
    if arguments.cluster:
        from tactile_maps.studies.running.cluster import on_cluster

        return None, on_cluster(arguments.cluster)
    jobs = arguments.jobs or os.cpu_count() or 1
    if not 1 <= jobs <= MOST_JOBS:
        remedy = f"Choose 1 to {MOST_JOBS}, or 0 for all processors"
        raise UsageError("the number of jobs is out of range", place="--jobs", value=jobs, remedy=remedy)
    return jobs, in_processes(jobs)
