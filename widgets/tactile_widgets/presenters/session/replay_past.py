"""Plots of a recording after a jump: the preceding data are read in slices, so that scrubbing does not wait."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QWidget

from tactile_maps.session.frame import Frame
from tactile_widgets.common.make import make
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.plots.traces.trace_plots import PLOT_SECONDS

_REST_MS = 60
"""Delay of reading after the last jump: scrubbing makes many jumps [ms]."""
_SLICE = 60
"""Number of ticks read in one slice: 12 ms."""


class ReplayPast(Presenter):
    """Fills the plots with the data before the current time.

    Args:
        context: Session, views, panels and services of the window.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._plots = context.plots
        self._frames: list[Frame] = []
        self._next = 0
        self._rest = make(QTimer, self, singleShot=True, interval=_REST_MS, timeout=self._on_rested)
        self._slices = make(QTimer, self, timeout=self._on_slice)
        context.session.replay.jumped.connect(self._on_jumped)
        context.session.replay.player_changed.connect(self.close)

    def close(self, _player: object = None) -> None:
        """Stop reading."""
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
