"""What is measured of a law in a closed loop on the gantry: where it begins to grow, how long it takes.

Every measurement first lets the loop come to rest at a calm gain, and then changes the goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.arrays import FloatArray
from app.control.command import ControlSettings, LawName
from app.errors import MapError
from app.experiments.gantry import MASS
from app.experiments.gantry_loop import IDEAL, Course, Loop, Settings, run
from app.experiments.sampled_loop import SETTLED, calm_gain, last_beyond

GOAL = 3.0
"""Of the force [N]."""
STEP = 0.1
"""Of the force's goal [N]."""
WAY = 5e-4
"""Of the place's goal [m]."""
_CALM = 0.6
"""Of the gain without overshoot: at this the loop comes to rest."""


def plant_stiffness(loop: Loop) -> float:
    """Force per way of the wanted posture [N/m]: of contact and posture loop in series."""
    servo = MASS * loop.servo**2
    return loop.stiffness if loop.servo == IDEAL else loop.stiffness * servo / (loop.stiffness + servo)


def proportional(law: LawName, force_gain: float, **said: float) -> ControlSettings:
    """Settings of a law without integral and inertia."""
    wanted = ControlSettings(
        law=law, gains="as_set", force_gain=force_gain, force_goal=GOAL, integral_time=math.inf, inertia_time=0.0
    )
    return replace(wanted, **said)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Bench:
    """A law before a loop.

    Attributes:
        loop: Around what.
        law: Which.
        axis: Along which the place's goal is moved on the map, 0 or 1.
        rest: Periods in which the loop comes to rest before it is measured, and as many for each one of delay.
    """

    loop: Loop
    law: LawName = "hybrid"
    axis: int = 0
    rest: int = 30

    @property
    def calm(self) -> float:
        """A force gain [m/s/N] at which the loop comes to rest."""
        return _CALM * calm_gain(self.loop.delay) / (plant_stiffness(self.loop) * self.loop.period)

    @property
    def held(self) -> ControlSettings:
        """The force kept calmly at the place where it is."""
        settings = proportional(self.law, self.calm)
        return replace(settings, task="hold_point", path=((0.0, 0.0),), position_gain=0.0)

    def after(self, before: ControlSettings, settings: Settings, periods: int) -> Course:
        """The course of so many periods under ``settings``, which begin at tick 0 when the loop came to rest."""
        rest, ticks = self.rest * (1 + self.loop.delay), self.loop.ticks
        course = run(
            self.loop, lambda tick: before if tick < rest * ticks else settings(tick - rest * ticks), rest + periods
        )
        return Course(course.force[rest:], course.read[rest:], course.place[rest:], course.error[rest:])

    def force_step(self, settings: ControlSettings, periods: int) -> FloatArray:
        """(periods,) errors [N] from when the goal of the force rose by ``STEP``, under ``settings``."""
        calm = replace(settings, force_gain=min(settings.force_gain, self.calm), integral_time=math.inf)
        after = replace(settings, force_goal=GOAL + STEP)
        return self.after(calm, lambda _: after, periods).force - after.force_goal

    def place_step(self, gain: float, periods: int) -> FloatArray:
        """(periods, 2) errors [m] from when the goal of the place moved by ``WAY`` along its axis, at a gain [1/s]."""
        goal = (WAY * (1 - self.axis), WAY * self.axis)
        after = replace(self.held, path=(goal,), position_gain=gain)
        return self.after(self.held, lambda _: after, periods).place - goal

    def force_stable(self, settings: ControlSettings, *, periods: int = 80) -> bool:
        """Whether a step of the force dies away."""
        return not grows(self.force_step(settings, periods), 10 * STEP)

    def place_stable(self, gain: float, *, periods: int = 80) -> bool:
        """Whether a step of the place dies away."""
        try:
            return not grows(np.linalg.norm(self.place_step(gain, periods), axis=1), 5 * WAY)
        except MapError:  # the ball went over the border
            return False


def grows(errors: FloatArray, most: float) -> bool:
    """Whether errors (k,) are larger in the last quarter than in the second, or ever beyond ``most``."""
    quarter, sizes = len(errors) // 4, np.abs(errors)
    return bool(sizes.max() > most or sizes[-quarter:].max() > sizes[quarter : 2 * quarter].max())


def settled(errors: FloatArray, delay: int) -> int:
    """Samples until at most 2 % of a step are left for good, of which a law hears ``delay`` samples after it was.

    Args:
        errors: (k, m) from when a goal was moved, of which the law hears at once. They are taken from where they end:
            a place that is read between taxels is off by some of the way.
        delay: Samples.
    """
    off = np.linalg.norm(errors - errors[-5:].mean(axis=0), axis=1)
    return last_beyond(off, SETTLED * float(off[0])) + delay


def followed(bench: Bench, gain: float, speed: float, *, told: bool, periods: int) -> tuple[float, float]:
    """By how much a contact is behind its goal along x at the end [m]: as the law sees it, and in truth.

    Args:
        bench: The law before its loop.
        gain: Of the place [1/s].
        speed: Of the goal [m/s].
        told: Whether the law is told that the goal moves: it follows a path. Else the goal is put on at every tick.
        periods: How long it is followed.
    """
    tick, held = bench.loop.tick, replace(bench.held, position_gain=gain)
    end = 2 * speed * periods * bench.loop.period
    line = replace(held, task="follow_path", path_kind="polyline", path=((0.0, 0.0), (end, 0.0)), path_speed=speed)

    def goal(k: int) -> ControlSettings:
        return line if told else replace(held, path=((speed * tick * k, 0.0),))

    course = bench.after(held, goal, periods)
    last = max(periods // 4, 1)
    wanted = speed * bench.loop.period * np.arange(periods)
    return float(np.mean(course.error[-last:])), float(np.mean((wanted - course.place[:, 0])[-last:]))


def rippled(bench: Bench, gain: float, periods: int) -> tuple[float, float]:
    """Standard deviations of the true force and of the noise in what is read [N], at a force gain."""
    calm, settings = proportional(bench.law, bench.calm), proportional(bench.law, gain)
    course = bench.after(calm, lambda _: settings, periods)
    return float(np.std(course.force)), float(np.std(course.read - course.force))
