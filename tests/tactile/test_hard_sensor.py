"""Sensors without valid readings: all taxels dead, stuck or saturated, and drivers that send NaN or infinity."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_maps.tactile.sensors.sensor_effects import DeadTaxels, Saturation, SensorEffects
from tests.hard_cases.touch import dropped
from tests.hard_cases.touch_checks import check_numbers, play
from tests.support.touch import prepared_bar, taxel_near

BAR = prepared_bar()
MIDDLE = taxel_near(BAR.skin, 0, (0.3, 0.0, 0.02))
PRESS = PokePressed(1, BAR.skin.taxel_point(MIDDLE), Finger(max_force=5.0, speed=0.1))
FOLLOW = ControlChanged(ControlSettings(controller="hold_force", force_goal=2.0, force_gain=0.015))


def sensing(**stages) -> EffectsChanged:
    """The bar's effects with such a sensor."""
    effects = BAR.scene.effects
    return EffectsChanged(
        type(effects)(**{**vars(effects), "sensor": SensorEffects(**stages)})  # every field but the sensor's
    )


@pytest.mark.long
def test_dead_skin_has_zero_readings_and_control_continues():
    """The controller that follows touch has nothing to follow: the arm is pushed as by a hand it does not know of."""
    run = play(BAR, 1.0, {1: [sensing(dead_taxels=DeadTaxels(dead=1.0)), FOLLOW, PRESS]})
    check_numbers(run)
    assert run.failure is None
    assert not run.forces.any()
    assert not any(frame.regions for frame in run.frames)
    assert run.frames[-1].pokes[0].force == pytest.approx(5.0), "it is pressed all the same"
    assert np.abs(run.frames[-1].velocity).max() < 1e-2


@pytest.mark.long
def test_completely_stuck_skin_gives_one_large_contact_that_never_moves():
    run = play(BAR, 0.5, {1: [sensing(dead_taxels=DeadTaxels(dead=0.0, stuck=1.0, stuck_at=20e3)), FOLLOW]})
    check_numbers(run)
    assert run.forces == pytest.approx(20e3 * BAR.skin.areas.sum())
    assert [len(frame.regions) for frame in run.frames] == [1] * len(run.frames)
    assert {frame.regions[0].id for frame in run.frames} == {1}
    places = np.array([frame.regions[0].link_position for frame in run.frames])
    assert np.ptp(places, axis=0) == pytest.approx(0.0, abs=1e-12)
    assert np.abs(run.frames[-1].velocity).max() < 10.0, "a force that no retreat changes does not run away"


def test_completely_saturated_skin_reads_its_limit():
    run = play(BAR, 0.5, {1: [sensing(saturation=Saturation(at=1.0)), FOLLOW, PRESS]})
    check_numbers(run)
    assert run.failure is None
    pressed = run.frames[-1]
    assert pressed.pokes[0].force > 1.0
    assert set(np.unique(pressed.pressures)) == {0.0, 1.0}
    assert not pressed.regions, "one pascal is no contact"


@pytest.mark.long
@pytest.mark.parametrize("at", [500.0, 2e3, 180e3])
def test_saturated_contact_is_still_one_contact_under_the_finger(at):
    run = play(BAR, 0.5, {1: [sensing(saturation=Saturation(at=at)), PRESS]})
    assert run.frames[-1].pressures.max() <= at
    assert run.forces[-1] <= run.frames[-1].pokes[0].force * (1 + 1e-9)
    if at > 1e3:
        (region,) = run.frames[-1].regions
        assert np.linalg.norm(region.link_position - [0.3, 0.0, 0.02]) < 0.03


@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_huge_and_tiny_forces_give_finite_readings(name):
    model = CONTACT_MODELS[name].build(BAR.skin, BAR.scene.layer, SensorEffects())
    for force in (1e-300, 1e-12, 1e6, 1e12):
        load = sphere_load("bar", np.array([0.3, 0.0, 0.02]), np.array([0.0, 0.0, 1.0]), force, 0.01)
        pressures = model.pressures([load])
        assert np.isfinite(pressures).all()
        assert float(pressures @ BAR.skin.areas) == pytest.approx(force, rel=1e-9)


@pytest.mark.long
def test_session_continues_after_its_sensor_fails():
    """A skin that dies while it is touched, and comes back: the contact is lost, found again, and held as before."""
    dies = sensing(dead_taxels=DeadTaxels(dead=1.0))
    repaired = EffectsChanged(BAR.scene.effects)
    run = play(BAR, 3.5, {1: [FOLLOW, PRESS], 100: [dies], 200: [repaired]})
    check_numbers(run)
    touched = [bool(frame.regions) for frame in run.frames]
    assert touched[98]
    assert not any(touched[99:199])
    assert touched[-1]
    assert run.forces[-1] == pytest.approx(2.0, rel=0.02)


@pytest.mark.long
def test_dead_skin_does_not_change_the_physics():
    """A body rests on it as on a working skin."""
    lying = play(dropped(0.5, above=0.005), 0.5)
    dead = play(dropped(0.5, above=0.005, dead_taxels={"dead": 1.0}), 0.5)
    assert lying.forces.any()
    assert not dead.forces.any()
    assert np.array_equal(lying.heights, dead.heights)
