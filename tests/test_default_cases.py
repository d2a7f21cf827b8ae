"""The default run contains a case of every test, and of a rotating test every value."""

from __future__ import annotations

from itertools import product

import pytest

from tests.support.default_cases import covering


@pytest.mark.parametrize("sizes", [(1,), (4,), (2, 5), (3, 3), (2, 3, 7)])
def test_cases_cover_every_value_with_as_few_cases_as_the_longest_list(sizes):
    cases = [set(enumerate(case)) for case in product(*map(range, sizes))]
    chosen = covering(cases)
    assert len(chosen) == max(sizes)
    assert set.union(*(cases[number] for number in chosen)) == set.union(*cases)


def test_values_are_combined_in_turn():
    cases = [set(enumerate(case)) for case in product(range(2), range(6))]
    first = [dict(cases[number])[0] for number in covering(cases)]
    assert sorted(first) == [0, 0, 0, 1, 1, 1]


@pytest.mark.rotating
@pytest.mark.parametrize("word", ["a", "b", "c"])
@pytest.mark.parametrize(("number", "values"), [(1, [1]), (2, [2])])
def test_rotating_test_runs_with_every_value(request, word, number, values):
    cases = [item for item in request.session.items if item.originalname == request.node.originalname]
    assert len(cases) >= 3
    assert values == [number]
    assert word in "abc"
