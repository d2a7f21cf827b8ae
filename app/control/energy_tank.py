"""An energy tank: what an arm may give to what it touches is what it was given, and what its damping took."""

from __future__ import annotations

FULL = 1.0
"""What a tank holds [J]: a hand followed with 3 N over 33 cm; a collision at 0.25 m/s of 5 kg is 0.16 J."""
LOW = 0.1
"""What stays in it [J]."""
RECOVERED = 0.5
"""Share of the damped power that may be used again."""


class EnergyTank:
    """Keeps count of the energy that contacts were given (Franken et al. 2011). Mutable; ``reset`` fills it.

    Attributes:
        level: What may still be given, with what stays [J].
        given: Net energy given to contacts since the reset [J]: a passivity observer; below zero the arm took.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Full, and nothing given."""
        self.level, self.given = FULL, 0.0

    def flow(self, given: float, damped: float, dt: float) -> None:
        """Count a tick.

        Args:
            given: Power to contacts, force times outward speed [W].
            damped: Power lost in the joints' damping [W], >= 0.
            dt: [s].
        """
        self.given += given * dt
        self.level = min(max(self.level + dt * (RECOVERED * damped - given), 0.0), FULL)

    @property
    def share(self) -> float:
        """How much of a motion that gives energy is allowed: 1, and smoothly to 0 as the tank runs low."""
        part = min(max((self.level - LOW) / LOW, 0.0), 1.0)
        return part * part * (3 - 2 * part)
