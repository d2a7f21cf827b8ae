"""Further quantities of sampled loops, measured and predicted: limits of gains, Routh's bound, lag, maps, arms."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.force_loop.sampled_loop import critical_gain, sampled_loop_limit
from tactile_maps.control.motion.command import ControllerName, ControlSettings
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.studies.loop_laws.closed_loop import Loop
from tactile_maps.studies.loop_laws.predictions import (
    COMPARISONS,
    Case,
    Comparison,
    loop_of,
)
from tactile_maps.studies.loop_laws.sampled_loop import LinearLoop, settling_samples_of
from tactile_maps.studies.loop_laws.step_trials import (
    FORCE_GOAL,
    PLACE_STEP,
    LoopTest,
    diverges,
    plant_stiffness,
    proportional_settings,
    settling_samples,
)
from tactile_maps.studies.testbeds.fixed_ball import forearm_skin_scene, with_fixed_ball
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    ForceLoop,
    force_loop_at_goal,
    predicted_gain_limit,
    settled_session,
    stability_limit,
)
from tactile_maps.studies.testbeds.path_following import PathSetup

HARD_CONTACT = 2e4
SOFT_CONTACT = 2e3
"""Stiffness of a hard and of a soft contact [N/m]."""
SPEED = 0.001
"""Speed of a moving goal [m/s]."""
LAGGING_JOINTS = "ideal joints that lag 30 ms"
_STEPS = 4
_TAXELS = 600
_CALM = 0.002
_GAINS = 240
WATCH = 3.0
"""Time for which the force is observed after a step of its goal [s]."""
_STEP = 0.05
INTEGRAL_CONTROLLERS: tuple[ControllerName, ...] = (
    "hold_force",
    "admittance",
    "hybrid",
    "projection",
    "priority",
    "qp",
)
"""Controllers with the integral force loop of the theory; the parallel controller has Routh's bound."""


def max_stable_gain(stiffness: float, readings: SensorTiming) -> float:
    """Greatest stable force gain [m/s/N] of ideal joints on a spring.

    Args:
        stiffness: Stiffness of the spring [N/m].
        readings: Period and delay of the skin's readings.
    """
    return sampled_loop_limit(readings.delay / readings.period) / (stiffness * readings.period)


def best_gain(slowest: Callable[[FloatArray], IntArray], most: float) -> tuple[float, int]:
    """Return the gain that settles soonest, the middle one of equal gains, and its number of samples.

    Args:
        slowest: Returns the samples (k,) to settle with gains (k,).
        most: Largest gain to try.
    """
    gains = np.geomspace(0.01 * most, most, _GAINS)
    samples = slowest(gains)
    best = np.flatnonzero(samples == samples.min())
    return float(gains[best[len(best) // 2]]), int(samples.min())


def settling_on_stretched_map(delay: int, stretch: float) -> Callable[[FloatArray], IntArray]:
    """Return the samples to settle in the slower direction of a map treated as an isometry; for ``best_gain``."""
    root = stretch**0.5
    return lambda gains: np.maximum(settling_samples_of(gains * root, delay), settling_samples_of(gains / root, delay))


def settling_on_turned_map(delay: int, degrees: float) -> Callable[[FloatArray], IntArray]:
    """Return the samples to settle with a directional error of every correction; for ``best_gain``."""
    astray = cmath.exp(1j * math.radians(degrees))
    return lambda gains: settling_samples_of(np.asarray(gains * astray, dtype=np.complex128), delay)


def place_stable(bench: LoopTest, gain: float) -> bool:
    """Return whether a step of the place decays."""
    try:
        return not diverges(np.linalg.norm(bench.place_step(gain, 80), axis=1), 5 * PLACE_STEP)
    except MapError:  # the ball left the plate
        return False


def tracking_lag(bench: LoopTest, gain: float, speed: float, *, feedforward: bool, periods: int) -> tuple[float, float]:
    """Return the lag of a contact behind its goal along x at the end [m]: as the controller sees it, and the true lag.

    Args:
        bench: The controller with its loop.
        gain: Gain of the place [1/s].
        speed: Speed of the goal [m/s].
        feedforward: Whether the controller knows the speed, because it follows a path; otherwise the goal is set at
            every tick.
        periods: Duration in periods.
    """
    tick = bench.loop.tick
    held = replace(bench.held, position_gain=gain)
    end = 2 * speed * periods * bench.loop.period
    line = replace(held, task="follow_path", path_kind="polyline", path=((0.0, 0.0), (end, 0.0)), path_speed=speed)

    def goal(k: int) -> ControlSettings:
        return line if feedforward else replace(held, path=((speed * tick * k, 0.0),))

    response = bench.after(held, goal, periods)
    last = max(periods // 4, 1)
    target = speed * bench.loop.period * np.arange(periods)
    return float(np.mean(response.error[-last:])), float(np.mean((target - response.place[:, 0])[-last:]))


def measured_gain_limit(setup: PathSetup, settings: ControlSettings, guess: float, *, steps: int = 4) -> float:
    """Return the largest stable force gain [m/s/N], by trials: a small step of the goal decays or grows.

    Args:
        setup: The robot next to its ball, with an exact sensor.
        settings: Settings of the controller; the force gain is varied.
        guess: Estimate of the result [m/s/N].
        steps: Number of bisections.
    """
    calm = replace(settings, gains="as_given", force_gain=0.3 * guess)

    def stable(gain: float) -> bool:
        session = settled_session(setup, calm)
        forces = []
        after = replace(settings, gains="as_given", force_gain=gain, force_goal=settings.force_goal + _STEP)
        session.submit(ControlChanged(after))
        for _ in range(round(WATCH / setup.prepared.scene.tick)):
            session.tick()
            forces.append(session.total_normal_force - after.force_goal)
        return not diverges(np.array(forces), 10 * _STEP)

    return stability_limit(stable, guess, steps=steps)


def _limits(loop: Loop, controller: ControllerName) -> tuple[float, float]:
    """Largest stable force gain [m/s/N] of a controller, measured and by the theory with the posture loop."""
    guess = sampled_loop_limit(loop.delay) / (plant_stiffness(loop) * loop.period)
    explained = stability_limit(lambda gain: LinearLoop(loop, Filter(gain)).stable, guess)
    bench = LoopTest(loop, controller)
    measured = stability_limit(
        lambda gain: bench.force_stable(proportional_settings(controller, gain)), explained, steps=_STEPS
    )
    return measured, explained


def stability(case: Case) -> Comparison:
    """Return the largest stable loop gain L; for a force, contact and posture loop in series are the plant."""
    loop = loop_of(case)
    predicted = sampled_loop_limit(loop.delay)
    if case["what"] == "place":
        unit = loop.period
        explained = stability_limit(lambda gain: LinearLoop(loop, Filter(gain), slides=True).stable, predicted / unit)
        found = stability_limit(partial(place_stable, LoopTest(loop, case["controller"])), explained, steps=_STEPS)
    else:
        unit = plant_stiffness(loop) * loop.period
        found, explained = _limits(loop, case["controller"])
    return found * unit, predicted, explained * unit


def routh(case: Case) -> Comparison:
    """Return the shortest stable integral time of the parallel controller [s]: k_I k_e < k_D (k_P + k_F k_e)."""
    loop = replace(loop_of(case, period=0.004, stiffness=HARD_CONTACT), ticks=1)
    gain = 10 / plant_stiffness(loop)
    inertia = case["inertia"]
    place = case["x"]
    predicted = inertia * 10 / (place + 10)
    controller = Filter(gain, position_gain=place, inertia_time=inertia)
    # Searched as a rate, because larger values must be less stable.
    explained = 1 / stability_limit(
        lambda rate: LinearLoop(loop, replace(controller, integral_time=1 / rate)).stable, 1 / predicted
    )
    bench = LoopTest(loop, "parallel", rest=500)

    def stable(rate: float) -> bool:
        settings = proportional_settings(
            "parallel", gain, integral_time=1 / rate, position_gain=place, inertia_time=inertia
        )
        return bench.force_stable(settings, periods=800)

    return 1 / stability_limit(stable, 1 / explained, steps=_STEPS), predicted, explained


def tracking_error(case: Case) -> Comparison:
    """Return the lag of a contact behind a moving goal [mm] at the gain without overshoot: v T / L, or 0 with
    feed-forward of the speed.

    The goal is known without delay, the contact with delay, and the goal moves between readings. The true contact is
    therefore behind the reading by the motion of the goal in the delay and in half a period less half a tick.
    """
    loop = loop_of(case)
    feedforward = "known speed" in case["what"]
    gain = critical_gain(loop.delay)
    way = 1e3 * SPEED * loop.period
    held = way * (1 - 1 / loop.ticks) / 2
    # On a path the slide observer settles too, more slowly than the loop.
    periods = 90 + 36 * loop.delay if feedforward else 60 + 30 * loop.delay
    bench = LoopTest(loop, case["controller"])
    seen, true = tracking_lag(bench, gain / loop.period, SPEED, feedforward=feedforward, periods=periods)
    predicted = 0.0 if feedforward else way / gain
    if "seen" in case["what"]:
        return 1e3 * seen, predicted, abs(predicted - held)
    return 1e3 * abs(true), predicted, abs(predicted - held - way * loop.delay)


def settling_stretched(case: Case) -> Comparison:
    """Return the samples to settle in the slower direction of a map stretched by the case's x, at the best gain."""
    loop = loop_of(case, stretch=case["x"])
    gain, ideal = _best("stretch", case["x"] if case["controller"] == "projection" else 1.0, loop.delay)
    errors = [LoopTest(loop, case["controller"], axis=axis).place_step(gain / loop.period, 80) for axis in (0, 1)]
    found = max(settling_samples(each, loop.delay) for each in errors)
    roots = (case["x"] ** 0.5, case["x"] ** -0.5) if case["controller"] == "projection" else (1.0,)
    linear = [LinearLoop(loop, Filter(gain * root / loop.period), slides=True).settling() for root in roots]
    return found, ideal, max(linear)


def settling_turned(case: Case) -> Comparison:
    """Return the samples to settle on a map that is believed to be turned by the case's x [deg], at the best gain."""
    loop = loop_of(case, turn=case["x"])
    gain, ideal = _best("turn", case["x"], loop.delay)
    errors = LoopTest(loop, case["controller"]).place_step(gain / loop.period, max(80, 2 * ideal))
    controller = Filter(gain / loop.period, angle=math.radians(case["x"]))
    return settling_samples(errors, loop.delay), ideal, LinearLoop(loop, controller, slides=True).settling()


def gain_with_lag(case: Case) -> Comparison:
    """Return the largest stable gain of the force [1/s] with lagging joints; the case's x is the period [s]."""
    if case["plant"] == LAGGING_JOINTS:
        loop = Loop(delay=case["delay"], ticks=5, lag=0.03, period=case["x"], stiffness=50 * HARD_CONTACT)
    else:
        loop = loop_of(case, period=case["x"], stiffness=SOFT_CONTACT)
    unit = plant_stiffness(loop)
    found, explained = _limits(loop, case["controller"])
    return found * unit, sampled_loop_limit(loop.delay) / loop.period, explained * unit


def gain_of_whole_arm(case: Case) -> Comparison:
    """Return the largest stable force gain of a pressed robot [m/s/N]: 2 / (k T) of ideal joints, and by all joints.

    Ideal joints would allow 0.07 m/s/N everywhere; the lag of the posture loop, coupled joints and the lag of a
    controller itself (admittance, parallel) reduce it.
    """
    settings = ControlSettings(
        controller=case["controller"], task="hold_point", gains="as_given", force_goal=FORCE_GOAL
    )
    setup, loop = _arm(case["robot"], case["seed"])
    explained = predicted_gain_limit(loop, settings)
    ideal = max_stable_gain(loop.stiffness, SensorTiming(loop.tick))
    return measured_gain_limit(setup, settings, explained, steps=_STEPS), ideal, explained


@lru_cache(maxsize=3)
def _arm(robot: str, seed: int) -> tuple[PathSetup, ForceLoop]:
    setup = PathSetup(with_fixed_ball(forearm_skin_scene(robot, _TAXELS, seed), seed=seed))
    return setup, force_loop_at_goal(
        setup, ControlSettings(controller="hybrid", task="hold_point", force_goal=FORCE_GOAL, force_gain=_CALM)
    )


@lru_cache(maxsize=64)
def _best(kind: str, amount: float, delay: int) -> tuple[float, int]:
    slowest = settling_on_stretched_map(delay, amount) if kind == "stretch" else settling_on_turned_map(delay, amount)
    return best_gain(slowest, sampled_loop_limit(delay))


QUANTITIES: Mapping[str, Callable[[Case], Comparison]] = {
    **COMPARISONS,
    "stability": stability,
    "routh": routh,
    "behind": tracking_error,
    "stretch": settling_stretched,
    "turn": settling_turned,
    "lag": gain_with_lag,
    "arms": gain_of_whole_arm,
}
"""Comparisons by quantity, those of the study among them."""
