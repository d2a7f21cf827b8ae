"""Cases of a study: in order, with their failures, in one process or several."""

from __future__ import annotations

import pytest

from app.core.errors import MapError
from app.studies.study import run_cases

CASES = [{"number": k} for k in range(6)]


def squares(case):
    if case["number"] == 4:
        raise MapError("four is not allowed", value=4)
    return (
        [{"square": case["number"] ** 2}, {"square": None}]
        if case["number"] == 2
        else [{"square": case["number"] ** 2}]
    )


def broken(case):
    raise ZeroDivisionError


@pytest.mark.parametrize("jobs", [1, 2])
def test_rows_come_in_order_with_their_case_and_progress(jobs):
    told = []
    rows = run_cases(squares, CASES, jobs=jobs, progress=lambda text, share: told.append((text, share)))
    assert [row["number"] for row in rows] == [0, 1, 2, 2, 3, 4, 5]
    assert [row.get("square") for row in rows] == [0, 1, 4, None, 9, None, 25]
    assert [share for _, share in told] == pytest.approx([k / 6 for k in range(1, 7)])
    assert told[3][0] == "3 number"


def test_a_named_failure_is_a_row_and_the_others_go_on():
    rows = run_cases(squares, CASES, progress=lambda text, share: None)
    problems = [row["problem"] for row in rows if "problem" in row]
    assert problems == ["four is not allowed (found: 4)."]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_not_a_named_failure_is_not_hidden(jobs):
    with pytest.raises(ZeroDivisionError):
        run_cases(broken, CASES, jobs=jobs, progress=lambda text, share: None)


@pytest.mark.parametrize("jobs", [1, 2])
def test_progress_may_cancel(jobs):
    told = []

    def stop(text, share):
        told.append(text)
        if len(told) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_cases(squares, CASES, jobs=jobs, progress=stop)
    assert len(told) == 2
