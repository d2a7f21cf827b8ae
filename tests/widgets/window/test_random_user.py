"""The window under a random hand: no exception, no Qt warning, a whole map, a session alive."""

from __future__ import annotations

import pytest

from tests.widgets.support.random_user import RandomUser
from tests.widgets.support.window_driver import run

ACTS = 100


@pytest.fixture(scope="module")
def prepared(coarse_prepared):
    """Maps of it are measured, and patches flattened, ten times as soon."""
    return coarse_prepared


@pytest.mark.parametrize("seed", [2])
def test_whatever_is_done_at_random_the_window_stays_whole(new_window, tmp_path, seed):
    with RandomUser(new_window, seed, tmp_path, lambda seconds: run(new_window, seconds)) as user:
        user.run(ACTS)
    assert user.done == ACTS
