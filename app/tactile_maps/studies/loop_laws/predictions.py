"""A measured quantity of a loop, and its two theoretical values: of the ideal loop, and with the posture loop.

Each function measures one quantity for a case and returns (measured, predicted, explained).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.force_loop.sampled_loop import critical_gain, max_stable_gain, sampled_loop_limit
from tactile_maps.control.motion.command import ControllerName, ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop
from tactile_maps.studies.loop_laws.sampled_loop import (
    LinearLoop,
    best_gain,
    settling_on_stretched_map,
    settling_on_turned_map,
    settling_samples_of,
)
from tactile_maps.studies.loop_laws.step_trials import (
    FORCE_GOAL,
    LoopTest,
    force_ripple,
    measured_gain_limit,
    plant_stiffness,
    proportional_settings,
    settling_samples,
    tracking_lag,
)
from tactile_maps.studies.testbeds.fixed_ball import forearm_skin_scene, with_fixed_ball
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    ForceLoop,
    force_loop_at_goal,
    predicted_gain_limit,
    stability_limit,
)
from tactile_maps.studies.testbeds.path_following import PathSetup

PLANTS = {"ideal joints": IDEAL, "posture loop of 400 rad/s": 400.0, "posture loop of 40 rad/s": INNER_FREQUENCY}
"""Servo frequency of what moves the plate, by name."""
IDEAL_JOINTS, FAST_SERVO, OUR_SERVO = PLANTS
LAGGING_JOINTS = "ideal joints that lag 30 ms"
PERIOD = 0.25
"""Default period of the skin [s], in which the posture loop of 40 rad/s nearly settles."""
HARD_CONTACT = 2e4
SOFT_CONTACT = 2e3
"""Stiffness of a hard and of a soft contact [N/m]."""
ONSET_GAIN = 0.002
"""Force gain of ``onset_stiffness`` [m/s/N]."""
SPEED = 0.001
"""Speed of a moving goal [m/s]."""
_TICKS = 5
_STEPS = 4
_TAXELS = 600
_CALM = 0.002

Case = Mapping[str, Any]
Comparison = tuple[float, float, float]


def loop_of(case: Case, **changes: Any) -> Loop:
    """Return the loop of a case."""
    if case["plant"] == LAGGING_JOINTS:
        return Loop(**{"delay": case["delay"], "ticks": _TICKS, "lag": 0.03, "period": PERIOD, **changes})
    servo = PLANTS[case["plant"]]
    ticks = 1 if servo == IDEAL else _TICKS
    return Loop(**{"delay": case["delay"], "ticks": ticks, "servo": servo, "period": PERIOD, **changes})


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
        found = stability_limit(LoopTest(loop, case["controller"]).place_stable, explained, steps=_STEPS)
    else:
        unit = plant_stiffness(loop) * loop.period
        found, explained = _limits(loop, case["controller"])
    return found * unit, predicted, explained * unit


def onset_stiffness(case: Case) -> Comparison:
    """Return the stiffness of the contact at which a given force gain becomes unstable [N/m]: L_max / (k_f T)."""
    loop = loop_of(case)
    predicted = sampled_loop_limit(loop.delay) / (ONSET_GAIN * loop.period)
    explained = stability_limit(lambda k: LinearLoop(replace(loop, stiffness=k), Filter(ONSET_GAIN)).stable, predicted)
    settings = proportional_settings(case["controller"], ONSET_GAIN)

    def stable(stiffness: float) -> bool:
        return LoopTest(replace(loop, stiffness=stiffness), case["controller"]).force_stable(settings)

    return stability_limit(stable, explained, steps=_STEPS), predicted, explained


def settling_time(case: Case) -> Comparison:
    """Return the time until 2 % of a step of the contact are left, at the gain without overshoot [s]."""
    loop = loop_of(case)
    slides = case["what"] == "place"
    bench = LoopTest(loop, case["controller"])
    gain = critical_gain(loop.delay)
    periods = 40 + 10 * loop.delay
    gain /= loop.period * (1.0 if slides else plant_stiffness(loop))
    if slides:
        errors = bench.place_step(gain, periods)
    else:
        errors = bench.force_step(proportional_settings(bench.controller, gain), periods)[:, None]
    explained = LinearLoop(loop, Filter(gain), slides=slides).settling()
    ideal = int(settling_samples_of(np.array([critical_gain(loop.delay)]), loop.delay)[0])
    return loop.period * settling_samples(errors, loop.delay), loop.period * ideal, loop.period * explained


def ripple(case: Case) -> Comparison:
    """Return the standard deviation of the true force over that of the reading noise: sqrt(L / (2 - L)), by L."""
    loop = replace(loop_of(case, period=0.02, seed=case["seed"]), ticks=1)
    loop = replace(loop, noise=0.05 if loop.servo == IDEAL else 150.0)
    gain = case["x"] / (plant_stiffness(loop) * loop.period)
    true, noise = force_ripple(LoopTest(loop, case["controller"]), gain, round(case["samples"] / case["x"]))
    return true / noise, math.sqrt(case["x"] / (2 - case["x"])), math.sqrt(LinearLoop(loop, Filter(gain)).ripple())


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
    feedforward = "told of it" in case["what"]
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
    soft = case["plant"] != LAGGING_JOINTS
    loop = loop_of(case, period=case["x"], stiffness=SOFT_CONTACT if soft else 50 * HARD_CONTACT)
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


COMPARISONS: Mapping[str, Callable[[Case], Comparison]] = {
    "stability": stability,
    "onset": onset_stiffness,
    "settling": settling_time,
    "ripple": ripple,
    "routh": routh,
    "behind": tracking_error,
    "stretch": settling_stretched,
    "turn": settling_turned,
    "lag": gain_with_lag,
    "arms": gain_of_whole_arm,
}
"""Comparisons by quantity."""
INTEGRAL_CONTROLLERS: tuple[ControllerName, ...] = (
    "hold_force",
    "admittance",
    "hybrid",
    "projection",
    "priority",
    "qp",
)
"""Controllers with the integral force loop of the theory; the parallel controller has Routh's bound."""
