"""Runs of cases: one table whatever the workers, interruptions and order; no case measured twice."""

from __future__ import annotations

import time
from contextlib import closing

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.studies.running.case_log import CaseLog
from tactile_maps.studies.running.case_run import CaseRun, duration_text, paced, run_cases
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
    return run_cases(squares, CASES, progress=lambda text, share: None)


def backwards(measure, cases):
    yield from ((number, measure_case(measure, cases[number])) for number in reversed(range(len(cases))))


def test_rows_come_in_the_order_of_the_cases_with_their_case():
    assert [row["number"] for row in whole()] == [0, 1, 2, 2, 3, 4, 5]
    for workers in (backwards, in_processes(2)):
        run = CaseRun("x", squares, CASES, workers=workers)
        run.go_on()
        assert run.rows == whole()


def test_progress_tells_case_share_and_what_remains():
    told = []
    run_cases(squares, CASES, progress=lambda text, share: told.append((text, share)))
    assert [share for _, share in told] == pytest.approx([k / 6 for k in range(1, 7)])
    assert told[3][0].startswith("3 number; ")
    assert told[3][0].endswith(" s left")


@pytest.mark.parametrize("workers", [in_processes(1), in_processes(2), backwards])
def test_an_interrupted_run_goes_on_where_it_was(tmp_path, workers):
    expected = whole()
    told = []

    def stop(text, share):
        told.append(text)
        if len(told) == 2:
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


def test_a_case_that_failed_is_asked_again(tmp_path):
    FAILS.add(3)
    with closing(CaseLog(tmp_path / "x")) as log:
        CaseRun("x", squares, CASES, log=log).go_on()
        FAILS.clear()
        MEASURED.clear()
        run = CaseRun("x", squares, CASES, log=log)
        run.go_on()
        assert MEASURED == [3]
        assert run.rows == whole()


def test_time_that_is_over_ends_it_with_what_is_done():
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


def test_durations_as_one_says_them():
    assert [duration_text(s) for s in (3, 600, 7200)] == ["3 s", "10 min", "2.0 h"]


def test_what_is_paced_happens_now_and_then_and_takes_its_share_at_most(monkeypatch):
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
