"""Settings, effects, behaviours and reading in force in what is shown, each told once a change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactile_maps.session.runtime_settings import RuntimeSettings


class ActiveSettings:
    """Tells each part of the settings in force only when it is another one. Mutable.

    Args:
        tell: By field of ``RuntimeSettings``, who is told its value.
    """

    def __init__(self, **tell: Callable[[Any], None]) -> None:
        self._tell = tell
        self._told: RuntimeSettings | None = None

    def show(self, now: RuntimeSettings) -> None:
        """These are in force in what is shown."""
        before = self._told
        self._told = now
        if now is before:
            return
        for field, tell in self._tell.items():
            if before is None or getattr(before, field) != getattr(now, field):
                tell(getattr(now, field))

    def forget(self) -> None:
        """Something else is shown: what is in force there is told even where it is the same."""
        self._told = None
