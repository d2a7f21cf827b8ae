"""The laws against the theory of sampled loops: stability, settling, ripple, Routh's bound, lag (theory page, 5.5)."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.hold_force import HoldForce
from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from app.touch.layer import Layer
from tests.numerics.control_loops import AT, grows, limit, onset, pressed_bar, slid_contact
from tests.things import thing
from tests.touch import bar, bar_skin
from tests.unit.control.touched import touch

ENDLESS = float("inf")
DELAYS = range(5)
NO_OVERSHOOT = [1.0, 1 / 4, 4 / 27, 27 / 256, 256 / 3125]
"""Gain of the double real pole, d^d / (d + 1)^(d + 1)."""


def proportional(law="hybrid", **said) -> ControlSettings:
    return ControlSettings(law=law, integral_time=ENDLESS, inertia_time=0.0, **said)


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize("law", ["hold_force", "hybrid", "projection", "priority", "admittance"])
def test_the_stiffness_of_onset_is_the_one_predicted(law, delay):
    gain, dt = 0.01, 0.005
    settings = proportional(law, force_gain=gain)
    expected = limit(delay) / (gain * dt)
    found = onset(lambda k: not grows(pressed_bar(settings, k, delay=delay, dt=dt)), 0.5 * expected, 2 * expected)
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("delay", DELAYS)
def test_the_loop_on_the_map_has_the_same_limit(delay):
    expected, dt = limit(delay), 0.1
    found = onset(lambda x: not grows(slid_contact(x / dt, delay=delay, dt=dt)), 0.5 * expected, 1.9 * expected)
    assert found == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("turn", [0.0, 45.0, 60.0, 75.0])
def test_a_map_believed_turned_lowers_the_limit_by_the_cosine(turn):
    """L < 2 cos turn; nothing works at 90 degrees."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    expected, dt = 2 * c, 0.1
    found = onset(lambda x: not grows(slid_contact(x / dt, dt=dt, believed=[[c, -s], [s, c]])),
                  0.3 * expected, 1.9 * expected)  # fmt: skip
    assert found == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("delay", DELAYS)
def test_settling_takes_as_long_as_the_delay_says(delay):
    """1, 9, 16, 23, 29 samples to 2 % without overshoot: about 6.4 (d + 1/2) T."""
    dt, stiffness = 0.005, 1000.0
    settings = proportional(force_gain=NO_OVERSHOOT[delay] / (stiffness * dt) * 0.25, force_goal=3.0)
    errors = pressed_bar(settings, 4 * stiffness, delay=delay, dt=dt, count=120, off=0.1)
    settled = int(np.flatnonzero(np.abs(errors) > 0.02 * 0.1)[-1]) + 1
    assert settled == pytest.approx([1, 9, 16, 23, 29][delay], abs=1 + delay)
    if delay:
        assert settled == pytest.approx(6.4 * (delay + 0.5), rel=0.2)
    assert errors.min() > -0.02 * 0.1, "no overshoot"


def test_half_the_ripple_costs_four_times_the_settling():
    """White noise on the reading: variance of the true force times settling time is constant."""
    rng, dt, stiffness, noise, products = np.random.default_rng(0), 0.005, 1000.0, 0.1, []
    for loop in (0.02, 0.05, 0.1, 0.2):
        servo, settings = ForceServo(1.0), proportional(force_gain=loop / (stiffness * dt))
        error, errors = 0.0, []
        for reading in noise * rng.normal(size=60_000):
            error -= stiffness * dt * servo.push(settings, 1, error + reading, dt, [])
            errors.append(error)
        variance = float(np.var(errors[2000:]))
        assert variance == pytest.approx(noise**2 * loop / (2 - loop), rel=0.15)
        products.append(variance * dt * np.log(50) / -np.log(1 - loop))
    assert max(products) / min(products) < 1.25


@pytest.mark.parametrize("inertia_time", [0.1, 0.2])
@pytest.mark.parametrize("position_gain", [0.0, 10.0])
def test_the_parallel_law_keeps_to_rouths_bound(inertia_time, position_gain):
    """k_I k_e < k_D (k_P + k_F k_e), as the shortest integral time that is stable."""
    gain, stiffness, dt = 0.02, 500.0, 0.002
    loop = gain * stiffness
    expected = inertia_time * loop / (position_gain + loop)

    def stable(rate: float) -> bool:
        settings = ControlSettings(law="parallel", force_gain=gain, integral_time=1 / rate,
                                   position_gain=position_gain, inertia_time=inertia_time)  # fmt: skip
        return not grows(pressed_bar(settings, stiffness, dt=dt, count=2500))

    assert 1 / onset(stable, 0.5 / expected, 2 / expected, steps=5) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("delay", [0, 1, 2, 3])
def test_a_path_leads_by_its_speed_over_the_gain(delay):
    """e = v T / L without feed-forward, whatever the delay; (1, 4, 6.75, 9.5) v T at the gain without overshoot."""
    dt, speed = 0.1, 0.002
    errors = slid_contact(NO_OVERSHOOT[delay] / dt, delay=delay, dt=dt, speed=speed)
    assert errors[-1, 0] == pytest.approx(speed * dt * [1, 4, 6.75, 9.48][delay], rel=0.01)


@pytest.mark.parametrize("stretch", [0.8, 1.0, 1.3])
def test_told_its_speed_only_what_the_map_is_wrong_about_is_left(stretch):
    dt, speed, gain = 0.1, 0.002, 3.0
    errors = slid_contact(gain, dt=dt, speed=speed, feed=1.0, believed=stretch * np.eye(2))
    assert errors[-1, 0] == pytest.approx(speed / gain * (stretch - 1), abs=1e-6)


def held_in_simulation(gain: float, calm: float, delay: int, *, tick=0.25, count=60) -> np.ndarray:
    """Force errors [N] at each tick of the bar that presses on a fixed ball, read ``delay`` ticks late.

    It settles with a gain of ``calm``; then the goal is raised by 0.2 N and the gain is ``gain``.
    """
    simulation, law = simulated_bar(), HoldForce(bar())
    readings: list[float] = []
    for k in range(2 * count):
        readings.append(float(simulation.sense() @ simulation._skin.areas))
        force = readings[max(len(readings) - 1 - delay, 0)]
        settings = proportional("hold_force", force_gain=calm if k < count else gain,
                                force_goal=3.0 if k < count else 3.2)  # fmt: skip
        command = law.command(settings, law._reference.from_where(simulation.posture), np.zeros(1),
                              touch(force, x=AT), tick)  # fmt: skip
        simulation.step(round(tick / simulation.timestep), command)
    assert readings[count] == pytest.approx(3.0, abs=0.02), "settled"
    return np.array(readings[count:]) - 3.2


def simulated_bar() -> Simulation:
    """The bar just in touch with a fixed ball above it, stiff enough to count as hard."""
    ball = thing("sphere", at=(AT, 0.0, 0.02 + 0.02 - 1e-4), size=(0.02,))
    return Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,), layer=Layer(stiffness=2e4))


def plant_stiffness() -> float:
    """Force per way of the wanted posture at the ball [N/m]: servo and contact in series, measured at rest."""
    law, forces = HoldForce(bar()), []
    simulation = simulated_bar()
    for way in (0.003, 0.004):
        command = law._reference.command_at(np.array([-way / AT]))
        simulation.step(1000, command)
        forces.append(float(simulation.sense() @ simulation._skin.areas))
    return (forces[1] - forces[0]) / 0.001


@pytest.mark.parametrize("delay", DELAYS)
def test_in_the_simulator_the_limit_is_the_same_when_the_inner_loop_is_fast(delay):
    """At 4 Hz the servo of 40 rad/s has settled between two readings."""
    tick = 0.25
    expected = limit(delay) / (plant_stiffness() * tick)
    found = onset(
        lambda gain: not grows(held_in_simulation(gain, 0.3 * expected, delay)), 0.6 * expected, 1.6 * expected, steps=4
    )
    assert found == pytest.approx(expected, rel=0.1)
