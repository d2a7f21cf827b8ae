from __future__ import annotations

import pytest

from app.errors import SimulationError
from app.touch.sensor.stage import Readout
from tests.sensors import row


def test_every_effect_has_a_stream_of_its_own_that_begins_anew():
    readout = Readout(row(1), 0.01, 7)
    first = readout.stream("noise").random(4).tolist()
    assert readout.stream("noise").random(4).tolist() == first
    assert readout.stream("offset_drift").random(4).tolist() != first
    assert Readout(row(1), 0.01, 8).stream("noise").random(4).tolist() != first


@pytest.mark.parametrize("tick", [0.0, -0.01, float("nan"), float("inf")])
def test_a_tick_that_is_none_is_refused(tick):
    with pytest.raises(SimulationError, match="tick.*found"):
        Readout(row(1), tick, 0)


def test_a_negative_seed_is_refused():
    with pytest.raises(SimulationError, match="seed.*-1"):
        Readout(row(1), 0.01, -1)
