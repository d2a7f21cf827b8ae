"""Cases measured in this process or in workers: failures, order and stored rows."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.studies.running.workers import in_processes, in_this_process, measure_case

CASES = [{"number": k} for k in range(6)]


def squares(case):
    if case["number"] == 4:
        raise MapError("four is not allowed", value=4)
    return [{"square": case["number"] ** 2}] * (2 if case["number"] == 2 else 1)


def broken(case):
    raise ZeroDivisionError


def numpys(case):
    return [{"a": np.float64(0.1), "b": np.int64(3), "c": np.bool_(True), "d": (1, 2), "e": float("inf")}]


@pytest.mark.long
@pytest.mark.parametrize("jobs", [1, 2])
def test_results_carry_their_index_and_failures_stop_no_other_case(jobs):
    found = dict(in_processes(jobs)(squares, CASES))
    assert [row["number"] for number in range(6) for row in found[number]] == [0, 1, 2, 2, 3, 4, 5]
    assert found[3] == [{"number": 3, "square": 9}]
    assert found[4] == [{"number": 4, "problem": "four is not allowed (found: 4)."}]


@pytest.mark.long
@pytest.mark.parametrize("jobs", [1, 2])
def test_unexpected_errors_are_raised(jobs):
    with pytest.raises(ZeroDivisionError):
        list(in_processes(jobs)(broken, CASES))


def test_rows_have_plain_types_and_exact_values():
    [row] = measure_case(numpys, {})
    assert row == {"a": 0.1, "b": 3, "c": True, "d": [1, 2], "e": float("inf")}
    assert {type(cell) for cell in row.values()} == {float, int, bool, list}


def test_row_of_another_type_is_rejected():
    with pytest.raises(TypeError, match="a row contains a object"):
        list(in_this_process(lambda case: [{"thing": object()}], CASES))
