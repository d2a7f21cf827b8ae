"""Stops a law that does a task when force or speed leave what is safe, and says why."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion

STOP_SPEED = 3.0
"""Of any joint [rad/s]; twice what laws ask for."""
QUIET = 1.0
"""Nothing must have touched for so long before the law goes on [s]."""


class Supervisor:
    """Decides between going on and standing. Mutable; ``reset`` lets the law go on.

    Attributes:
        reason: Why it stopped, in words; empty while the law goes on.
        posture: (n,) where it stopped.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Nothing is wrong."""
        self.reason, self._quiet = "", 0.0
        self.posture: FloatArray = np.zeros(0)

    def check(
        self, max_force: float, posture: FloatArray, velocity: FloatArray, regions: Sequence[ContactRegion], dt: float
    ) -> bool:
        """Whether the law may go on.

        Args:
            max_force: Of any contact [N].
            posture: (n,).
            velocity: (n,).
            regions: All contacts.
            dt: Since the last question [s].
        """
        reason = _danger(max_force, velocity, regions)
        if reason and not self.reason:
            self.reason, self.posture = f"stopped: {reason}; lift what touches to go on", posture.copy()
        if self.reason:
            self._quiet = 0.0 if regions or reason else self._quiet + dt
            if self._quiet >= QUIET:
                self.reset()
        return not self.reason


def _danger(max_force: float, velocity: FloatArray, regions: Sequence[ContactRegion]) -> str:
    for region in regions:
        if not (isfinite(region.force) and np.isfinite(region.normal).all() and np.isfinite(region.point).all()):
            return "the skin reads what is no number"
        if region.force > max_force:
            return f"{region.force:.0f} N of force, more than {max_force:.0f} N"
    fastest = float(np.abs(velocity).max(initial=0.0))
    return f"a joint at {fastest:.1f} rad/s" if fastest > STOP_SPEED else ""
