"""What is measured of a controller in a closed loop on the gantry: where it becomes unstable, how long it takes to
settle.

Every measurement first lets the loop come to rest at a gain without overshoot, and then changes the goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.motion.command import ControllerName, ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop, LoopResponse, Settings, run_loop
from tactile_maps.studies.loop_laws.gantry import MASS
from tactile_maps.studies.loop_laws.sampled_loop import (
    SETTLING_BAND,
    samples_until_within,
)
from tactile_maps.studies.testbeds.force_loop import (
    settled_session,
    stability_limit,
)
from tactile_maps.studies.testbeds.path_following import PathSetup

FORCE_GOAL = 3.0
"""Of the force [N]."""
FORCE_STEP = 0.1
"""Of the force's goal [N]."""
PLACE_STEP = 5e-4
"""Of the place's goal [m]."""
_CALM = 0.6
"""Of the gain without overshoot: at this the loop comes to rest."""


def plant_stiffness(loop: Loop) -> float:
    """Force per way of the wanted posture [N/m]: of contact and posture loop in series."""
    servo = MASS * loop.servo**2
    return loop.stiffness if loop.servo == IDEAL else loop.stiffness * servo / (loop.stiffness + servo)


def proportional_settings(controller: ControllerName, force_gain: float, **said: float) -> ControlSettings:
    """Settings of a controller without integral and inertia."""
    wanted = ControlSettings(
        controller=controller,
        gains="as_given",
        force_gain=force_gain,
        force_goal=FORCE_GOAL,
        integral_time=math.inf,
        inertia_time=0.0,
    )
    return replace(wanted, **said)  # type: ignore[arg-type]


@dataclass(frozen=True)
class LoopTest:
    """A controller before a loop.

    Attributes:
        loop: Around what.
        controller: Which.
        axis: Along which the place's goal is moved on the map, 0 or 1.
        rest: Periods in which the loop comes to rest before it is measured, and as many for each one of delay.
    """

    loop: Loop
    controller: ControllerName = "hybrid"
    axis: int = 0
    rest: int = 30

    @property
    def calm(self) -> float:
        """A force gain [m/s/N] at which the loop comes to rest."""
        return _CALM * critical_gain(self.loop.delay) / (plant_stiffness(self.loop) * self.loop.period)

    @property
    def held(self) -> ControlSettings:
        """The force kept calmly at the place where it is."""
        settings = proportional_settings(self.controller, self.calm)
        return replace(settings, task="hold_point", path=((0.0, 0.0),), position_gain=0.0)

    def after(self, before: ControlSettings, settings: Settings, periods: int) -> LoopResponse:
        """The course of so many periods under ``settings``, which begin at tick 0 when the loop came to rest."""
        rest = self.rest * (1 + self.loop.delay)
        ticks = self.loop.ticks
        course = run_loop(
            self.loop, lambda tick: before if tick < rest * ticks else settings(tick - rest * ticks), rest + periods
        )
        return LoopResponse(course.force[rest:], course.read[rest:], course.place[rest:], course.error[rest:])

    def force_step(self, settings: ControlSettings, periods: int) -> FloatArray:
        """(periods,) errors [N] from when the goal of the force rose by ``STEP``, under ``settings``."""
        calm = replace(settings, force_gain=min(settings.force_gain, self.calm), integral_time=math.inf)
        after = replace(settings, force_goal=FORCE_GOAL + FORCE_STEP)
        return self.after(calm, lambda _: after, periods).force - after.force_goal

    def place_step(self, gain: float, periods: int) -> FloatArray:
        """(periods, 2) errors [m] from when the goal of the place moved by ``WAY`` along its axis, at a gain [1/s]."""
        goal = (PLACE_STEP * (1 - self.axis), PLACE_STEP * self.axis)
        after = replace(self.held, path=(goal,), position_gain=gain)
        return self.after(self.held, lambda _: after, periods).place - goal

    def force_stable(self, settings: ControlSettings, *, periods: int = 80) -> bool:
        """Whether a step of the force dies away."""
        return not diverges(self.force_step(settings, periods), 10 * FORCE_STEP)

    def place_stable(self, gain: float, *, periods: int = 80) -> bool:
        """Whether a step of the place dies away."""
        try:
            return not diverges(np.linalg.norm(self.place_step(gain, periods), axis=1), 5 * PLACE_STEP)
        except MapError:  # the ball went over the border
            return False


def diverges(errors: FloatArray, most: float) -> bool:
    """Whether errors (k,) are larger in the last quarter than in the second, or ever beyond ``most``."""
    quarter = len(errors) // 4
    sizes = np.abs(errors)
    return bool(sizes.max() > most or sizes[-quarter:].max() > sizes[quarter : 2 * quarter].max())


def settling_samples(errors: FloatArray, delay: int) -> int:
    """Samples until at most 2 % of a step are left for good, of which a controller hears ``delay`` samples after it
    was.

    Args:
        errors: (k, m) from when a goal was moved, of which the controller hears at once. They are taken from where they
            end: a place that is read between taxels is off by some of the way.
        delay: Samples.
    """
    off = np.linalg.norm(errors - errors[-5:].mean(axis=0), axis=1)
    return samples_until_within(off, SETTLING_BAND * float(off[0])) + delay


def tracking_lag(bench: LoopTest, gain: float, speed: float, *, told: bool, periods: int) -> tuple[float, float]:
    """By how much a contact is behind its goal along x at the end [m]: as the controller sees it, and in truth.

    Args:
        bench: The controller before its loop.
        gain: Of the place [1/s].
        speed: Of the goal [m/s].
        told: Whether the controller is told that the goal moves: it follows a path. Else the goal is put on at every
            tick.
        periods: How long it is followed.
    """
    tick = bench.loop.tick
    held = replace(bench.held, position_gain=gain)
    end = 2 * speed * periods * bench.loop.period
    line = replace(held, task="follow_path", path_kind="polyline", path=((0.0, 0.0), (end, 0.0)), path_speed=speed)

    def goal(k: int) -> ControlSettings:
        return line if told else replace(held, path=((speed * tick * k, 0.0),))

    course = bench.after(held, goal, periods)
    last = max(periods // 4, 1)
    wanted = speed * bench.loop.period * np.arange(periods)
    return float(np.mean(course.error[-last:])), float(np.mean((wanted - course.place[:, 0])[-last:]))


def force_ripple(bench: LoopTest, gain: float, periods: int) -> tuple[float, float]:
    """Standard deviations of the true force and of the noise in what is read [N], at a force gain."""
    calm = proportional_settings(bench.controller, bench.calm)
    settings = proportional_settings(bench.controller, gain)
    course = bench.after(calm, lambda _: settings, periods)
    return float(np.std(course.force)), float(np.std(course.read - course.force))


WATCH = 3.0
"""How long the force is watched after its goal was moved [s]."""
_STEP = 0.05


def measured_gain_limit(setup: PathSetup, settings: ControlSettings, guess: float, *, steps: int = 4) -> float:
    """The same, found by trying: a small step of the goal dies away or grows.

    Args:
        setup: The robot beside its ball, its sensor exact.
        settings: Of the controller; the force gain is tried.
        guess: Of the answer [m/s/N].
        steps: More are finer.
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
