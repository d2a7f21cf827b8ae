"""What the user does on a view, as a small state machine without Qt: poke on the skin, move the view beside it."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from enum import Enum

from tactile_maps.geometry.surface.mesh import SurfacePoint


@dataclass(frozen=True)
class Pressed:
    """A finger touched the skin at ``at``."""

    at: SurfacePoint


@dataclass(frozen=True)
class Moved:
    """The finger stroked to ``at``."""

    at: SurfacePoint


@dataclass(frozen=True)
class Released:
    """The finger left the skin."""


@dataclass(frozen=True)
class Panned:
    """The view was dragged by this many pixels."""

    dx: float
    dy: float


@dataclass(frozen=True)
class Clicked:
    """The button came up where it went down, at this pixel over ``at``: no drag, and no poke."""

    pixel: tuple[float, float]
    at: SurfacePoint | None


PokeEvent = Pressed | Moved | Released | Panned | Clicked


class PokeState(Enum):
    """What the user is doing."""

    IDLE = "idle"
    POKING = "poking"
    PANNING = "panning"


class PokeGesture:
    """Turns presses, moves and releases into acts. Mutable; ``cancel`` brings it back to idle.

    A stroke that leaves the patches stays at its last point until it comes back onto one.
    """

    def __init__(self) -> None:
        self.mode = PokeState.IDLE
        self._at: SurfacePoint | None = None
        self._pixel = (0.0, 0.0)
        self._button: Hashable = None
        self._slack = 0.0

    def press(
        self,
        pixel: tuple[float, float],
        at: SurfacePoint | None,
        *,
        button: Hashable = None,
        pan: bool = False,
        slack: float = 0.0,
    ) -> PokeEvent | None:
        """``button`` went down over ``at``; ``pan`` when the button or a key asks for panning.

        With ``slack`` [px] the view stays until the pointer has left so much room around the press; a button that
        comes up before has clicked.
        """
        if self.mode is not PokeState.IDLE:
            return None
        self._pixel = pixel
        self._at = at
        self._button = button
        self._slack = slack
        if at is None or pan:
            self.mode = PokeState.PANNING
            return None
        self.mode = PokeState.POKING
        return Pressed(at)

    def move(self, pixel: tuple[float, float], at: SurfacePoint | None) -> PokeEvent | None:
        """The pointer moved to ``pixel`` over ``at``."""
        previous = self._pixel
        if self.mode is PokeState.PANNING and math.dist(previous, pixel) <= self._slack:
            return None
        self._pixel = pixel
        self._slack = 0.0
        if self.mode is PokeState.PANNING:
            return Panned(pixel[0] - previous[0], pixel[1] - previous[1])
        if self.mode is PokeState.IDLE or at is None or at == self._at:
            return None
        self._at = at
        return Moved(at)

    def release(self, button: Hashable = None) -> PokeEvent | None:
        """``button`` came up; only the one that began the hold ends it."""
        if button != self._button:
            return None
        clicked = self.mode is PokeState.PANNING and self._slack > 0
        click = Clicked(self._pixel, self._at) if clicked else None
        return self.cancel() or click

    def cancel(self) -> PokeEvent | None:
        """Escape was pressed or the focus went: whatever was going on ends."""
        mode = self.mode
        self.mode = PokeState.IDLE
        self._at = None
        return Released() if mode is PokeState.POKING else None
