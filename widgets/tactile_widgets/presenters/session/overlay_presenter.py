"""A second recording over the one that is shown: its curves dashed, its contacts as outlines on the map."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.overview.curves import CURVES, Curves, joined
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.file_types import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import READING_DIED, open_player, send_curves
from tactile_widgets.plots.timeline.lane_painter import Overlaid

OVERLAY_JOB = "overlay"
"""Key of the progress of opening the second recording."""
STEP = 0.05
"""By which the offset is moved [s]."""
_TOUCH = 0.05
"""Force at which a touch begins [N]."""


class OverlayPresenter(QObject):
    """Opens it beside, keeps it in step with an offset in time, and lets go of it with the first recording.

    Args:
        context: What it works on.
        parent: Qt parent.

    Attributes:
        offset: So much later than the first recording the second begins [s].
    """

    changed = Signal()
    """There is a second recording now, or not any more."""

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self._session = context.session
        self._executor = context.backends.executor("recordings", self)
        self._other: RecordingPlayer | None = None
        self._pieces: list[Curves] = []
        self.offset = 0.0
        for name, handler in (
            ("overlay_recording", self.choose),
            ("overlay_offset", self.ask_offset),
            ("overlay_align", self.align),
            ("overlay_earlier", lambda: self.move(-STEP)),
            ("overlay_later", lambda: self.move(STEP)),
            ("overlay_remove", self.remove),
        ):
            context.actions.bind(name, handler)
        self._session.replay.player_changed.connect(self.remove)
        self._session.frame_ready.connect(self._on_frame_ready)
        context.notifier.cancelled.connect(self._on_cancelled)

    def close(self) -> None:
        """Open nothing any more."""
        self._executor.close()

    @property
    def other(self) -> RecordingPlayer | None:
        """The second recording; None for none."""
        return self._other

    def choose(self) -> None:
        """Ask which recording to draw over the one that is shown."""
        if path := self._context.dialogs.open_file("Overlay recording", RECORDING_FILTER):
            self.open(Path(path))

    def open(self, path: Path) -> None:
        """Draw this recording over the one that is shown, from its start."""
        if self._session.replay.player is None:
            return
        self.remove()
        progress = partial(self._context.notifier.progress, OVERLAY_JOB)
        progress(f"Opening {path.name}", 0.0)
        opening = Job(open_player, path, died=READING_DIED)
        self._executor.start(opening, self._on_opened, self._on_failed, progressed=progress)
        reading = Job(send_curves, path, (), died=READING_DIED)
        self._executor.start(reading, self._on_read, self._on_failed, received=self._on_piece)

    def remove(self, _player: object = None) -> None:
        """Show the first recording alone."""
        self.close()
        self._context.notifier.done(OVERLAY_JOB)
        self._pieces = []
        self.offset = 0.0
        if self._other is not None:
            self._other = None
            self._context.recording_plots.show_overlaid(None)
            self._context.views.show_overlaid(())
            self.changed.emit()

    # Time.

    def ask_offset(self) -> None:
        """Ask how much later the second begins."""

        def told(text: str) -> None:
            try:
                seconds = float(text.replace(",", "."))
            except ValueError:
                seconds = float("nan")
            if np.isfinite(seconds):
                self.set_offset(seconds)
            else:
                self._context.notifier.fault(f"{text} is no number of seconds")

        text = "The second recording begins so much later (seconds; below zero: earlier)"
        self._context.dialogs.ask_text("overlay-offset", "Offset of the overlay", text, told, value=f"{self.offset:g}")

    def move(self, seconds: float) -> None:
        """Let the second begin so much later."""
        self.set_offset(self.offset + seconds)

    def align(self) -> None:
        """Let the first touches of both be at the same time."""
        player = self._session.replay.player
        other = self._other
        plots = self._context.recording_plots
        if player is None or other is None:
            return
        own = first_touch(plots.times, plots.values)
        second = first_touch(*self._curves_of(other))
        if own is None or second is None:
            self._context.notifier.status("One of the recordings has no touch, or is still being read")
        else:
            self.set_offset(own - second)

    def set_offset(self, seconds: float) -> None:
        """The second recording begins so much later than the first [s]."""
        self.offset = round(seconds, 3)
        self._show_curves()
        if self._session.shown is not None:
            self._on_frame_ready(self._session.shown)
        self._context.notifier.status(f"The overlay begins at {self.offset:+.2f}\u202fs")

    # What comes.

    def _on_piece(self, read: tuple[float, Curves]) -> None:
        if self._other is not None:
            share, piece = read
            self._pieces = [joined([*self._pieces, piece])]
            self._show_curves()
            self._context.notifier.progress(OVERLAY_JOB, "Reading the whole recording", share)

    def _on_failed(self, text: str) -> None:
        self.remove()
        self._context.notifier.fault(text)

    def _on_read(self, _none: None) -> None:
        if self._pieces:
            self._context.notifier.done(OVERLAY_JOB)

    def _on_opened(self, other: RecordingPlayer) -> None:
        player = self._session.replay.player
        if player is None:
            return
        if not same_skin(player.prepared.skin, other.prepared.skin):
            self.remove()
            self._context.notifier.fault(
                f"{other.path.name} is of another skin than {player.path.name}: its contacts have no place here. "
                "Repeat its touches live on this skin, and record that."
            )
            return
        self._other = other
        self.changed.emit()
        if self._session.shown is not None:
            self._on_frame_ready(self._session.shown)

    def _curves_of(self, other: RecordingPlayer) -> tuple[FloatArray, FloatArray]:
        """Times [s from its first frame] and values of the second."""
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
            with suppress(RecordingError):  # damaged there: nothing to outline
                regions = other.frame(other.number_at(time)).regions
        self._context.views.show_overlaid(regions)

    def _on_cancelled(self, job: str) -> None:
        if job == OVERLAY_JOB:
            self.remove()


def first_touch(times: FloatArray, values: FloatArray) -> float | None:
    """When the force rises first [s]; None where it never does."""
    touched = np.flatnonzero(values[:, CURVES.index("force")] > _TOUCH)
    return float(times[touched[0]]) if len(touched) else None


def same_skin(one: Skin, other: Skin) -> bool:
    """Whether two skins have the same patches with the same faces and taxels, so that places mean the same."""
    if len(one.patches) != len(other.patches):
        return False
    return all(
        np.array_equal(a.surface.faces, b.surface.faces)
        and np.array_equal(a.surface.vertices, b.surface.vertices)
        and np.array_equal(a.taxels.positions, b.taxels.positions)
        for a, b in zip(one.patches, other.patches, strict=True)
    )
