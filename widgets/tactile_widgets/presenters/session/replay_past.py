"""The plots of a recording after a jump: what was before is read in slices, so that a scrub never waits for it."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer

from tactile_maps.session.frame import Frame
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.plots.traces.trace_plots import PLOT_SECONDS

_REST_MS = 60
"""After the last jump, before anything is read: a scrub is many."""
_SLICE = 60
"""Frames read without a rest: 12 ms."""


class ReplayPast(QObject):
    """Fills the plots with what was before the frame that is shown.

    Args:
        context: What it works on.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._session = context.session
        self._plots = context.plots
        self._frames: list[Frame] = []
        self._next = 0
        self._rest, self._slices = QTimer(self), QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(_REST_MS)
        self._rest.timeout.connect(self._on_rested)
        self._slices.timeout.connect(self._on_slice)
        context.session.replay.jumped.connect(self._on_jumped)
        context.session.replay.player_changed.connect(self.close)

    def close(self, _player: object = None) -> None:
        """Read no more."""
        self._rest.stop()
        self._slices.stop()

    def _on_jumped(self) -> None:
        self._slices.stop()
        self._rest.start()

    def _on_rested(self) -> None:
        replay = self._session.replay.current
        if replay is not None:
            self._frames = []
            self._next = replay.before(PLOT_SECONDS).start
            self._slices.start(0)

    def _on_slice(self) -> None:
        replay = self._session.replay.current
        if replay is None or replay.frame is None:
            self.close()
            return
        end = min(self._next + _SLICE, replay.number)
        self._frames += replay.frames(range(self._next, end))
        self._next = end
        if end >= replay.number:
            self._slices.stop()
            self._plots.show_past((*self._frames, replay.frame))
            self._frames = []
