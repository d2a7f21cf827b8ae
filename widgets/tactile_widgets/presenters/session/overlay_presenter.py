"""Second recording drawn over the one that is shown: dashed curves, and outlines of its contacts on the map."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import RecordingError
from tactile_maps.editing.layout_import import same_skin
from tactile_maps.recording.overview.curves import CURVES, Curves, joined
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_widgets.common.file_dialogs import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import READING_DIED, open_player, send_curves
from tactile_widgets.plots.timeline.lane_painter import Overlaid

STEP = 0.05
"""Step of the offset [s]."""
_TOUCH = 0.05
"""Force at which a touch begins [N]."""


class OverlayPresenter(Presenter):
    """Opens the second recording in the background and keeps it synchronized with the first, with a time offset.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.

    Attributes:
        offset: How much later the second recording begins than the first [s].
    """

    changed = Signal()
    """The second recording was opened or removed."""

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._executor = context.backends.executor("recordings", self)
        self._other: RecordingPlayer | None = None
        self._pieces: list[Curves] = []
        self.offset = 0.0
        context.actions.bind(
            overlay_recording=self.choose,
            overlay_offset=self.ask_offset,
            overlay_align=self.align,
            overlay_earlier=partial(self.move, -STEP),
            overlay_later=partial(self.move, STEP),
            overlay_remove=self.remove,
        )
        self._session.replay.player_changed.connect(self.remove)
        self._session.frame_ready.connect(self._on_frame_ready)
        self._progress = JobProgress(self._notifier, self.remove)

    def close(self) -> None:
        """Cancel the reading of the second recording."""
        self._executor.close()

    @property
    def other(self) -> RecordingPlayer | None:
        """Second recording; None if there is none."""
        return self._other

    def choose(self) -> None:
        """Ask for a recording to draw over the one that is shown."""
        if path := self._context.dialogs.open_file("Overlay recording", RECORDING_FILTER):
            self.open(Path(path))

    def open(self, path: Path) -> None:
        """Draw this recording over the one that is shown, from its start."""
        if self._session.replay.player is None:
            return
        self.remove()
        self._progress.show(f"Opening {path.name}", 0.0)
        opening = Job(open_player, path, died=READING_DIED)
        self._executor.start(opening, self._on_opened, self._on_failed, progressed=self._progress.show)
        reading = Job(send_curves, path, (), died=READING_DIED)
        self._executor.start(reading, self._on_read, self._on_failed, received=self._on_piece)

    def remove(self, _player: object = None) -> None:
        """Show the first recording alone."""
        self.close()
        self._progress.end()
        self._pieces = []
        self.offset = 0.0
        if self._other is not None:
            self._other = None
            self._context.recording_plots.show_overlaid(None)
            self._context.views.show_overlaid(())
            self.changed.emit()

    # Time.

    def ask_offset(self) -> None:
        """Ask for the offset of the second recording."""

        def entered(text: str) -> None:
            try:
                seconds = float(text.replace(",", "."))
            except ValueError:
                seconds = float("nan")
            if np.isfinite(seconds):
                self.set_offset(seconds)
                self._notifier.succeed("overlay offset")
            else:
                self._notifier.fault(f"{text} is not a number of seconds", of="overlay offset")

        text = "Offset of the second recording (seconds; negative: earlier)"
        self._context.dialogs.ask_text(
            "overlay-offset", "Offset of the overlay", text, entered, value=f"{self.offset:g}"
        )

    def move(self, seconds: float) -> None:
        """Move the second recording by an additional offset."""
        self.set_offset(self.offset + seconds)

    def align(self) -> None:
        """Choose the offset so that the first touches of both recordings coincide."""
        player = self._session.replay.player
        other = self._other
        plots = self._context.recording_plots
        if player is None or other is None:
            return
        own = first_touch(plots.times, plots.values)
        second = first_touch(*self._curves_of(other))
        if own is None or second is None:
            self._notifier.status("One of the recordings has no touch, or is still being read")
        else:
            self.set_offset(own - second)

    def set_offset(self, seconds: float) -> None:
        """Set how much later the second recording begins than the first [s]."""
        self.offset = round(seconds, 3)
        self._show_curves()
        if self._session.shown is not None:
            self._on_frame_ready(self._session.shown)
        self._notifier.status(f"The overlay begins at {self.offset:+.2f}\u202fs")

    # Results of the jobs.

    def _on_piece(self, read: tuple[float, Curves]) -> None:
        if self._other is not None:
            share, piece = read
            self._pieces = [joined([*self._pieces, piece])]
            self._show_curves()
            self._progress.show("Reading the whole recording", share)

    def _on_failed(self, text: str) -> None:
        self.remove()
        self._notifier.fault(text, of="overlay recording")

    def _on_read(self, _none: None) -> None:
        if self._pieces:
            self._progress.end()

    def _on_opened(self, other: RecordingPlayer) -> None:
        player = self._session.replay.player
        if player is None:
            return
        if not same_skin(player.prepared.skin, other.prepared.skin):
            self.remove()
            self._notifier.fault(
                f"{other.path.name} has another skin than {player.path.name} and cannot be drawn over it. "
                "Repeat its touches live on this skin, and record them.",
                of="overlay recording",
            )
            return
        self._other = other
        self._context.dialogs.remember_opened(other.path)
        self._notifier.succeed("overlay recording")
        self.changed.emit()
        if self._session.shown is not None:
            self._on_frame_ready(self._session.shown)

    def _curves_of(self, other: RecordingPlayer) -> tuple[FloatArray, FloatArray]:
        """Return times [s from its first tick] and values of the second recording."""
        curves = joined(self._pieces)
        return curves.ticks * other.prepared.scene.tick - other.times[0], curves.values

    def _show_curves(self) -> None:
        if (other := self._other) is not None:
            tick = other.prepared.scene.tick
            first = round(float(other.times[0]) / tick)
            curves = joined(self._pieces)
            overlaid = Overlaid(curves, first, tick, self.offset, f"{other.path.stem} {self.offset:+.2f}\u202fs")
            self._context.recording_plots.show_overlaid(overlaid)

    def _on_frame_ready(self, frame: Frame) -> None:
        player = self._session.replay.player
        other = self._other
        if player is None or other is None:
            return
        time = frame.time - float(player.times[0]) - self.offset
        regions: tuple[ContactRegion, ...] = ()
        if 0 <= time <= other.duration + other.prepared.scene.tick:
            with suppress(RecordingError):  # damaged there: no outlines
                regions = other.frame(other.number_at(time)).regions
        self._context.views.show_overlaid(regions)


def first_touch(times: FloatArray, values: FloatArray) -> float | None:
    """Return the time of the first force [s]; None without one."""
    touched = np.flatnonzero(values[:, CURVES.index("force")] > _TOUCH)
    return float(times[touched[0]]) if len(touched) else None
