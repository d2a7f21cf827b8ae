from __future__ import annotations

import numpy as np
import pytest

from app.touch.sensor.hysteresis import Hysteresis
from tests.sensors import readings, refuses, stage


def test_of_a_step_the_late_share_is_missing_at_first_and_arrives():
    read = readings(stage(Hysteresis(share=0.25, seconds=0.1), tick=0.01), [[1000.0]] * 500)[:, 0]
    assert read[0] == 750.0
    assert (np.diff(read) >= 0).all()
    assert read[-1] == pytest.approx(1000.0)


def test_after_release_the_late_share_remains_and_goes():
    at_work = stage(Hysteresis(share=0.25, seconds=0.1), tick=0.01)
    readings(at_work, [[1000.0]] * 500)
    read = readings(at_work, [[0.0]] * 6000)[:, 0]
    assert read[0] == pytest.approx(250.0)
    assert read[-1] == 0.0
    assert not at_work.state().any(), "what is left must not linger as a subnormal number"


def test_reset_forgets_and_the_state_is_its_own():
    at_work = stage(Hysteresis(), 2)
    readings(at_work, [[1000.0, 0.0]] * 3)
    state = at_work.state()
    assert state[0] > 0
    assert state[1] == 0
    state[:] = 5.0
    assert not np.array_equal(at_work.state(), state)
    at_work.reset()
    assert not at_work.state().any()


def test_numbers_out_of_range_are_refused():
    refuses(Hysteresis, "share", -0.01, 1.01)
    refuses(Hysteresis, "seconds", 0.0, -1.0, 1.1e4)
