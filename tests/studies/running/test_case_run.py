"""Runs of cases: one table whatever the workers, interruptions and order; no case measured twice."""

from __future__ import annotations

import time
from contextlib import closing

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.studies.running.case_log import CaseLog
from tactile_maps.studies.running.case_run import CaseRun, duration_text, paced
from tactile_maps.studies.running.workers import in_processes, measure_case

CASES = [{"number": k} for k in range(6)]
MEASURED: list[int] = []
FAILS: set[int] = set()


def squares(case):
    MEASURED.append(case["number"])
    if case["number"] in FAILS:
        raise MapError("not allowed")
    return [{"square": case["number"] ** 2 / 7}] * (2 if case["number"] == 2 else 1)


@pytest.fixture(autouse=True)
def nothing_measured():
    MEASURED.clear()
    FAILS.clear()


def whole():
    run = CaseRun("x", squares, CASES)
    run.go_on()
    return run.rows


def backwards(measure, cases):
    yield from ((number, measure_case(measure, cases[number])) for number in reversed(range(len(cases))))


@pytest.mark.long
def test_rows_are_in_the_order_of_the_cases_and_contain_them():
    assert [row["number"] for row in whole()] == [0, 1, 2, 2, 3, 4, 5]
    for workers in (backwards, in_processes(2)):
        run = CaseRun("x", squares, CASES, workers=workers)
        run.go_on()
        assert run.rows == whole()


def test_progress_reports_case_share_and_remaining_time():
    reports = []
    CaseRun("x", squares, CASES, progress=lambda text, share: reports.append((text, share))).go_on()
    assert [share for _, share in reports] == pytest.approx([k / 6 for k in range(1, 7)])
    assert reports[3][0].startswith("3 number; ")
    assert reports[3][0].endswith(" s left")


@pytest.mark.parametrize("workers", [in_processes(1), in_processes(2), backwards])
def test_interrupted_runs_continue(tmp_path, workers):
    expected = whole()
    reports = []

    def stop(text, share):
        reports.append(text)
        if len(reports) == 2:
            raise KeyboardInterrupt

    with closing(CaseLog(tmp_path / "x")) as log:
        run = CaseRun("x", squares, CASES, workers=workers, log=log, progress=stop)
        with pytest.raises(KeyboardInterrupt):
            run.go_on()
    assert run.done == 2
    with closing(CaseLog(tmp_path / "x", resume=True)) as log:
        MEASURED.clear()
        again = CaseRun("x", squares, CASES, log=log)
        assert (again.known, again.rows) == (2, run.rows)
        again.go_on()
        assert again.rows == expected
        assert len(MEASURED) == 4
        MEASURED.clear()
        CaseRun("x", squares, CASES, log=log).go_on()
        assert MEASURED == []


def test_failed_cases_are_repeated(tmp_path):
    FAILS.add(3)
    with closing(CaseLog(tmp_path / "x")) as log:
        CaseRun("x", squares, CASES, log=log).go_on()
        FAILS.clear()
        MEASURED.clear()
        run = CaseRun("x", squares, CASES, log=log)
        run.go_on()
        assert MEASURED == [3]
        assert run.rows == whole()


def test_expired_time_keeps_finished_cases():
    run = CaseRun("x", squares, CASES)
    run.go_on(until=time.monotonic() - 1)
    assert (run.done, run.missing) == (0, [0, 1, 2, 3, 4, 5])
    run.go_on([])
    assert run.done == 0
    run = CaseRun("x", squares, CASES, progress=lambda text, share: None)
    run.go_on([4, 1], until=time.monotonic() + 100)
    assert MEASURED == [4, 1]
    assert [row["number"] for row in run.rows] == [1, 4]
    assert run.remaining is not None


def test_durations_are_readable():
    assert [duration_text(s) for s in (3, 600, 7200)] == ["3 s", "10 min", "2.0 h"]


def test_paced_calls_are_limited_to_their_share(monkeypatch):
    now = 0.0
    written = []
    monkeypatch.setattr(time, "monotonic", lambda: now)

    def write():
        nonlocal now
        written.append(now)
        now += 1.0

    offer = paced(write, least=5.0, share=0.02)
    while now < 120:
        offer()
        now += 1.0
    assert written == [5.0, 56.0, 107.0]
