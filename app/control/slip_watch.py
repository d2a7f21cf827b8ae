"""Notices that a contact goes along with the skin, so that moving the arm cannot move it on the map."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray

SHORTEST, LONGEST = 0.3, 2.0
"""For how long motion is compared [s]: an arm takes a while to follow, and slow errors are no hold."""
SHARE = 0.2
"""Share of it that must have come."""
AGAIN = 0.003
"""It is tried again when the error changed by so much [m]."""
_JUMP = 0.005


class SlipWatch:
    """Compares what was asked for on the map with what came. Mutable; ``reset`` trusts again.

    A finger that tracks a place of the skin, a hand that holds it, or friction: then the arm would go on for ever.

    Args:
        least: What must have been asked for before it is judged [m]; more than the taxels' pitch, since the centre of a
            contact smaller than that stays on a taxel until the next one feels it.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self.reset()

    def reset(self) -> None:
        """Nothing known."""
        self.stuck, self._contact = False, 0
        self._start_window()
        self._error: FloatArray = np.zeros(2)
        self._point: FloatArray | None = None

    def _start_window(self) -> None:
        self._time, self._asked, self._came = 0.0, np.zeros(2), np.zeros(2)

    def look(self, contact: int, point: FloatArray, error: FloatArray, asked: FloatArray, dt: float) -> bool:
        """Whether the contact is stuck to the skin.

        Args:
            contact: Which; a new one is trusted.
            point: (2,) where it is on the map [m].
            error: (2,) how far it has to go [m].
            asked: (2,) map velocity asked for [m/s].
            dt: [s].
        """
        if contact != self._contact:
            self.reset()
            self._contact = contact
        moved = np.zeros(2) if self._point is None else point - self._point
        self._point = point
        if self.stuck:
            if np.linalg.norm(error - self._error) > AGAIN:
                self.stuck = False
                self._start_window()
            return self.stuck
        self._time += dt
        self._asked = self._asked + asked * dt
        if np.linalg.norm(moved) < _JUMP:  # over a seam the place jumps
            self._came = self._came + moved
        length = float(np.linalg.norm(self._asked))
        if (length > self._least and self._time > SHORTEST) or self._time > LONGEST:
            if length > self._least and self._came @ self._asked < SHARE * length**2:
                self.stuck, self._error = True, error
            self._start_window()
        return self.stuck
