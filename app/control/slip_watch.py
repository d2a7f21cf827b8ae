"""Notices that a contact does not come along the map as the arm wants it to, and why."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint

SHORTEST, LONGEST = 0.3, 2.0
"""For how long motion is compared [s]: an arm takes a while to follow, and slow errors are no hold."""
SHARE = 0.1
"""Share of it that must have come. Whither is not asked, if not back: on a map believed turned it comes sideways."""
AGAIN = 0.003
"""It is tried again when the error changed by so much [m]; beyond reach only when it became so much less or the target
is another, since a contact that is let go slides away by itself."""
ALONG, BEYOND = "the contact goes along with the skin", "the target is out of reach"
"""What holds a contact up: the arm moves and it does not slide; or the arm cannot move so."""
_JUMP = 0.005


class SlipWatch:
    """Compares what was asked for on the map with what came. Mutable; ``reset`` trusts again.

    A finger that tracks a place of the skin, a hand that holds it, or friction: then the arm would go on for ever. Or
    joints at their limits or stretched: then what the arm sets out to do already falls short of what is asked.

    Args:
        least: What must have been asked for before it is judged [m]; more than the taxels' pitch, since the centre of a
            contact smaller than that stays on a taxel until the next one feels it.

    Attributes:
        reason: What holds the contact up, in words; empty while it comes.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self.reset()

    def reset(self) -> None:
        """Nothing known."""
        self.reason, self._contact = "", 0
        self._start_window()
        self._error: FloatArray = np.zeros(2)
        self._point: FloatArray | None = None
        self._target: SurfacePoint | None = None

    def _start_window(self) -> None:
        self._time, self._asked, self._tried, self._came = 0.0, np.zeros(2), np.zeros(2), np.zeros(2)

    def look(
        self,
        contact: int,
        point: FloatArray,
        error: FloatArray,
        asked: FloatArray,
        tried: FloatArray,
        dt: float,
        *,
        target: SurfacePoint | None = None,
    ) -> str:
        """What holds the contact up; empty while it comes.

        Args:
            contact: Which; a new one is trusted to slide.
            point: (2,) where it is on the map [m].
            error: (2,) how far it has to go [m].
            asked: (2,) map velocity asked for [m/s].
            tried: (2,) the one that the arm set out to make, if the contact slides [m/s].
            dt: [s].
            target: Where it has to go.
        """
        moved = self._moved(contact, point)
        if self.reason and self._is_worth_another(error, target):
            self.reason = ""
            self._start_window()
        if self.reason:
            return self.reason
        self._time += dt
        self._asked, self._tried = self._asked + asked * dt, self._tried + tried * dt
        if np.linalg.norm(moved) < _JUMP:  # over a seam the place jumps
            self._came = self._came + moved
        if self._time > SHORTEST:
            self.reason = self._judged()
            self._error, self._target = error, target
        return self.reason

    def _moved(self, contact: int, point: FloatArray) -> FloatArray:
        """How far the contact went on the map (2,) since it was last seen."""
        if contact != self._contact:
            if self.reason != BEYOND:  # that is the arm's matter, whatever touches
                self.reset()
            self._contact, self._point = contact, None
        moved = np.zeros(2) if self._point is None else point - self._point
        self._point = point
        return moved

    def _judged(self) -> str:
        """What all that was asked, tried and came so far says."""
        asked, tried = float(np.linalg.norm(self._asked)), float(np.linalg.norm(self._tried))
        if asked > self._least and self._tried @ self._asked < SHARE * asked**2:
            return BEYOND
        enough, came = tried > self._least, float(np.linalg.norm(self._came))
        along = enough and (came < SHARE * tried or self._came @ self._tried < -SHARE * tried**2)
        if enough or self._time > LONGEST:
            self._start_window()
        return ALONG if along else ""

    def _is_worth_another(self, error: FloatArray, target: SurfacePoint | None) -> bool:
        if self.reason == ALONG:
            return bool(np.linalg.norm(error - self._error) > AGAIN)
        return target != self._target or bool(np.linalg.norm(error) < np.linalg.norm(self._error) - AGAIN)
