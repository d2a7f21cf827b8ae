"""Curves of a whole recording, read in the background and synchronized with the timeline."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QWidget

from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.recording.overview.curves import Curves, joined
from tactile_maps.recording.overview.raster import MOST_SPANS, RasterPiece
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import READING_DIED, send_curves, send_raster
from tactile_widgets.plots.choice.plot_choice import RASTER, STANDARD
from tactile_widgets.plots.timeline.lanes import AddedLane, added_lanes
from tactile_widgets.plots.traces.raster import TaxelRows

_READING = "Reading the whole recording"


class RecordingPlotsPresenter(Presenter):
    """Shows these curves instead of the last seconds while a recording is shown, unless the user prefers those.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._plots = context.recording_plots
        self._timeline = context.timeline
        self._executor = context.backends.executor("recordings", self)
        self._pieces: list[Curves] = []
        self._pressures: NDArray[np.float32] = np.zeros((0, 0), np.float32)
        self._plots.offer(context.actions["choose_plots"])
        context.actions.bind(whole_recording=self.toggle)
        context.actions["whole_recording"].setChecked(context.settings.whole_recording)
        self._session.replay.player_changed.connect(self._on_player_changed)
        self._session.frame_ready.connect(self._on_frame_ready)
        context.plots.choice_changed.connect(self._on_choice_changed)
        self._timeline.range_changed.connect(self._plots.show_range)
        self._timeline.notes_shown.connect(self._plots.show_notes)
        self._plots.view_changed.connect(self._timeline.show_view)
        self._plots.time_chosen.connect(self._timeline.go_to)
        self._plots.range_dragged.connect(self._timeline.set_range)
        self._plots.menu_requested.connect(self._timeline.menu_requested)
        self._progress = JobProgress(self._notifier, self._on_cancelled)
        self._show()

    def close(self) -> None:
        """Cancel reading."""
        self._progress.end()
        self._executor.close()

    def toggle(self) -> None:
        """Show the whole recording, or its last seconds."""
        self._context.settings.whole_recording = self._context.actions["whole_recording"].isChecked()
        self._show()

    def _show(self) -> None:
        whole = self._session.replay.player is not None and self._context.settings.whole_recording
        shown, hidden = (self._plots, self._context.plots) if whole else (self._context.plots, self._plots)
        hidden.hide()  # first, so that the dock does not grow for both
        shown.show()
        self._timeline.show_view(self._plots.view if whole else None)

    def _on_player_changed(self, player: RecordingPlayer | None) -> None:
        self._show()
        if player is None:
            self.close()
            return
        units = player.frame(0).units
        self._plots.show_recording(player.duration, player.prepared.scene.tick, units)
        self._read(player, self._added(player, units))

    def _on_choice_changed(self) -> None:
        """Read again after plots were added to or removed from the current plots."""
        player = self._session.replay.player
        frame = self._session.shown
        if player is not None and frame is not None:
            added = self._added(player, frame.units)
            same = [lane.key for lane in added] == [lane.key for lane in self._plots.added]
            if not same or self._raster_chosen is not self._plots.raster_shown:
                self._read(player, added)

    @property
    def _raster_chosen(self) -> bool:
        return RASTER in self._context.plots.choice.order

    def _added(self, player: RecordingPlayer, units: ReadingUnits) -> tuple[AddedLane, ...]:
        """Return the plots that the user added, for this recording."""
        keys = self._context.plots.choice.order
        return added_lanes((key for key in keys if key not in STANDARD), player.prepared, units)

    def _read(self, player: RecordingPlayer, added: tuple[AddedLane, ...]) -> None:
        self.close()
        self._pieces = []
        self._plots.show_added(added)
        self._plots.show_raster(TaxelRows(player.prepared.skin) if self._raster_chosen else None)
        self._progress.show(_READING, 0.0)
        job = Job(send_curves, player.path, tuple(lane.quantity for lane in added), died=READING_DIED)
        read = partial(self._on_read, player)
        self._executor.start(job, read, self._on_failed, received=partial(self._on_piece, player))

    def _on_piece(self, player: RecordingPlayer, read: tuple[float, Curves]) -> None:
        share, piece = read
        self._pieces.append(piece)
        self._show_curves(player)
        self._progress.show(_READING, share)

    def _on_read(self, player: RecordingPlayer, _none: None) -> None:
        """Read the raster after the curves, which are there sooner."""
        if not self._plots.raster_shown:
            self._progress.end()
            return
        ticks = player.tick_at(0.0), player.tick_at(player.duration)
        spans = min(len(player), MOST_SPANS)
        self._pressures = np.full((spans, len(player.prepared.skin)), np.nan, np.float32)
        job = Job(send_raster, player.path, ticks, spans, died=READING_DIED)
        self._executor.start(job, self._on_raster_read, self._on_failed, received=self._on_raster_piece)

    def _on_raster_piece(self, read: tuple[float, RasterPiece]) -> None:
        share, piece = read
        if piece.pressures.shape[1] == self._pressures.shape[1]:
            self._pressures[piece.spans] = np.fmax(self._pressures[piece.spans], piece.pressures)
        self._plots.show_pressures(self._pressures)
        self._progress.show("Reading all taxels", share)

    def _on_raster_read(self, _none: None) -> None:
        self._progress.end()

    def _on_failed(self, text: str) -> None:
        self._plots.show_message(text)
        self._progress.end()

    def _show_curves(self, player: RecordingPlayer) -> None:
        self._pieces = [joined(self._pieces)]
        (curves,) = self._pieces
        first = player.times[0]
        times = curves.ticks * player.prepared.scene.tick - first
        inside = times > -1e-9
        self._plots.show_curves(np.asarray(times[inside], dtype=np.float64), curves.values[inside])

    def _on_frame_ready(self, frame: Frame) -> None:
        if (player := self._session.replay.player) is not None:
            self._plots.set_units(frame.units)
            self._plots.show_time(frame.time - float(player.times[0]))

    def _on_cancelled(self) -> None:
        self.close()
        if not self._pieces:
            self._plots.show_message("Reading the whole recording was cancelled. Open it again to read it.")
