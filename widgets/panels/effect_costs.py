"""What effects cost, in words: stages as they run here, the rest as measured beside. No Qt."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from app.scene.decide import EffectRow
from app.timing import Timings

_WINDOW = 120
_FINEST = 0.005
"""Milliseconds below which two digits say nothing; a difference may even be negative, lost in the noise."""
_STAGES = {"skin": "touch"}
"""Stages that are called otherwise than their effect."""
_LIVE = "Median of the last {count} ticks, as it runs now"
_BESIDE = "Measured beside, on this scene with and without it"


@dataclass(frozen=True)
class Cost:
    """Milliseconds a tick in words; ``beside`` if they were not measured in the session that runs."""

    words: str
    beside: bool
    tip: str


class EffectCosts:
    """Collects stage times. Mutable: ``add`` ticks, set ``prices``.

    Attributes:
        prices: Milliseconds a tick by key of an effect, for those that are no stage of their own.
    """

    def __init__(self) -> None:
        self.prices: Mapping[str, float] = {}
        self.clear(0.0)

    def clear(self, tick: float) -> None:
        """Forget another scene's times; ``tick`` is the new one's [s]."""
        self._tick, self.prices = tick, {}
        self._stages: dict[str, deque[float]] = {}
        self._totals: deque[float] = deque(maxlen=_WINDOW)

    def add(self, timings: Timings) -> None:
        """Take one tick's stage times."""
        for stage, milliseconds in timings.ms.items():
            self._stages.setdefault(stage, deque(maxlen=_WINDOW)).append(milliseconds)
        for stage in [stage for stage in self._stages if stage not in timings.ms]:
            del self._stages[stage]  # switched off: what it cost is of another state
        self._totals.append(timings.total_ms)

    def of(self, row: EffectRow) -> Cost:
        """What an effect costs now."""
        if not row.on:
            return Cost("–", False, "Off: it costs nothing")
        times = self._stages.get(_STAGES.get(row.name, row.name))
        if times:
            return Cost(_words(float(np.median(times))), False, _LIVE.format(count=len(times)))
        if row.name in self.prices:
            return Cost(_words(self.prices[row.name]), True, _BESIDE)
        if self.prices:
            return Cost("–", True, "It has no price of its own: nothing runs without it")
        return Cost("…", True, "Being measured beside")

    @property
    def total(self) -> str:
        """All of a tick, beside the time there is for it in real time; empty before the first tick."""
        if not self._totals:
            return ""
        return f"{float(np.median(self._totals)):.2f} of {1e3 * self._tick:g}\u2009ms a tick"


def _words(milliseconds: float) -> str:
    return f"<{2 * _FINEST:.2f}" if milliseconds < _FINEST else f"{milliseconds:.2f}"
