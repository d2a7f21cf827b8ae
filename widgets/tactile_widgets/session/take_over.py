"""Goes on live from an instant of a recording: its inputs are simulated again up to there, a little at a time."""

from __future__ import annotations

import time

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import Resimulation
from tactile_maps.session.frame import Frame

_SLICE = 0.03
"""Wall seconds of work between two looks at the mouse."""


class TakeOver(QObject):
    """Simulates a recording again up to one of its frames. Mutable; ``close`` gives it up.

    Args:
        player: Of the recording.
        frame: To begin at.
        parent: Qt parent.

    Raises:
        RecordingError: The readings were measured: there is nothing to simulate.

    Cost: about a tenth of the recorded time, in slices between which the window answers.
    """

    progressed = Signal(float)
    """How far it is, 0 to 1."""
    done = Signal(object, bool)
    """The Session at that frame, and whether its posture and pressures are the recorded ones bit for bit."""
    failed = Signal(str)
    """It cannot get there; the sentence says why."""

    def __init__(self, player: RecordingPlayer, frame: Frame, parent: QObject) -> None:
        super().__init__(parent)
        if player.measured is not None:
            raise RecordingError(
                "the readings were measured: no simulation can go on from them",
                file=player.path,
                value=player.measured,
                remedy="Open its robot, and connect the skin again",
            )
        self._again = Resimulation(player)
        self._frame = frame
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._on_timer)
        self._timer.start(0)

    def close(self) -> None:
        """Give it up."""
        self._timer.stop()
        self.deleteLater()

    def _on_timer(self) -> None:
        until = time.perf_counter() + _SLICE
        wanted = self._frame.tick
        try:
            while time.perf_counter() < until:
                now = self._again.session.frame.tick
                if now >= wanted:
                    self._finish()
                    return
                if self._again.frame(now + 1).tick == now:
                    raise RecordingError("the session stopped there by itself", value=f"tick {now}")
        except TactileMapsError as error:
            self.close()
            self.failed.emit(str(error))
            return
        self.progressed.emit(self._again.session.frame.tick / max(wanted, 1))

    def _finish(self) -> None:
        self.close()
        frame = self._again.session.frame
        recorded = self._frame
        same = all(
            getattr(frame, name).tobytes() == getattr(recorded, name).tobytes() for name in ("posture", "velocity")
        )
        self.done.emit(self._again.session, same)
