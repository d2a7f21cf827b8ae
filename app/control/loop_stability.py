"""What a force loop can hold with a skin that is read so seldom and so late, and the signs of one that asks for more.

``SensorTiming`` is what a controller knows of the skin's readings: how often they come, how late, and how high they go.
``GainLimiter`` holds gains to what that allows, or says that they are more. ``OscillationDetector`` notices that the
force swings about its goal: the sign of a loop with more gain than skin, arm and cover can hold. ``step_response``
reads overshoot, settling time and the ripple that stays from a step of a goal.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.contacts.regions import ContactRegion
from app.control.command import ControlSettings
from app.control.joint_impedance import INNER_FREQUENCY, JointImpedance
from app.control.limits import Limit, LimitKind
from app.core.arrays import FloatArray
from app.robots.kinematics import Configuration
from app.robots.robot import Robot

_NEAR = 0.98
"""Share of the highest reading from which a taxel may stand at it: noise and steps of the converter hide the rest."""


@dataclass(frozen=True)
class SensorTiming:
    """Of a skin as its maker says.

    Attributes:
        period: From one sample to the next [s]; > 0.
        delay: From a sample to its arrival [s].
        highest: What a taxel reads at most [Pa].
    """

    period: float
    delay: float = 0.0
    highest: float = math.inf


def assume_goal_where_saturated(
    regions: Sequence[ContactRegion], goal: float, highest: float
) -> tuple[tuple[ContactRegion, ...], bool]:
    """The regions as a controller may take them, and whether a taxel stands at its ``highest`` reading [Pa] in any.

    The force on such a region is at least what is read. It counts as no less than the ``goal`` [N], or the controller
    would press on and on and read the same.
    """
    if not any(region.peak >= _NEAR * highest for region in regions):
        return tuple(regions), False
    taken = [
        replace(region, force=max(region.force, goal)) if region.peak >= _NEAR * highest else region
        for region in regions
    ]
    return tuple(sorted(taken, key=lambda region: (-region.force, region.id))), True


CONTACT_STIFFNESS = 2e4
"""Of what touches and the skin's cover [N/m], nominal; the joints that hold the arm are in series with it."""

GAIN_SHARE = 0.3
"""Of the limit of stability, that limited gains take: without overshoot, and with room for a stiffer contact."""
_PATIENCE = 12.0
"""An integral is no faster than so many times what passes from a touch to its reading: it follows the answer."""


def sampled_loop_limit(delay: float) -> float:
    """Greatest stable gain of a sampled integral loop with ``delay`` samples: 2 sin(pi / (2 (2 d + 1)))."""
    return 2 * math.sin(math.pi / (2 * (2 * delay + 1)))


def max_stable_gain(stiffness: float, readings: SensorTiming) -> float:
    """The largest force gain [m/s/N] with which a sampled loop against a spring is stable.

    k_f k T below ``sampled_loop_limit``; within 20 % on a whole arm whose joints settle faster than the samples come.

    Args:
        stiffness: Force per way of the wanted posture [N/m].
        readings: Of the skin.
    """
    return sampled_loop_limit(readings.delay / readings.period) / (stiffness * readings.period)


class GainLimiter:
    """Compares gains with what the skin's times allow at the place first touched. Mutable.

    Where settings are ``limited``, the force gain is held to ``GAIN_SHARE`` of the most that a sampled loop can hold,
    the integral is no faster than its answer, and the place gets its share of one over what passes from a touch to its
    reading. Against something softer than ``CONTACT_STIFFNESS`` more would do.

    Args:
        robot: Whose joints hold the arm against the contact.

    Attributes:
        readings: Of the skin; None says nothing.

    Cost: 20 µs when another contact or other settings come, else 1 µs.
    """

    def __init__(self, robot: Robot) -> None:
        self._configuration = Configuration(robot)
        inertia = self._configuration.inertia()
        held = JointImpedance(inertia, frequency=INNER_FREQUENCY, damping_ratio=1.0)
        self._give = 1 / held.stiffness  # [rad/(N m)]
        self.readings: SensorTiming | None = None
        self.reset()

    def reset(self) -> None:
        """Nothing has touched."""
        self._asked: tuple[int, ControlSettings, SensorTiming] | None = None
        self._answer: tuple[ControlSettings, tuple[Limit, ...]] = ControlSettings(), ()

    def effective_settings(
        self, settings: ControlSettings, posture: FloatArray, regions: Sequence[ContactRegion]
    ) -> tuple[ControlSettings, tuple[Limit, ...]]:
        """The settings as a controller may take them, and the limits that this is while something touches.

        Args:
            settings: As they are set. What was made of them stays while nothing touches, since what was lost is sought
                at their speed.
            posture: (n,).
            regions: All contacts, the strongest first.
        """
        if self.readings is None or settings.controller == "impedance":
            return settings, ()
        known = self._asked
        if regions and known != (regions[0].id, settings, self.readings):
            self._asked = known = regions[0].id, settings, self.readings
            most = max_stable_gain(self._stiffness(posture, regions[0]), self.readings)
            self._answer = _limited(settings, most, self.readings)
        if known is None or known[1:] != (settings, self.readings):
            return settings, ()
        return self._answer[0], self._answer[1] if regions else ()

    def _stiffness(self, posture: FloatArray, region: ContactRegion) -> float:
        """Force per way [N/m] along a contact's normal: of the joints in series with what touches."""
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation @ region.link_normal
        row = normal @ self._configuration.jacobian(region.link, region.link_position)
        return 1 / (1 / CONTACT_STIFFNESS + float(np.sum(row**2 * self._give)))


def _limited(
    settings: ControlSettings, most: float, readings: SensorTiming
) -> tuple[ControlSettings, tuple[Limit, ...]]:
    """Gains that can be held, and what was held back; as they are set, whether they can be."""
    if settings.gains == "as_given":
        high = Limit(
            LimitKind.FORCE_GAIN_UNSTABLE,
            value=settings.force_gain, bound=most, period=readings.period, delay=readings.delay,
        )  # fmt: skip
        return settings, (high,) if settings.force_gain > most else ()
    wait = readings.period + readings.delay
    force, place = min(settings.force_gain, GAIN_SHARE * most), min(settings.position_gain, GAIN_SHARE / wait)
    integral = max(settings.integral_time, _PATIENCE * wait)
    held = [
        (LimitKind.FORCE_GAIN_HELD, force, settings.force_gain),
        (LimitKind.POSITION_GAIN_HELD, place, settings.position_gain),
    ]
    limits = tuple(
        Limit(kind, value=value, bound=asked, period=readings.period, delay=readings.delay)
        for kind, value, asked in held
        if value < asked
    )
    return replace(settings, force_gain=force, position_gain=place, integral_time=integral), limits


SWING_SHARE = 0.5
"""Of the goal, that an error has to pass on either side to count as a swing."""
TURNS, MEMORY = 5, 4.0
"""So many in so many seconds."""
GONE = 0.6
"""After so long without contact [s] all is forgotten: somebody tapped."""


class OscillationDetector:
    """Counts how often the error changes sides, each time by much. Mutable; ``reset`` forgets.

    A moving hand does not do that: it comes and goes at its own pace, and the force is pulled to one side at a time.

    Cost: 0.5 µs a tick.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """All is calm."""
        self._time, self._side, self._gone = 0.0, 0, 0.0
        self._turns: deque[float] = deque(maxlen=TURNS)

    def look(self, goal: float, force: float, dt: float) -> bool:
        """Whether it swings.

        Args:
            goal: Wanted of the contact [N]; with none nothing swings.
            force: On it [N]; 0 where it was lost.
            dt: Since the last question [s].
        """
        self._gone = 0.0 if force > 0 else self._gone + dt
        if self._gone > GONE:
            self.reset()
        self._time += dt
        over = force - goal
        side = 1 if over > SWING_SHARE * goal else -1 if over < -SWING_SHARE * goal else 0
        if goal > 0 and side and side != self._side:
            self._side = side
            self._turns.append(self._time)
        return len(self._turns) == TURNS and self._time - self._turns[0] < MEMORY


BAND = 0.05
"""Of the step; what stays within it has settled."""
_LEAST_STEADY = 5


@dataclass(frozen=True)
class StepResponse:
    """Of one step.

    Attributes:
        before: The goal before [N, or what it is the goal of].
        goal: The goal after.
        overshoot: Share of the step by which the answer went beyond its goal, >= 0.
        settling: From the step until the answer stayed within ``BAND`` of the step about its goal [s]; None where it
            has not yet, or left again.
        ripple: Standard deviation about its own mean since then; None without samples enough.
    """

    before: float
    goal: float
    overshoot: float
    settling: float | None
    ripple: float | None


def step_response(time: FloatArray, values: FloatArray, *, before: float, goal: float) -> StepResponse:
    """Read a response.

    Args:
        time: (n,) since the step [s], rising.
        values: (n,) of what follows the goal.
        before: The goal before the step.
        goal: Another one, since.
    """
    step = goal - before
    shares = (values - before) / step  # 0 before, 1 at the goal, whichever way it goes
    outside = np.flatnonzero(np.abs(shares - 1) > BAND)
    first = int(outside[-1]) + 1 if outside.size else 0
    steady = values[first:]
    enough = len(steady) >= _LEAST_STEADY
    return StepResponse(
        before=before,
        goal=goal,
        overshoot=max(float(shares.max(initial=1.0)) - 1, 0.0),
        settling=float(time[first]) if enough else None,
        ripple=float(steady.std()) if enough else None,
    )
