"""Cases on a Dask cluster of real processes: the table is the serial one although workers die and join."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest

from tactile_maps.core.errors import ClusterError
from tactile_maps.studies.catalogue import load_study
from tactile_maps.studies.running import cluster
from tactile_maps.studies.running.case_run import CaseRun
from tactile_maps.studies.running.cluster import on_cluster

pytestmark = pytest.mark.long

ROOT = Path(__file__).resolve().parents[3]
SECONDS = 60.0
STUDY = "image-cost"
REPEATS = 8
"""Seeds of the study's quick cases."""


@dataclass
class LocalCluster:
    """A scheduler and its workers, each a process of its own."""

    folder: Path
    processes: ExitStack
    address: str = ""

    def start(self, *words: str) -> subprocess.Popen:
        environment = dict(os.environ)
        command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
        process = subprocess.Popen(command, cwd=self.folder, env=environment, stderr=subprocess.DEVNULL)
        self.processes.callback(process.wait)
        self.processes.callback(process.kill)
        return process

    def worker(self) -> subprocess.Popen:
        return self.start("worker", self.address, "--nthreads", "1", "--no-nanny")


@pytest.fixture
def local_cluster(tmp_path):
    pytest.importorskip("distributed")
    with ExitStack() as processes:
        found = LocalCluster(tmp_path, processes)
        file = tmp_path / "scheduler.json"
        found.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        deadline = time.monotonic() + SECONDS
        while not file.exists() or not file.read_text():
            assert time.monotonic() < deadline
            os.sched_yield()
        found.address = json.loads(file.read_text())["address"]
        yield found


def without_times(rows):
    return [{key: value for key, value in row.items() if not key.endswith("ms")} for row in rows]


@pytest.mark.long
def test_table_equals_the_serial_one_although_a_worker_dies_and_one_joins_late(local_cluster):
    study = load_study(STUDY)
    cases = [case for seed in range(REPEATS) for case in study.cases(True, seed)]
    serial = CaseRun("x", study.measure, cases)
    serial.go_on()
    workers = [local_cluster.worker(), local_cluster.worker()]
    reports = []

    def watch(text, share):
        reports.append(text)
        if len(reports) == len(cases) // 4:
            workers[0].kill()
        if len(reports) == len(cases) // 2:
            workers.append(local_cluster.worker())

    sent = psutil.net_io_counters().bytes_sent
    run = CaseRun("x", study.measure, cases, workers=on_cluster(local_cluster.address), progress=watch)
    run.go_on()
    assert workers[0].wait(SECONDS) != 0
    assert len(reports) == len(cases)
    assert without_times(run.rows) == without_times(serial.rows)
    assert (psutil.net_io_counters().bytes_sent - sent) / len(cases) < 100_000


@pytest.mark.long
def test_worker_with_another_program_version_ends_the_run_and_is_named(local_cluster, monkeypatch):
    local_cluster.worker()
    monkeypatch.setattr(cluster, "measuring_program", lambda measure: "another")
    study = load_study(STUDY)
    run = CaseRun("x", study.measure, study.cases(True, 0), workers=on_cluster(local_cluster.address))
    with pytest.raises(ClusterError, match="another version of the program"):
        run.go_on()


def test_missing_scheduler_is_named(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster, "_WAIT", 0.05)
    with pytest.raises(ClusterError, match=r"no scheduler responds \(found: tcp://127.0.0.1:1\)"):
        list(on_cluster("tcp://127.0.0.1:1")(len, [{}]))
