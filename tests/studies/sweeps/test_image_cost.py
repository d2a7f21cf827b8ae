"""The image study measures what it says: known errors, all methods, and scipy's numbers as ours."""

from __future__ import annotations

import pytest

from tactile_maps.studies.sweeps.image_cost import FIELDS, METHODS, cases, measure


@pytest.fixture(scope="module")
def rows():
    requested = [case for case in cases(True, 0) if case["taxels"] == 400]
    return [{**case, **row} for case in requested for row in measure(case | {"repeats": 1})]


def error(rows, method, field):
    (found,) = [row[field] for row in rows if row["method"] == method]
    return found


@pytest.mark.long
def test_every_method_is_measured_on_every_field(rows):
    assert [row["method"] for row in rows] == list(METHODS)
    assert all(0 < row[field] < 100 for row in rows for field in FIELDS)
    assert all(0 < row["ms"] <= row["p95_ms"] for row in rows)


def test_barycentric_interpolation_has_the_error_of_scipy_linear(rows):
    for field in FIELDS:
        for theirs in METHODS[-2:]:
            assert error(rows, "barycentric", field) == pytest.approx(error(rows, theirs, field), rel=1e-4)


def test_errors_of_methods_are_ordered_as_predicted(rows):
    assert error(rows, "thin-plate", "smooth") < 0.5 * error(rows, "barycentric", "smooth")
    assert error(rows, "natural-neighbour", "smooth") < 1.2 * error(rows, "barycentric", "smooth")
    assert error(rows, "nearest", "smooth") > 2 * error(rows, "barycentric", "smooth")
