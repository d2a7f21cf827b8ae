"""The mode of the window."""

from __future__ import annotations

from enum import Enum, auto


class Mode(Enum):
    """Mode of the window: nothing, a running or paused session, or a recording is shown."""

    EMPTY = auto()
    RUNNING = auto()
    PAUSED = auto()
    REPLAYING = auto()

    @property
    def takes_input(self) -> bool:
        """True if a session is shown that takes the user's input, now or at its next tick."""
        return self in (Mode.RUNNING, Mode.PAUSED)
