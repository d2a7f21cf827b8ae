"""Control in hard cases: postures, environments, sensing, wrong maps, events; each group says what must come of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.control.hard_cases import environments, events, maps, postures, sensing
from tests.control.hard_cases.case import check, check_repeats, runs

GROUPS = (postures, environments, sensing, maps, events)
CASES = {name: case for group in GROUPS for name, case in group.CASES.items()}


def test_every_case_has_its_own_name():
    assert len(CASES) == sum(len(group.CASES) for group in GROUPS)


@pytest.mark.long
@pytest.mark.parametrize(("name", "controller"), runs(CASES))
def test_case_has_the_stated_outcome(name, controller):
    check(CASES[name], controller)


def test_arm_is_stopped_before_contacts_read_as_one_wrench_move_it_fast():
    case = replace(CASES["two touches, one wrench"], seconds=2.2)
    check(case, case.controllers[0])


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", CASES)
def test_case_is_deterministic(name):
    check_repeats(CASES[name])
