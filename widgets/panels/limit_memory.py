"""Which limits bounded the controller, and when: remembered for a while, so that none flickers by unread. No Qt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from app.session.law_figures import limit_name

LEGIBLE = 1.0
"""How long a limit is still said after it ended [s]."""
_JOINED = 0.1
"""What ends and begins again within this is one span [s]."""


class Limit(NamedTuple):
    """One limit as it is told: the newest words for it, and whether it is active now or only was."""

    words: str
    active: bool


class LimitMemory:
    """Spans of time by limit. Mutable: ``take`` and ``clear``.

    Args:
        seconds: How far back to remember [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self.seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._now = math.nan
        self._spans: dict[str, list[list[float]]] = {}
        self._words: dict[str, str] = {}
        self._active: tuple[str, ...] = ()

    def take(self, time: float, limits: Sequence[str]) -> None:
        """These bound the controller at ``time`` [s]; time that jumps, or runs backwards, starts a new memory."""
        if not 0 <= time - self._now <= self.seconds:
            self.clear()
        before, self._now = self._active, time
        self._active = tuple(dict.fromkeys(limit_name(limit) for limit in limits))
        self._words |= {limit_name(limit): limit for limit in limits}
        for name in self._active:
            spans = self._spans.setdefault(name, [])
            if spans and (name in before or time - spans[-1][1] <= _JOINED):
                spans[-1][1] = time
            else:
                spans.append([time, time])
        self._forget()

    @property
    def told(self) -> tuple[Limit, ...]:
        """Those active now as they came, then those that ended within ``LEGIBLE``, the newest first."""
        ended = [(spans[-1][1], name) for name, spans in self._spans.items() if name not in self._active]
        recent = [name for end, name in sorted(ended, reverse=True) if self._now - end <= LEGIBLE]
        return (
            *(Limit(self._words[name], True) for name in self._active),
            *(Limit(self._words[name], False) for name in recent),
        )

    @property
    def rows(self) -> tuple[tuple[str, tuple[tuple[float, float], ...]], ...]:
        """Name and spans of each limit remembered, first come first, as ages [s], 0 for now and below before."""
        return tuple(
            (name, tuple((max(start - self._now, -self.seconds), end - self._now) for start, end in spans))
            for name, spans in self._spans.items()
        )

    def _forget(self) -> None:
        oldest = self._now - self.seconds
        for name in tuple(self._spans):
            self._spans[name] = [span for span in self._spans[name] if span[1] >= oldest]
            if not self._spans[name]:
                del self._spans[name], self._words[name]
