"""A tick is a whole number of steps, or it is refused."""

from __future__ import annotations

import pytest

from app.errors import SimulationError
from app.session.steps import whole_steps


def test_a_tick_is_so_many_steps():
    assert [whole_steps(0.005, step) for step in (0.005, 0.001, 0.0005)] == [1, 5, 10]


@pytest.mark.parametrize("step", [0.003, 0.01, 0.0, -0.001, 1e-6, float("nan"), float("inf")])
def test_what_is_no_part_of_a_tick_is_refused(step):
    with pytest.raises(SimulationError, match="whole number"):
        whole_steps(0.005, step)
