"""Timing of the skin's readings, and signs of a force loop with too much gain for them.

``SensorTiming`` contains period, delay and largest value of readings. ``OscillationDetector`` detects that the force
oscillates about its goal, the sign of a loop with more gain than skin, arm and cover allow; ``gain_limits`` computes
the allowed gain. ``step_response`` computes overshoot, settling time and remaining ripple after a step of a goal.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray

_NEAR = 0.98
"""Share of the largest reading from which a taxel may be saturated: noise and quantization hide the rest."""


@dataclass(frozen=True)
class SensorTiming:
    """Timing and range of a skin's readings, as specified by its maker.

    Attributes:
        period: Time between two samples [s]; > 0.
        delay: Time from a sample to its arrival [s].
        highest: Largest reading of a taxel [Pa].
        averaged: Whether a sample is the mean over its period. The ``delay`` of a slow skin then includes half of the
            period; that of a skin read at every tick is zero.
    """

    period: float
    delay: float = 0.0
    highest: float = math.inf
    averaged: bool = False


def assume_goal_where_saturated(
    regions: Sequence[ContactRegion], goal: float, highest: float
) -> tuple[tuple[ContactRegion, ...], bool]:
    """Return regions with at least the ``goal`` force [N] if saturated, and whether a taxel reads ``highest`` [Pa].

    The force on such a region is at least the reading. With less than the goal the controller would press without end,
    at the same reading.
    """
    if not any(region.peak >= _NEAR * highest for region in regions):
        return tuple(regions), False
    taken = [
        replace(region, force=max(region.force, goal)) if region.peak >= _NEAR * highest else region
        for region in regions
    ]
    return tuple(sorted(taken, key=lambda region: (-region.force, region.id))), True


CONTACT_STIFFNESS = 2e4
"""Nominal stiffness of an object and the skin's cover [N/m], used until it is measured (``contact_stiffness``)."""


SWING_SHARE = 0.5
"""Share of the goal that an error has to exceed on either side to count as a swing."""
BOUNCE_SHARE = 0.25
"""Share of the goal by which the force may stay below the goal to count as a swing after the contact was lost."""
TURNS = 5
MEMORY = 4.0
"""Number of swings within this time [s] that count as an oscillation."""
GONE = 0.6
"""Time without contact [s] after which all swings are discarded."""
IN_PHASE = 0.5
"""Least correlation of the force with the way of the skin in an oscillation of the loop."""
ABSORBED = 0.4
"""Share of the swing energy that the arm absorbs if something else taps it; measured with a finger: 0.97, and 0.49 in
the last of eight taps at 4 Hz on an arm that has already yielded."""
FAST = 0.25
"""Time [s] within which swings are faster than a person taps: five to either side at 8 Hz."""


class OscillationDetector:
    """Detects that the loop of skin, arm and contact makes the force oscillate about its goal. Mutable.

    The error has to change sides ``TURNS`` times within ``MEMORY``, by more than ``SWING_SHARE`` of the goal each time.
    The force also has to rise and fall with the way of the skin along its normal: the two are in phase where the arm
    presses on something elastic, whatever the delays in the loop are. Where something else taps or pushes the arm, the
    arm yields, and they are not, or the arm absorbs the energy. The contact may be lost in each swing: the force then
    counts from ``BOUNCE_SHARE`` below the goal. Swings within ``FAST`` count in any phase, since a cover that damps, or
    has much mass, responds to the arm's speed or acceleration and not to its way.

    Attributes:
        quiet: Time since the error last changed sides [s]; inf before the first swing.

    Cost: 0.5 µs a tick; 30 µs while the error swings.
    """

    def __init__(self) -> None:
        self.quiet = math.inf
        self.reset()

    def reset(self) -> None:
        """Discard all swings; ``quiet`` continues."""
        self._time = 0.0
        self._side = 0
        self._gone = 0.0
        self._lost = False
        self._turns: deque[float] = deque(maxlen=TURNS)
        self._samples: deque[tuple[float, float, float]] = deque()

    def look(self, goal: float, force: float, way: float, dt: float) -> bool:
        """Return whether the force oscillates.

        Args:
            goal: Desired force of the contact [N]; with zero the result is False.
            force: Force of the contact [N]; 0 if it was lost.
            way: Outward displacement of the touched point when the force was sampled [m], from any origin.
            dt: Time since the previous call [s].
        """
        self.quiet += dt
        self._gone = 0.0 if force > 0 else self._gone + dt
        if self._gone > GONE:
            self.reset()
        self._time += dt
        self._samples.append((self._time, force, way))
        while self._time - self._samples[0][0] > MEMORY:
            self._samples.popleft()
        over = force - goal
        upper = -BOUNCE_SHARE if self._lost else SWING_SHARE
        side = 1 if over > upper * goal else -1 if over < -SWING_SHARE * goal else 0
        if goal > 0 and side and side != self._side:
            self.quiet = 0.0 if self._side else self.quiet
            self._side = side
            self._turns.append(self._time)
        self._lost = force <= 0 or (self._lost and side <= 0)
        if len(self._turns) < TURNS or self._time - self._turns[0] >= MEMORY:
            return False
        return self._turns[-1] - self._turns[0] < FAST or self._driven()

    def _driven(self) -> bool:
        """Return whether the arm drives the swings: the force follows its way, and it does not absorb their energy."""
        samples = np.array([sample for sample in self._samples if sample[0] >= self._turns[0]])
        time, over, way = (samples - samples.mean(axis=0)).T
        way = way - time * (time.dot(way) / time.dot(time))
        size = math.sqrt(float(over.dot(over) * way.dot(way)))
        if size == 0 or float(over.dot(way)) <= IN_PHASE * size:
            return False
        work = samples[1:, 1] * np.diff(way)
        return float(work.sum()) > -ABSORBED * float(np.abs(work).sum())


BAND = 0.05
"""Share of the step within which a response has settled."""
_LEAST_STEADY = 5


@dataclass(frozen=True)
class StepResponse:
    """Response to one step.

    Attributes:
        before: Goal before the step [N, or the unit of the response].
        goal: Goal after the step.
        overshoot: Share of the step by which the response exceeded its goal, >= 0.
        settling: Time from the step until the response stayed within ``BAND`` of the step about its goal [s]; None if
            it has not settled.
        ripple: Standard deviation about the mean since then; None with too few samples.
    """

    before: float
    goal: float
    overshoot: float
    settling: float | None
    ripple: float | None


def step_response(time: FloatArray, values: FloatArray, *, before: float, goal: float) -> StepResponse:
    """Compute overshoot, settling time and ripple of a response.

    Args:
        time: (n,) time since the step [s], rising.
        values: (n,) response.
        before: Goal before the step.
        goal: Different goal after the step.
    """
    step = goal - before
    shares = (values - before) / step  # 0 before, 1 at the goal, for steps up and down
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
