"""On what laws are compared, as a value."""

from __future__ import annotations

from dataclasses import dataclass

from app.session.inputs import PokePressed, SessionInput
from app.session.prepare import Prepared


@dataclass(frozen=True, eq=False)
class Occasion:
    """A scene and what was done in it.

    Attributes:
        prepared: The scene.
        inputs: (tick, input) from its start; None for its own script.
        seconds: How long it lasted, or is to last.
    """

    prepared: Prepared
    inputs: tuple[tuple[int, SessionInput], ...] | None
    seconds: float

    @property
    def touches(self) -> int:
        """How often the skin was, or is to be, touched."""
        if self.inputs is None:
            return len(self.prepared.scene.stimuli)
        return sum(isinstance(act, PokePressed) for _, act in self.inputs)

    @property
    def words(self) -> str:
        """Like "12.4 s, 3 touches"."""
        touches = f"{self.touches} touch{'es' * (self.touches != 1)}" if self.touches else "no touch"
        return f"{touches}, again and again" if self.inputs is None else f"{self.seconds:.1f}\u2009s, {touches}"
