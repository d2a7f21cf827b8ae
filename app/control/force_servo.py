"""Force error to speed along the normal: proportional and integral, bounded, without windup, one memory a contact."""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.control.command import ControlSettings

_LESS = 0.98
"""Share of an error that a later one has to be below to count as less."""


class ForceServo:
    """A PI force loop for each contact. Mutable: the integrals; a contact that is lost takes its own with it.

    The integral waits until the force has come as near to the goal as it comes without: it was reached once, or the
    error grew no less for ``integral_time`` (where the wish to be elsewhere holds against it). Integrating while the
    force first rises would push the arm into what it touches. And it stands while the speed is at its bound.

    Args:
        max_speed: Bound of the answer [m/s].
    """

    def __init__(self, max_speed: float) -> None:
        self._max_speed = max_speed
        self._integrals: dict[int, float] = {}
        self._reached: set[int] = set()
        self._least: dict[int, tuple[float, float]] = {}  # error, and for how long none was less

    def keep(self, contacts: Iterable[int]) -> None:
        """Forget all contacts but these."""
        kept = set(contacts)
        self._integrals = {id_: value for id_, value in self._integrals.items() if id_ in kept}
        self._reached &= kept
        self._least = {id_: seen for id_, seen in self._least.items() if id_ in kept}

    def integral(self, contact: int) -> float:
        """[N s] gathered for a contact."""
        return self._integrals.get(contact, 0.0)

    def push(self, settings: ControlSettings, contact: int, error: float, dt: float, limits: list[str]) -> float:
        """Outward speed of the touched point [m/s]: positive presses more.

        Args:
            settings: Of them ``force_gain`` and ``integral_time``; at inf the integral stands.
            contact: Which.
            error: Wanted minus measured force [N].
            dt: Since the last question [s].
            limits: Told when the answer is bounded.
        """
        self._gather(contact, error, dt, settings.integral_time)
        gathered = self.integral(contact)
        wanted = settings.force_gain * (error + gathered / settings.integral_time)
        bounded = min(max(wanted, -self._max_speed), self._max_speed)
        if bounded != wanted:
            self._integrals[contact] = gathered - error * dt if contact in self._reached else 0.0
            limits.append("speed of the touched point")
        return bounded

    def _gather(self, contact: int, error: float, dt: float, patience: float) -> None:
        if contact not in self._reached:
            least, waited = self._least.get(contact, (error, 0.0))
            self._least[contact] = (error, 0.0) if error < _LESS * least else (least, waited + dt)
            if error <= 0 or waited > patience:
                self._reached.add(contact)
        if contact in self._reached and math.isfinite(patience):
            self._integrals[contact] = self.integral(contact) + error * dt
