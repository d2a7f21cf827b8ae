"""Impacts on skin, step by step: impulse against momentum, energy, and the damping of the foundation."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from scipy.optimize import curve_fit

from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.objects import ObjectKind
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_maps.tactile.sensors.sensor_effects import Sampling, SensorEffects
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold

GRAVITY = 9.81
TOP = 0.02
USUAL = ("implicitfast", "discrete")
INTEGRATORS = [pytest.param(name, marks=() if name in USUAL else pytest.mark.long) for name in get_args(Integrator)]
HALF: dict[ObjectKind, float] = {"sphere": 0.02, "box": 0.01, "cylinder": 0.01, "mesh": 0.02}
STILL = hold(bar(hinged=False), 0.0, 0.0)


def falling(kind: ObjectKind, mass: float, speed: float, **effects) -> Simulation:
    """A guided body 1 mm above the fixed bar, on its way down."""
    body = thing(kind, at=(0.15, 0.0, TOP + HALF[kind] + 1e-3), mass=mass, guided=True)
    expected = Effects(**{"contact": "environment", "gravity": "on", **effects})
    simulation = Simulation(bar(hinged=False), bar_skin(), expected, objects=(body,), layer=ElasticLayer(stiffness=2e4))
    simulation._data.qvel[0] = -speed
    simulation._physics.forward()
    return simulation


def impact(simulation: Simulation, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the force on the skin that the taxels read [N] and the velocity of the body [m/s] after each step."""
    forces = []
    velocities = []
    for _ in range(round(seconds / simulation.timestep)):
        simulation.step(1, STILL)
        forces.append(simulation.sense() @ simulation._skin.areas)
        velocities.append(simulation._data.qvel[0])
    return np.array(forces), np.array(velocities)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("step", [0.002, 0.001, pytest.param(0.00025, marks=pytest.mark.long)])
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", HALF)
def test_measured_impulse_equals_the_change_of_momentum(kind, integrator, step):
    mass = 0.5
    speed = 0.5
    seconds = 0.06
    forces, velocities = impact(falling(kind, mass, speed, integrator=integrator, timestep=step), seconds)
    assert forces.max() > 20
    assert forces.sum() * step == pytest.approx(mass * (velocities[-1] + speed + GRAVITY * seconds), rel=2e-3)
    assert velocities.max() < speed, "no energy is gained"


@pytest.mark.sampled(1)
@pytest.mark.parametrize("step", [0.002, 0.001, 0.00025])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_foundation_damps_like_its_material(integrator, step):
    """A block of mass m on springs of K in all, with the relaxation time T, decays with  K T / (2 m)."""
    mass = 2.0
    layer = ElasticLayer()
    box = thing("box", size=(0.06, 0.05, 0.02), at=(0.15, 0.0, TOP + 0.01 - 5e-4), mass=mass, guided=True)
    effects = Effects(contact="environment", gravity="on", integrator=integrator, skin="foundation", timestep=step)
    simulation = Simulation(bar(hinged=False), bar_skin(finer=4), effects, objects=(box,), layer=layer)
    heights = []
    for _ in range(round(0.12 / step)):
        simulation.step(1, STILL)
        heights.append(simulation.object_poses[0, 2, 3])
    stiffness = layer.foundation * 0.06 * 0.05
    rate = 0.5e-3 * stiffness / mass
    turns = np.sqrt(stiffness / mass)

    def swing(time, size, decay, speed, phase, rest):
        return size * np.exp(-decay * time) * np.cos(speed * time + phase) + rest

    times = step * np.arange(1, len(heights) + 1)
    (_, decay, speed, _, _), _ = curve_fit(swing, times, heights, p0=(3e-4, rate, turns, 0.0, heights[-1]))
    assert decay == pytest.approx(rate, rel=0.05)
    assert abs(speed) == pytest.approx(np.sqrt(turns**2 - rate**2), rel=0.03)


@pytest.mark.sampled(15)
@pytest.mark.parametrize("skin", ["point", "water-fill", "punch", "half-space", "foundation"])
@pytest.mark.parametrize("steps", [1, 5, 20])
@pytest.mark.parametrize("kind", ["sphere", "box"])
def test_averaged_readings_conserve_the_impulse_at_any_rate(kind, steps, skin):
    """The last step's force would make the impulse anything from nothing to fifteen times of it."""
    mass = 0.2
    speed = 0.4
    step = 5e-4
    simulation = falling(kind, mass, speed, timestep=step, skin=skin, time_averaging=True)
    impulse = 0.0
    ticks = round(0.06 / (step * steps))
    for _ in range(ticks):
        simulation.step(steps, STILL)
        impulse += simulation.sense() @ simulation._skin.areas * step * steps
        assert not any(note.kind.name == "BRIEF" for note in simulation.notes), "no contact is missed"
    gained = mass * (simulation._data.qvel[0] + speed + GRAVITY * ticks * steps * step)
    assert impulse == pytest.approx(gained, rel=0.02)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("skin", ["water-fill", "foundation"])
@pytest.mark.parametrize("steps", [1, 5, 20])
@pytest.mark.parametrize("kind", ["sphere", "box"])
def test_averaged_wrenches_conserve_the_impulse_at_any_rate(kind, steps, skin):
    """So does the total that scenes state; those of the last step scatter as its readings would."""
    mass = 0.2
    speed = 0.4
    step = 5e-4
    simulation = falling(kind, mass, speed, timestep=step, skin=skin, time_averaging=True)
    impulse = np.zeros(6)
    total = 0.0
    ticks = round(0.06 / (step * steps))
    for _ in range(ticks):
        simulation.step(steps, STILL)
        impulse += simulation.wrenches()["bar"] * step * steps
        total += simulation.total_normal_force * step * steps
    gained = mass * (simulation._data.qvel[0] + speed + GRAVITY * ticks * steps * step)
    assert impulse[2] == pytest.approx(-gained, rel=0.02)
    assert impulse[4] == pytest.approx(0.15 * gained, rel=0.02), "at the place of the body"
    assert total == pytest.approx(gained, rel=0.02)


@pytest.mark.parametrize("rate", [50.0, 20.0])
def test_averaged_readings_of_a_slow_sensor_conserve_the_impulse(rate):
    mass = 0.2
    speed = 0.4
    step = 1e-3
    body = thing("sphere", at=(0.15, 0.0, TOP + 0.04), mass=mass, guided=True)
    effects = Effects(
        contact="environment",
        gravity="on",
        time_averaging=True,
        sensor=SensorEffects(sampling=Sampling(rate=rate, delay=0.0)),
    )
    simulation = Simulation(bar(hinged=False), bar_skin(), effects, objects=(body,), tick=0.005)
    simulation._data.qvel[0] = -speed
    simulation._physics.forward()
    impulse = 0.0
    ticks = 41
    for _ in range(ticks):
        simulation.step(5, STILL)
        impulse += simulation.sense() @ simulation._skin.areas * 0.005
    gained = mass * (simulation._data.qvel[0] + speed + GRAVITY * ticks * 5 * step)
    # A sample averages the time before it and is read in the time after it: at the end it is the weight.
    late = mass * GRAVITY * (1 / rate - 0.005)
    assert impulse == pytest.approx(gained - late, rel=0.02)


def test_finger_forces_are_averaged_in_the_same_way():
    robot = bar(hinged=False)
    skin = bar_skin()
    last, mean = (Simulation(robot, skin, Effects(time_averaging=on)) for on in (False, True))
    forces = []
    for simulation in (last, mean):
        simulation.apply(PokePressed(1, skin.taxel_point(30), Finger(speed=0.1, max_force=20.0)))
    for _ in range(10):
        last.step(1, STILL)
        forces.append(last.sense() @ skin.areas)
    mean.step(10, STILL)
    assert forces[-1] > 1.5 * np.mean(forces) > 0
    assert mean.sense() @ skin.areas == pytest.approx(np.mean(forces), rel=1e-9)
