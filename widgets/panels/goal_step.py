"""Watches for steps of the force goal, and what the force made of the last one. No Qt."""

from __future__ import annotations

import math

import numpy as np

from app.control.step_response import StepResponse, step_response

LONGEST = 10.0
"""A step is watched for so long [s]."""
_LEAST = 0.05
"""Of a step [N]: less is no step."""
_MOVING = 0.5
"""A goal that changes again so soon is a slider on its way [s]: one step, which begins when it rests."""


class GoalStep:
    """Keeps what followed the last step while it lasted. Mutable: ``take`` and ``clear``."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Nothing has been seen."""
        self._goal = self._time = self._began = math.nan
        self._step: tuple[float, float] | None = None
        self._samples: list[tuple[float, float]] = []
        self._held = False

    def hold(self) -> None:
        """Something else was changed: what follows is no answer to the step any more; what was seen stays."""
        self._held = True

    def take(self, time: float, force: float, goal: float | None) -> None:
        """The force at ``time`` [s], and what is wanted [N]; None ends the watch, and keeps what it saw."""
        if not time >= self._time:
            self.clear()  # the first, or time ran backwards
        self._time = time
        if goal is None:
            self._goal = math.nan
            return
        if abs(goal - self._goal) > _LEAST:
            going_on = self._step is not None and time - self._began < _MOVING
            self._step = (self._step[0] if going_on and self._step else self._goal, goal)
            self._began, self._samples, self._held = time, [], False
        self._goal = goal
        if self._step is not None and not self._held and time - self._began <= LONGEST:
            self._samples.append((time - self._began, force))

    @property
    def response(self) -> StepResponse | None:
        """Of the last step; None before there was one. Cost: 50 µs."""
        if self._step is None or abs(self._step[1] - self._step[0]) <= _LEAST:
            return None
        times, forces = np.array(self._samples).T
        return step_response(times, forces, before=self._step[0], goal=self._step[1])


def step_words(response: StepResponse) -> str:
    """Like "Goal 3.0 → 6.0 N: 12 % over, settled in 0.42 s, ripple 0.05 N"."""
    parts = [f"{100 * response.overshoot:.0f}\u2009% over"]
    if math.isfinite(response.settling):
        parts += [f"settled in {response.settling:.2f}\u2009s", f"ripple {response.ripple:.2f}\u2009N"]
    else:
        parts.append("not settled yet")
    return f"Goal {response.before:.1f} → {response.goal:.1f}\u2009N: {', '.join(parts)}"
