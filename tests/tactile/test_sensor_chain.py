from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import (
    Noise,
    SensorEffects,
)
from tests.support.sensors import ALL_ON, STAGES, only, readings, row


def chain(effects, count=20, *, seed=3):
    return SensorChain(row(count), effects, tick=0.005, seed=seed)


def pressed(count=40, taxels=20):
    rng = np.random.default_rng(1)
    return rng.uniform(0, 250e3, (count, taxels)) * (rng.random((count, taxels)) < 0.5)


@pytest.mark.parametrize("name", STAGES)
def test_disabled_effect_is_not_called(name):
    on = chain(replace(ALL_ON, **{name: None}))
    calls = []
    kinds = {key: type(stage) for key, stage in chain(ALL_ON)._stages.items()}
    with pytest.MonkeyPatch.context() as patch:
        for key, kind in kinds.items():
            patch.setattr(kind, "read", lambda self, p, key=key: calls.append(key) or p)
        on.read(np.zeros(20))
    assert calls == [key for key in STAGES if key != name]


def test_unchanged_effect_keeps_its_state_and_changed_one_restarts():
    live = chain(ALL_ON)
    steady = chain(ALL_ON)
    readings(live, pressed())
    readings(steady, pressed())
    kept = dict(live._stages)
    live.use(replace(ALL_ON, noise=Noise(sd=1.0)))
    assert {name for name, stage in live._stages.items() if stage is not kept[name]} == {"noise"}
    assert live._effects.noise == Noise(sd=1.0)
    live.use(live._effects)
    assert live._stages["noise"].state().tolist() == [0.0]
    assert np.array_equal(live._stages["offset_drift"].state(), steady._stages["offset_drift"].state())


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf"), 1e101])
@pytest.mark.parametrize("effects", [ALL_ON, SensorEffects(), *only(ALL_ON).values()])
def test_invalid_pressure_is_rejected_by_name_without_a_reading(effects, bad):
    broken = chain(effects)
    steady = chain(effects)
    pressures = pressed()[0]
    pressures[[7, 11]] = bad
    with pytest.raises(SimulationError, match="taxel 7 on row: .*Pa"):
        broken.read(pressures)
    for _, call in broken.stages[:1]:
        with pytest.raises(SimulationError, match="taxel 7 on row"):
            call(pressures)
    assert np.array_equal(broken.state(), steady.state())
    assert np.array_equal(readings(broken, pressed()), readings(steady, pressed()))


def test_pressures_of_another_skin_are_rejected():
    with pytest.raises(SimulationError, match="20 taxels.*19"):
        chain(ALL_ON).read(np.zeros(19))


@pytest.mark.parametrize("count", [0, 1, 2])
@pytest.mark.parametrize("effects", [ALL_ON, SensorEffects(), *only(ALL_ON).values()])
def test_skin_with_very_few_taxels_is_read(effects, count):
    small = chain(effects, count)
    assert readings(small, pressed(9, count)).shape == (9, count)
    small.reset()
    assert small.dead.shape == (count,)
    assert chain(effects, count).state().shape == small.state().shape
