"""Who measures, as the command line says it."""

from __future__ import annotations

import os
from argparse import Namespace

import pytest

from tactile_maps.cli.shared.workers import workers_from_arguments
from tactile_maps.core.errors import UsageError
from tactile_maps.studies.running.workers import in_this_process


def test_jobs_are_processes_and_zero_means_one_per_core():
    assert workers_from_arguments(Namespace(jobs=1, cluster=None)) == (1, in_this_process)
    assert workers_from_arguments(Namespace(jobs=0, cluster=None))[0] == os.cpu_count()
    for jobs in (-1, 1025):
        with pytest.raises(UsageError, match="--jobs: the number of jobs is out of range.*1 to 1024"):
            workers_from_arguments(Namespace(jobs=jobs, cluster=None))


def test_number_of_workers_of_a_cluster_is_unknown():
    assert workers_from_arguments(Namespace(jobs=1, cluster="tcp://127.0.0.1:1"))[0] is None
