"""Who measures or records what a command is to do many times: ``--jobs`` and ``--cluster``."""

from __future__ import annotations

import argparse
import os

from app.core.errors import UsageError
from app.studies.running.workers import Workers, in_processes


def workers_from_arguments(arguments: argparse.Namespace) -> tuple[int | None, Workers]:
    """How many work at once (None on a cluster, where they come and go), and they.

    Raises:
        UsageError: There are fewer than one.
    """
    if arguments.cluster:
        from app.studies.running.cluster import on_cluster

        return None, on_cluster(arguments.cluster)
    jobs = arguments.jobs or os.cpu_count() or 1
    if jobs < 1:
        raise UsageError("the number of jobs is below one", place="--jobs", value=jobs)
    return jobs, in_processes(jobs)
