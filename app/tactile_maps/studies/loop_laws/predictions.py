"""A measured quantity of a loop, and its two theoretical values: of the ideal loop, and with the posture loop.

Each function measures one quantity for a case and returns (measured, predicted, explained).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tactile_maps.control.force_loop.sampled_loop import critical_gain, sampled_loop_limit
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop
from tactile_maps.studies.loop_laws.sampled_loop import (
    LinearLoop,
    settling_samples_of,
)
from tactile_maps.studies.loop_laws.step_trials import (
    LoopTest,
    force_ripple,
    plant_stiffness,
    proportional_settings,
    settling_samples,
)
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    stability_limit,
)

PLANTS = {"ideal joints": IDEAL, "posture loop of 400 rad/s": 400.0, "posture loop of 40 rad/s": INNER_FREQUENCY}
"""Servo frequency of what moves the plate, by name."""
IDEAL_JOINTS, FAST_SERVO, OUR_SERVO = PLANTS
PERIOD = 0.25
"""Default period of the skin [s], in which the posture loop of 40 rad/s nearly settles."""
ONSET_GAIN = 0.002
"""Force gain of ``onset_stiffness`` [m/s/N]."""
_TICKS = 5
_STEPS = 4

Case = Mapping[str, Any]
Comparison = tuple[float, float, float]


def loop_of(case: Case, **changes: Any) -> Loop:
    """Return the loop of a case."""
    servo = PLANTS[case["plant"]]
    ticks = 1 if servo == IDEAL else _TICKS
    return Loop(**{"delay": case["delay"], "ticks": ticks, "servo": servo, "period": PERIOD, **changes})


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


COMPARISONS: Mapping[str, Callable[[Case], Comparison]] = {
    "onset": onset_stiffness,
    "settling": settling_time,
    "ripple": ripple,
}
"""Comparisons by quantity."""
