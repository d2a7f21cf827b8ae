"""Trials of a controller in a closed loop on the gantry: limit of stability, settling time, lag and ripple.

Every trial first lets the loop settle at a gain without overshoot, and then changes the goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.motion.command import ControllerName, ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop, LoopResponse, Settings, run_loop
from tactile_maps.studies.loop_laws.gantry import MASS
from tactile_maps.studies.loop_laws.sampled_loop import (
    SETTLING_BAND,
    samples_until_within,
)

FORCE_GOAL = 3.0
"""Goal of the force [N]."""
FORCE_STEP = 0.1
"""Step of the goal of the force [N]."""
PLACE_STEP = 5e-4
"""Step of the goal of the place [m]."""
_CALM = 0.6
"""Share of the gain without overshoot at which the loop settles before a trial."""


def plant_stiffness(loop: Loop) -> float:
    """Return the force per motion of the target posture [N/m]: contact and posture loop in series."""
    servo = MASS * loop.servo**2
    return loop.stiffness if loop.servo == IDEAL else loop.stiffness * servo / (loop.stiffness + servo)


def proportional_settings(controller: ControllerName, force_gain: float, **changes: float) -> ControlSettings:
    """Return settings of a controller without integral and inertia."""
    settings = ControlSettings(
        controller=controller,
        gains="as_given",
        force_gain=force_gain,
        force_goal=FORCE_GOAL,
        integral_time=math.inf,
        inertia_time=0.0,
    )
    return replace(settings, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True)
class LoopTest:
    """A controller with a loop.

    Attributes:
        loop: Plant and sensor.
        controller: Name of the controller.
        axis: Axis of the map along which the goal of the place moves, 0 or 1.
        rest: Periods of settling before a trial, and additional periods for each period of delay.
    """

    loop: Loop
    controller: ControllerName = "hybrid"
    axis: int = 0
    rest: int = 30

    @property
    def calm(self) -> float:
        """Force gain at which the loop settles [m/s/N]."""
        return _CALM * critical_gain(self.loop.delay) / (plant_stiffness(self.loop) * self.loop.period)

    @property
    def held(self) -> ControlSettings:
        """Settings that hold the force calmly at its place."""
        settings = proportional_settings(self.controller, self.calm)
        return replace(settings, task="hold_point", path=((0.0, 0.0),), position_gain=0.0)

    def after(self, before: ControlSettings, settings: Settings, periods: int) -> LoopResponse:
        """Return the response over ``periods`` with ``settings``, which start at tick 0 after settling."""
        rest = self.rest * (1 + self.loop.delay)
        ticks = self.loop.ticks
        whole = run_loop(
            self.loop, lambda tick: before if tick < rest * ticks else settings(tick - rest * ticks), rest + periods
        )
        return LoopResponse(whole.force[rest:], whole.read[rest:], whole.place[rest:], whole.error[rest:])

    def force_step(self, settings: ControlSettings, periods: int) -> FloatArray:
        """Return the errors (periods,) [N] after a step of ``FORCE_STEP`` of the goal of the force."""
        calm = replace(settings, force_gain=min(settings.force_gain, self.calm), integral_time=math.inf)
        after = replace(settings, force_goal=FORCE_GOAL + FORCE_STEP)
        return self.after(calm, lambda _: after, periods).force - after.force_goal

    def place_step(self, gain: float, periods: int) -> FloatArray:
        """Return the errors (periods, 2) [m] after a step of ``PLACE_STEP`` of the place's goal, at a gain [1/s]."""
        goal = (PLACE_STEP * (1 - self.axis), PLACE_STEP * self.axis)
        after = replace(self.held, path=(goal,), position_gain=gain)
        return self.after(self.held, lambda _: after, periods).place - goal

    def force_stable(self, settings: ControlSettings, *, periods: int = 80) -> bool:
        """Return whether a step of the force decays."""
        return not diverges(self.force_step(settings, periods), 10 * FORCE_STEP)


def diverges(errors: FloatArray, most: float) -> bool:
    """Return whether errors (k,) are larger in the last quarter than in the second, or ever above ``most``."""
    quarter = len(errors) // 4
    sizes = np.abs(errors)
    return bool(sizes.max() > most or sizes[-quarter:].max() > sizes[quarter : 2 * quarter].max())


def settling_samples(errors: FloatArray, delay: int) -> int:
    """Return the samples until at most 2 % of a step are left, for a controller that sees it ``delay`` samples later.

    Args:
        errors: (k, m) after a step of the goal, which the controller knows without delay. They are relative to their
            final value, because a place that is read between taxels has a constant error.
        delay: Delay in samples.
    """
    off = np.linalg.norm(errors - errors[-5:].mean(axis=0), axis=1)
    return samples_until_within(off, SETTLING_BAND * float(off[0])) + delay


def force_ripple(bench: LoopTest, gain: float, periods: int) -> tuple[float, float]:
    """Return the standard deviations of the true force and of the reading noise [N], at a force gain."""
    calm = proportional_settings(bench.controller, bench.calm)
    settings = proportional_settings(bench.controller, gain)
    response = bench.after(calm, lambda _: settings, periods)
    return float(np.std(response.force)), float(np.std(response.read - response.force))
