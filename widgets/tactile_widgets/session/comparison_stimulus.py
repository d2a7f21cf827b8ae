"""The stimulus on which controllers are compared, and the function that reads it from a recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tactile_maps.core.errors import counted
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.jobs.executor import Report


@dataclass(frozen=True, eq=False)
class ComparisonStimulus:
    """A scene and the inputs that it received.

    Attributes:
        prepared: The scene.
        inputs: (tick, input) from its start; None for the scene's own script.
        seconds: Duration.
        file: Name of the recording it is from; empty if there is none.
    """

    prepared: PreparedScene
    inputs: tuple[tuple[int, SessionInput], ...] | None
    seconds: float
    file: str = ""

    @property
    def touches(self) -> int:
        """Number of touches of the skin."""
        if self.inputs is None:
            return len(self.prepared.scene.stimuli)
        return sum(isinstance(act, PokePressed) for _, act in self.inputs)

    @property
    def words(self) -> str:
        """Description like "12.4 s, 3 touches"."""
        touches = counted(self.touches, "touch") if self.touches else "no touch"
        return f"{touches}, repeated" if self.inputs is None else f"{self.seconds:.1f}\u202fs, {touches}"


def read_stimulus(path: Path, report: Report) -> ComparisonStimulus:
    """Return the stimulus of a recording. Cost: 20 ms a recorded second."""
    player = RecordingPlayer(path, progress=report)
    return ComparisonStimulus(player.prepared, tuple(player.inputs), float(player.times[-1]), path.name)
