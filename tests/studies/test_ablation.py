"""Prices: of what is on, in milliseconds a tick, by leaving it out; no test here knows how fast the machine is."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.scene.effects import EFFECTS, SENSOR_KEYS, Effects
from tactile_maps.stimuli.stimulus_kinds import Poke
from tactile_maps.studies.ablation import ablation_cost, without_effect
from tactile_maps.tactile.sensors.sensor_effects import AreaAveraging, Noise, SensorEffects
from tests.support.touch import prepared_bar

BAR = prepared_bar(stimuli=(Poke(),))
NOISY = SensorEffects(area_averaging=AreaAveraging(), noise=Noise())


class Ticking:
    """A clock that a second passes on at each look: every budget ends at once, and every stage takes a second."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1.0
        return self.now


@pytest.mark.long
def test_only_active_effects_have_a_cost_in_table_order():
    effects = replace(BAR.scene.effects, sensor=NOISY, joint_limits=False, gravity="compensated")
    found = ablation_cost(BAR, effects=effects, seconds=0.0)
    assert list(found) == [key for key in EFFECTS if key in found]
    assert {"dynamics", "fingers", "gravity", "skin", "area_averaging", "noise"} <= set(found)
    assert not {"joint_limits", "friction", "contact", "threshold", "sampling"} & set(found)


def test_sensor_effects_without_skin_have_no_cost():
    found = ablation_cost(BAR, effects=replace(BAR.scene.effects, skin="off", sensor=NOISY), seconds=0.0)
    assert not {"skin", *SENSOR_KEYS} & set(found)


@pytest.mark.long
def test_costs_are_reproducible_and_equal_times_cancel():
    found = ablation_cost(BAR, seconds=0.0, clock=Ticking())
    assert found == ablation_cost(BAR, seconds=0.0, clock=Ticking()) | {"skin": found["skin"]}
    assert {found[key] for key in ("dynamics", "fingers", "joint_limits")} == {0.0}


@pytest.mark.long
def test_progress_rises_and_may_cancel():
    reports = []
    ablation_cost(BAR, seconds=0.0, progress=lambda text, done: reports.append((text, done)))
    assert [done for _, done in reports] == sorted(done for _, done in reports)
    assert (reports[0][1], reports[-1][1]) == (0.0, 1.0)
    assert any("fingers" in text for text, _ in reports)

    class StoppedError(Exception):
        """The person closed the panel."""

    def stop(text, fraction):
        raise StoppedError

    with pytest.raises(StoppedError):
        ablation_cost(BAR, progress=stop)


@pytest.mark.parametrize("key", [key for key in EFFECTS if key != "timestep"])
def test_leaving_out_an_effect_changes_only_it_and_is_idempotent(key):
    full = Effects(contact="all", gravity="on", friction=True, joint_friction=True, sensor=NOISY)
    once = without_effect(full, key)
    assert without_effect(once, key) == once
    changed = [name for name in vars(full) if getattr(full, name) != getattr(once, name)]
    assert changed in ([key], ["sensor"], [])
