"""Notices that the force swings about its goal: the sign of a loop with more gain than skin, arm and cover can hold."""

from __future__ import annotations

from collections import deque

SWINGS = "the force swings; a lower force gain would calm it"
SHARE = 0.5
"""Of the goal, that an error has to pass on either side to count as a swing."""
TURNS, MEMORY = 5, 4.0
"""So many in so many seconds."""
GONE = 0.6
"""After so long without contact [s] all is forgotten: somebody tapped."""


class SwingWatch:
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
        side = 1 if over > SHARE * goal else -1 if over < -SHARE * goal else 0
        if goal > 0 and side and side != self._side:
            self._side = side
            self._turns.append(self._time)
        return len(self._turns) == TURNS and self._time - self._turns[0] < MEMORY
