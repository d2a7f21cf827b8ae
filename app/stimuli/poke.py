"""A poke: press at one place, hold, lift."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from app.stimuli.place import Ground, Place
from app.stimuli.stimulus import Stimulus
from app.stimuli.track import Track, still


@dataclass(frozen=True, kw_only=True)
class Poke(Stimulus):
    """Press at one place, hold, lift.

    Attributes:
        at: Where.
        hold: From the press to the lift [s].
    """

    kind: ClassVar[str] = "poke"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {"hold": (0.0, 3600.0)}

    at: Place = (0.5, 0.25)
    hold: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_place("at", self.at)

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One finger that stays."""
        patch = ground.patch(self.patch)
        return (still(0, self.tip, patch, ground.point(patch, self.at), press=0.0, lift=self.hold),)
