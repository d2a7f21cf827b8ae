"""What each effect of the sensor costs at a reading of 1,000 taxels, and all of them together."""

from __future__ import annotations

import numpy as np
import pytest

from app.touch.sensor.chain import SensorChain
from app.touch.sensor.effects import SensorEffects
from tests.sensors import ALL_ON, only
from tests.touch import bar_skin


def _pressed(taxels):
    """A contact on 5 % of the taxels, some beyond the highest reading."""
    rng = np.random.default_rng(0)
    return rng.uniform(0, 250e3, taxels) * (rng.random(taxels) < 0.05)


@pytest.mark.parametrize(
    "effects", [*only(ALL_ON).values(), ALL_ON, SensorEffects()], ids=[*only(ALL_ON), "all", "none"]
)
def test_a_reading_of_1000_taxels(benchmark, effects):
    skin = bar_skin(1000, finer=4)
    assert len(skin) == 1000
    assert 5 < 2 * len(skin.neighbours) / len(skin) < 6, "neighbours as on a body"
    chain, pressures = SensorChain(skin, effects, tick=0.005, seed=0), _pressed(1000)
    read = benchmark.pedantic(chain.read, args=(pressures,), rounds=200, iterations=20, warmup_rounds=20)
    assert read.shape == (1000,)
    if benchmark.stats is not None:
        benchmark.extra_info["median"] = f"{1e6 * benchmark.stats.stats.median:.1f} µs"
