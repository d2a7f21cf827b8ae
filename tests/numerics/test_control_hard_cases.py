"""Control in hard cases: postures, environments, sensing, wrong maps, events; each group says what must come of it."""

from __future__ import annotations

import pytest

from tests.numerics import (
    hard_control_environments,
    hard_control_events,
    hard_control_maps,
    hard_control_postures,
    hard_control_sensing,
)
from tests.numerics.hard_control import check, check_repeats, runs

GROUPS = (
    hard_control_postures, hard_control_environments, hard_control_sensing, hard_control_maps, hard_control_events,
)  # fmt: skip
CASES = {name: case for group in GROUPS for name, case in group.CASES.items()}


def test_every_case_has_a_name_of_its_own():
    assert len(CASES) == sum(len(group.CASES) for group in GROUPS)


@pytest.mark.parametrize(("name", "law"), runs(CASES))
def test_the_stated_outcome_comes(name, law):
    check(CASES[name], law)


@pytest.mark.parametrize("name", CASES)
def test_the_same_again_gives_the_same_numbers(name):
    check_repeats(CASES[name])
