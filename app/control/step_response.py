"""What a step of a goal shows of a loop: overshoot, settling time, and the ripple that stays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray

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
        settling: From the step until the answer stayed within ``BAND`` of the step about its goal [s]; NaN where it has
            not yet, or left again.
        ripple: Standard deviation about its own mean since then; NaN without samples enough.
    """

    before: float
    goal: float
    overshoot: float
    settling: float
    ripple: float


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
        settling=float(time[first]) if enough else np.nan,
        ripple=float(steady.std()) if enough else np.nan,
    )
