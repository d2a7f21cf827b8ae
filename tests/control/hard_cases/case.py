"""Catalogue of difficult cases for control by touch, each with its stated outcome.

A ``HardCase`` sets up the whole arm, states the outcome in words, and checks it. The groups are in ``postures``,
``environments``, ``sensing``, ``maps`` and ``events``, each with its ``CASES`` by name. ``check_bounds`` applies to all
of them: finite values, joints no faster than twice the controllers' limit, a bound on the true force whatever the
sensor reads, and a stated reason for whatever stops or limits the arm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tests.support.loop_trials import max_stable_gain
from tests.support.pressed_arm import Act, Course, forearm

Check = Callable[[Course], None]
GOAL = 3.0
"""Force goal of most cases [N]."""
GAIN = 0.015
"""Force gain of most cases [m/s/N]: three times the default, so that the stability margin is small."""
SOME = ("admittance", "hybrid", "qp")
OTHERS = ("parallel", "projection", "priority", "hold_force")
"""Controllers that take turns where one case more says little new of each."""
SERIES = 5500.0
"""Stiffness that the arm's own servo and a cover of 2e4 N/m have in series at the usual place [N/m]."""
MASS = 5.0
"""Approximate effective mass of the arm at the forearm [kg]."""


STOPPED = tuple(kind for kind in LimitKind if kind.stops)


@dataclass(frozen=True)
class HardCase:
    """A difficult case with its stated outcome.

    Attributes:
        stated: Required outcome, with the reason.
        start: Builds the session from the controller's settings.
        check: Asserts the outcome.
        settings: Settings that differ from the defaults, apart from the controller.
        seconds: Duration [s].
        acts: Actions on the session by time [s].
        force: Bound on the true total force [N].
        says: Required limits of the controller: one of each tuple.
        controllers: Controllers for which the outcome is required.
        between: Whether the neighbouring cases of its series cover it, so that it runs only with ``--all``.
    """

    stated: str
    start: Callable[[ControlSettings], Session]
    check: Callable[[Course], None]
    settings: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 3.0
    acts: Mapping[float, Act] = field(default_factory=dict)
    force: float = 15.0
    says: tuple[tuple[LimitKind, ...], ...] = ()
    controllers: tuple[str, ...] = tuple(CONTROL_SCHEMES)
    between: bool = False

    def session(self, controller: str) -> Session:
        """Return a new session with a controller."""
        return self.start(ControlSettings(**{"controller": controller, "force_gain": GAIN, **self.settings}))

    def play(self, controller: str, *, seconds: float | None = None) -> Course:
        """Run the case with a controller."""
        return Course(self.session(controller), seconds or self.seconds, acts=self.acts)


def runs(cases: Mapping[str, HardCase]) -> list[Any]:
    """Every case with every controller for which it is promised; by default with one, controllers taking turns, and
    of a series not those between.
    """
    return [
        pytest.param(
            name,
            controller,
            marks=() if turn == k % len(case.controllers) and not case.between else pytest.mark.long,
        )
        for k, (name, case) in enumerate(cases.items())
        for turn, controller in enumerate(case.controllers)
    ]


def check(case: HardCase, controller: str) -> None:
    """Play a case under one controller: what holds for all, and what was stated."""
    course = case.play(controller)
    check_bounds(course, case)
    case.check(course)


def check_repeats(case: HardCase) -> None:
    """The same seed gives the same numbers, bit for bit."""
    controller = case.controllers[len(case.stated) % len(case.controllers)]
    one, other = (case.play(controller, seconds=0.3) for _ in range(2))
    for name in ("force", "pressed", "posture"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    assert one.said == other.said


def check_bounds(course: Course, case: HardCase) -> None:
    """Check the bounds of every case and controller."""
    for values in (course.force, course.pressed, course.speed, course.posture, course.given):
        assert np.isfinite(values).all()
    assert course.pressed.max() < case.force
    assert course.speed.max() < 2 * MAX_JOINT_SPEED
    for kinds in case.says:
        assert course.why.intersection(kinds), (kinds, course.why)
    stopped = [k for k, why in enumerate(course.said) if any(limit.kind.stops for limit in why)]
    if not stopped:
        # What stops is the force that is read; only of a slow sensor that is the mean over its sample.
        slow = course.session.effects.sensor.sampling is not None
        assert (course.force if slow else course.pressed).max() <= course.session.settings.max_force


def kept(goal: float = GOAL, *, within: float = 0.15, ripple: float = 0.15, seconds: float = 1.0) -> Check:
    """The force that truly presses comes to ``goal`` [N] and stays there."""

    def check(course: Course) -> None:
        pressed = course.last(course.pressed, seconds)
        assert abs(pressed.mean() - goal) < within, pressed.mean()
        assert pressed.std() < ripple, pressed.std()

    return check


def arrives(within: float = 0.002, *, seconds: float = 0.5) -> Check:
    """The contact arrives at the goal of the task, ``within`` a distance on the map [m]."""

    def check(course: Course) -> None:
        error = course.last(course.error, seconds)
        assert np.isfinite(error).all(), "in touch"
        assert error.max() < within, error.max()

    return check


def rests(speed: float = 0.03, *, seconds: float = 0.5) -> Check:
    """The arm comes to rest: no joint faster than that [rad/s]."""

    def check(course: Course) -> None:
        assert course.last(course.speed, seconds).max() < speed

    return check


def both(*checks: Check) -> Check:
    """All of them."""

    def check(course: Course) -> None:
        for one in checks:
            one(course)

    return check


def bounded_only(_course: Course) -> None:
    """Require nothing beyond ``check_bounds``."""


def next_to_taxel(taxel: int, along: float, across: float) -> tuple[tuple[float, float]]:
    """A path of one point on the map [m], so far from a taxel of ``forearm``."""
    point = forearm().map.taxel_points[taxel]
    return ((float(point[0]) + along, float(point[1]) + across),)


def scaled(readings: SensorTiming, *, share: float = 0.3) -> dict[str, Any]:
    """Gains that a skin so read can hold: a share of the limit, and an integral slow enough not to matter for it."""
    delay = readings.delay + readings.period
    return {
        "gains": "as_given",
        "force_gain": min(share * max_stable_gain(SERIES, readings), GAIN),
        "integral_time": max(0.3, 12 * delay),
        "position_gain": min(4.0, share / delay),
        "inertia_time": min(0.05, delay),
    }


def hammering(readings: SensorTiming, *, gain: float = GAIN, goal: float = GOAL) -> float:
    """[N] the most that a loop beyond its limit comes to, meeting what it lost at the speed it looks for it with.

    v (sqrt(m k) + k (d + 1) T) over the goal, with v = gain goal (theory page, 5.6), and half as much again for what
    the arm has in other directions.
    """
    speed = gain * goal
    late = readings.delay + 2 * readings.period
    return goal + 1.5 * speed * (np.sqrt(MASS * SERIES) + SERIES * late)


def change(**settings: Any) -> Act:
    """A person changes settings."""
    return lambda session: session.submit(ControlChanged(replace(session.settings, **settings)))


def narrowed(most: float, *joints: str) -> PreparedScene:
    """The arm whose joints, or only those named, are limited to stay within ``most`` [rad] of home."""
    prepared = forearm()
    limited = tuple(
        replace(joint, lower=home - most, upper=home + most) if joint.name in joints or not joints else joint
        for joint, home in zip(prepared.robot.joints, map(float, prepared.robot.home), strict=True)
    )
    return replace(prepared, robot=replace(prepared.robot, joints=limited))


def stretched() -> PreparedScene:
    """The arm with all joints at zero: straight up, so that nothing on it can go along it, or to one side."""
    prepared = forearm()
    limits = [(joint.lower, joint.upper) for joint in prepared.robot.joints]
    home = np.clip(np.zeros(len(limits)), *np.transpose(limits))
    return replace(prepared, robot=replace(prepared.robot, home=home))
