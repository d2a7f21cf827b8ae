"""Control in hard cases: straight elbow, targets out of reach, joint limits. See ``hard_control``."""

from __future__ import annotations

import pytest

from tests.numerics.hard_control import check, check_repeats, runs
from tests.numerics.hard_control_postures import CASES


@pytest.mark.parametrize(("name", "law"), runs(CASES))
def test_the_stated_outcome_comes(name, law):
    check(CASES[name], law)


@pytest.mark.parametrize("name", CASES)
def test_the_same_again_gives_the_same_numbers(name):
    check_repeats(CASES[name])
