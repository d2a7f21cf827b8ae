"""The mode of the window."""

from __future__ import annotations

from enum import Enum, auto


class Mode(Enum):
    """What the window shows: nothing, a session that runs or is paused, or a recording."""

    EMPTY = auto()
    RUNNING = auto()
    PAUSED = auto()
    REPLAYING = auto()

    @property
    def takes_input(self) -> bool:
        """True if a session is shown that takes the user's input, now or at its next tick."""
        return self in (Mode.RUNNING, Mode.PAUSED)
