"""Shear of the skin under bodies with friction, against statics and Coulomb's law."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.poke import Finger, PokePressed, PokePulled
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import DeadTaxels, Noise, Saturation, SensorEffects, Threshold
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold

MASS = 0.5
GRAVITY = 9.81
TOP = 0.02
FRICTION = 0.5


def upright(skin: Skin) -> np.ndarray:
    """Axes of the taxels of a flat skin on top: x, y and z of the link."""
    return np.tile(np.eye(3), (len(skin), 1, 1))


def on_slope(
    slope: float, *, shape: str = "box", model: str = "water-fill", skin: Skin | None = None, **effects
) -> Simulation:
    """A free body on the fixed flat bar; gravity is turned by ``slope`` [rad] towards +x."""
    skin = bar_skin(finer=2) if skin is None else skin
    half = 0.01
    deep = MASS * GRAVITY * np.cos(slope) / 2e4
    body = thing(shape, at=(0.15, 0.0, TOP + half - deep), mass=MASS, friction=FRICTION)
    on = {"contact": "environment", "gravity": "on", "friction": True, "shear": True, "skin": model, **effects}
    simulation = Simulation(
        bar(hinged=False), skin, Effects(**on), objects=(body,), layer=ElasticLayer(2e4), frames=lambda: upright(skin)
    )
    simulation._model.opt.gravity[:] = GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)
    simulation._physics.forward()
    return simulation


def advance(simulation: Simulation, seconds: float) -> np.ndarray:
    """Return the pressures (taxels,) [Pa] after some time, read every 5 ms."""
    command = hold(bar(hinged=False), 0.0, 0.0)
    for _ in range(round(seconds / 0.005)):
        simulation.step(round(0.005 / simulation.timestep), command)
        pressures = simulation.sense()
    return pressures


@pytest.mark.parametrize("model", ["point", "water-fill", "punch"])
def test_shear_on_a_slope_carries_the_weight_along_it(model):
    slope = np.radians(15.0)
    simulation = on_slope(slope, model=model)
    pressures = advance(simulation, 0.3)
    areas = simulation._skin.areas
    assert pressures @ areas == pytest.approx(MASS * GRAVITY * np.cos(slope), rel=1e-3)
    np.testing.assert_allclose(areas @ simulation.shear, [MASS * GRAVITY * np.sin(slope), 0.0], atol=1e-3)
    (sheared,) = simulation.sheared
    np.testing.assert_allclose(areas @ simulation.shear, sheared.load.shear[:2], atol=1e-11)
    assert sheared.usage == pytest.approx(np.tan(slope) / FRICTION, rel=1e-3)
    assert (np.linalg.norm(simulation.shear, axis=1) <= FRICTION * pressures * (1 + 1e-9)).all()


@pytest.mark.parametrize("integrator", ["implicitfast", pytest.param("discrete", marks=pytest.mark.long)])
def test_every_taxel_on_a_steep_slope_slides_at_its_limit(integrator):
    simulation = on_slope(np.radians(35.0), integrator=integrator)
    pressures = advance(simulation, 0.1)
    limits = FRICTION * pressures
    np.testing.assert_allclose(simulation.shear[:, 0], limits, rtol=1e-3, atol=1e-3 * limits.max())
    (sheared,) = simulation.sheared
    assert sheared.stuck == 0.0
    assert not [note for note in simulation.notes if note.kind is ContactNoteKind.FRICTION_EXCEEDED]


def test_shear_vanishes_when_the_body_leaves():
    simulation = on_slope(np.radians(15.0))
    advance(simulation, 0.1)
    assert simulation.shear.any()
    simulation._model.opt.gravity[:] = 0.0, 0.0, GRAVITY
    advance(simulation, 0.2)
    assert not simulation.shear.any()
    assert simulation.sheared == ()


def test_readings_are_repeatable_and_a_reset_relaxes_the_skin():
    simulation = on_slope(np.radians(15.0))
    first = [advance(simulation, 0.02), simulation.shear, simulation.state()]
    start = on_slope(np.radians(15.0)).state()
    simulation.reset()
    assert np.array_equal(simulation.state(), start)
    again = [advance(simulation, 0.02), simulation.shear, simulation.state()]
    assert all(np.array_equal(one, other) for one, other in zip(first, again, strict=True))


def test_averaged_readings_carry_the_mean_shear():
    slope = np.radians(15.0)
    simulation = on_slope(slope, time_averaging=True)
    advance(simulation, 0.3)
    force = simulation._skin.areas @ simulation.shear
    np.testing.assert_allclose(force, [MASS * GRAVITY * np.sin(slope), 0.0], atol=1e-3)


def test_other_effects_change_without_relaxing_the_skin():
    simulation = on_slope(np.radians(15.0))
    advance(simulation, 0.1)
    before = simulation.shear
    gravity = simulation._model.opt.gravity.copy()
    simulation.use(Effects(**{**vars(simulation.effects), "joint_limits": False}))
    simulation._model.opt.gravity[:] = gravity
    advance(simulation, 0.005)
    np.testing.assert_allclose(simulation.shear, before, atol=1e-3 * np.abs(before).max())


@pytest.mark.parametrize("off", [{"shear": False}, {"model": "half-space"}, {"model": "foundation"}])
def test_effect_shear_off_gives_no_tractions(off):
    simulation = on_slope(np.radians(15.0), **off)
    advance(simulation, 0.01)
    assert simulation.shear is None
    assert simulation.sheared == ()


def pulled(**effects) -> tuple[Simulation, np.ndarray, np.ndarray]:
    """Return a pulled finger on the fixed bar, where it pressed, and where it is pulled to."""
    skin = bar_skin(finer=2)
    on = Effects(**{"shear": True, **effects})
    simulation = Simulation(bar(hinged=False), skin, on, frames=lambda: upright(skin))
    places = skin.patches[0].taxels.positions
    taxel = int(np.linalg.norm(places - [0.15, 0.0, TOP], axis=1).argmin())
    target = int(np.linalg.norm(places - places[taxel] - [0.05, 0.0, 0.0], axis=1).argmin())
    simulation.apply(PokePressed(1, skin.taxel_point(taxel), Finger(stiffness=1000.0, max_force=5.0, speed=0.05)))
    advance(simulation, 0.3)
    simulation.apply(PokePulled(1, skin.taxel_point(target)))
    advance(simulation, 0.05)
    return simulation, places[taxel], places[target]


def test_pulled_finger_slides_until_friction_balances_the_pull():
    simulation, start, goal = pulled()
    skin = simulation._skin
    (finger,) = simulation.pokes
    force = skin.areas @ simulation.shear
    np.testing.assert_allclose(np.linalg.norm(force), 0.5 * 5.0, rtol=1e-3)
    way = goal - start
    np.testing.assert_allclose(force, 2.5 * way[:2] / np.linalg.norm(way), atol=0.01)
    left = goal - skin.position(finger.at)
    assert np.linalg.norm(left) == pytest.approx(0.5 * 5.0 / 1000.0, rel=1e-3)


def test_pull_within_friction_gives_shear_without_motion():
    simulation, _, _ = pulled()
    before = simulation.pokes[0].at
    simulation.apply(PokePulled(1, before))
    advance(simulation, 0.05)
    assert simulation.pokes[0].at == before
    assert np.abs(simulation._skin.areas @ simulation.shear).max() < 1e-9


def test_pulled_finger_drags_a_joint_that_yields():
    skin = bar_skin()
    bar_on_hinge = bar()
    on = Effects(gravity="off", shear=True)
    simulation = Simulation(bar_on_hinge, skin, on, frames=lambda: upright(skin))
    end = int(skin.patches[0].taxels.positions[:, 0].argmax())
    middle = int(np.linalg.norm(skin.patches[0].taxels.positions - [0.2, 0, TOP], axis=1).argmin())
    command = hold(bar_on_hinge, 20.0, 1.0)
    simulation.apply(PokePressed(1, skin.taxel_point(middle), Finger(max_force=5.0, speed=0.05)))
    simulation.step(500, command)
    pressed = simulation.posture.copy()
    simulation.apply(PokePulled(1, skin.taxel_point(end)))
    simulation.step(500, command)
    assert simulation.posture[0] > pressed[0] + 1e-4, "2.5 N along x at 20 mm above the hinge turn it about y"


def test_pulled_finger_slides_freely_without_shear():
    simulation, _, goal = pulled(shear=False)
    np.testing.assert_allclose(simulation._skin.position(simulation.pokes[0].at), goal)
    assert simulation.shear is None


def test_shear_has_the_noise_and_the_broken_taxels_of_the_sensor():
    sensor = SensorEffects(noise=Noise(sd=50.0), dead_taxels=DeadTaxels(dead=0.2))
    simulation = on_slope(np.radians(15.0), sensor=sensor)
    command = hold(bar(hinged=False), 0.0, 0.0)
    read = []
    pressed = []
    for _ in range(300):
        simulation.step(1, command)
        pressed.append(simulation.sense())
        read.append(simulation.sense_shear())
    alive = ~simulation.broken_taxels
    idle = alive & ~simulation.shear.any(axis=1)
    noise = np.array(read)[:, idle]
    assert noise.std() == pytest.approx(50.0, rel=0.05)
    assert abs(np.corrcoef(noise[:, :, 0].ravel(), noise[:, :, 1].ravel())[0, 1]) < 0.05
    assert abs(np.corrcoef(noise[:, :, 0].ravel(), np.array(pressed)[:, idle].ravel())[0, 1]) < 0.05
    assert not np.array(read)[:, ~alive].any()


@pytest.mark.parametrize("at", [20.0, 1e5])
def test_shear_is_saturated_and_thresholded_in_both_directions(at):
    effects = SensorEffects(saturation=Saturation(at=1e3), threshold=Threshold(at=at))
    chain = SensorChain(bar_skin(), effects, tick=0.005, seed=0, channel=1)
    values = np.linspace(-2e3, 2e3, len(bar_skin()))
    expected = np.clip(values, -1e3, 1e3)
    np.testing.assert_array_equal(chain.read(values), np.where(np.abs(expected) < at, 0.0, expected))
