"""What the window shows: nothing, a session that runs or stands still, or a recording."""

from __future__ import annotations

from enum import StrEnum


class Mode(StrEnum):
    """The mode of the session; its values are those of ``LiveSession.mode``."""

    EMPTY = "empty"
    LIVE = "live"
    PAUSED = "paused"
    REPLAYING = "replaying"

    @property
    def running(self) -> bool:
        """Whether there is a session that takes what a person wants, now or at its next tick."""
        return self in (Mode.LIVE, Mode.PAUSED)
