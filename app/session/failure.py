"""Why a session stopped by itself, with all that is needed to see it stop again."""

from __future__ import annotations

from dataclasses import dataclass

from app.errors import SimulationError
from app.session.frame import Frame
from app.session.inputs import SessionInput


@dataclass(frozen=True, eq=False)
class Failure:
    """A tick that could not be finished: the physics left the numbers that mean something.

    Attributes:
        tick: The one that was not finished.
        error: What was wrong, where and when.
        inputs: (tick, input) since the reset, those of ``tick`` included; with the scene they repeat the failure.
        frame: The last good one, of the tick before.
    """

    tick: int
    error: SimulationError
    inputs: tuple[tuple[int, SessionInput], ...]
    frame: Frame

    @property
    def problem(self) -> str:
        """The message, for people and for comparing."""
        return str(self.error)
