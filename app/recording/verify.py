"""Re-simulates a recording from its inputs and compares every state, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.control.command import ControlChanged
from app.recording.player import Player
from app.recording.recorder import versions
from app.session.frame import Frame
from app.session.session import Session


@dataclass(frozen=True)
class Verification:
    """The outcome.

    Attributes:
        frames: Frames compared.
        identical: Whether posture, velocity and pressures of all of them are equal, bit for bit.
        max_difference: Largest difference of any posture, velocity (SI) or pressure (kPa).
        first_difference: Tick of the first frame that differs; None when identical.
        other_versions: Versions that differ from those it was recorded with; equality is only promised without any.
    """

    frames: int
    identical: bool
    max_difference: float
    first_difference: int | None
    other_versions: tuple[str, ...]


def _silent(_text: str, _fraction: float) -> None:
    """No progress wanted."""


def verify(player: Player, *, progress: Callable[[str, float], None] = _silent) -> Verification:
    """Run the recorded inputs again, from the session's start, and compare with the recorded frames.

    Args:
        player: The recording.
        progress: Told how far it is, 0 to 1; may raise to cancel.

    Cost: as long as simulating it, about a tenth of real time.
    """
    session, waiting = _session_of(player)
    largest, first, compared = 0.0, None, 0
    for number in range(len(player)):
        recorded = player.frame(number)
        while session.frame.tick < recorded.tick:
            while waiting and waiting[0][0] == session.frame.tick + 1:
                session.submit(waiting.pop(0)[1])
            session.tick()
        difference = _difference(session.frame, recorded)
        largest, compared = max(largest, difference), compared + 1
        if first is None and difference != 0.0:
            first = recorded.tick
        if number % 200 == 0:
            progress("Simulating again", number / len(player))
    now = versions()
    changed = tuple(
        f"{key} {value} (now {now[key]})" for key, value in player.versions.items() if key in now and now[key] != value
    )
    return Verification(compared, first is None, largest, first, changed)


def _session_of(player: Player) -> tuple[Session, list]:  # type: ignore[type-arg]
    """A fresh session with the settings and the map recorded for its start, and the inputs that follow."""
    starting = [act for tick, act in player.inputs if tick == 0 and isinstance(act, ControlChanged)]
    settings = starting[-1].settings if starting else None
    session = Session(player.prepared, scripted=False, settings=settings, map_=player.map_at(0))
    return session, [item for item in player.inputs if item[0] > 0]


def _difference(one: Frame, other: Frame) -> float:
    """Largest difference; inf where the shapes disagree or only one of two numbers is NaN."""
    pairs = (
        (one.posture, other.posture),
        (one.velocity, other.velocity),
        (1e-3 * one.pressures, 1e-3 * other.pressures),
    )
    if one.tick != other.tick or any(a.shape != b.shape for a, b in pairs):
        return float("inf")
    worst = max((float(np.abs(a - b).max()) for a, b in pairs if a.size), default=0.0)
    return worst if np.isfinite(worst) else float("inf")
