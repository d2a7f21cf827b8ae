"""Export of recordings for other programs, and live sharing of the session with viewers."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.player import RecordingPlayer, open_recording
from tactile_widgets.common.file_dialogs import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.session.sharing import ViewerKind

if TYPE_CHECKING:
    from tactile_maps.export.export import ExportFormat


class _CancelledError(Exception):
    """The user cancelled the export."""


class ExportPresenter(Presenter):
    """Exports one recording at a time on a thread, and shares the session with viewers.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    _progressed = Signal(str, float)
    _ended = Signal(str, bool)
    """Message, empty if the export was cancelled, and whether it is a fault."""

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._thread: threading.Thread | None = None
        self._announced: str | None = None  # address that the last message about viewers stated
        self._cancelled = threading.Event()
        self._progress = JobProgress(self._notifier, self._cancelled.set)
        context.actions.bind(
            export_recording=self.choose,
            share_live=partial(self.toggle_sharing, ViewerKind.FOXGLOVE),
            share_rerun=partial(self.toggle_sharing, ViewerKind.RERUN),
            record_for_viewers=self.toggle_recorded_for_viewers,
        )
        context.session.recording.set_for_viewers(on=context.settings.recorded_for_viewers)
        context.session.sharing.changed.connect(self._on_sharing_changed)
        self._progressed.connect(self._on_progressed)
        self._ended.connect(self._on_ended)

    def close(self) -> None:
        """Cancel the export and remove its files."""
        self._cancelled.set()
        if self._thread is not None:
            self._thread.join()

    def choose(self) -> None:
        """Ask for format and range, for the recording that is replayed or one that the user chooses."""
        if self._thread is not None:
            self._notifier.fault(
                "A recording is being exported; wait until it is done, or cancel it.", of="export recording"
            )
            return
        player = self._session.replay.player
        if player is not None:
            self._ask(player, self._context.timeline.range)
        elif path := self._context.dialogs.open_file("Export recording", RECORDING_FILTER):
            with self._notifier.errors_shown("export recording", finishes=False):
                self._ask(open_recording(path), None)
                self._context.dialogs.remember_opened(path)

    def _ask(self, player: RecordingPlayer, chosen: Span | None) -> None:
        from tactile_widgets.dialogs.export_dialog import ExportDialog  # imported late, for a faster start

        span = None if chosen is None else (chosen.start, chosen.end)
        dialog = ExportDialog(player.duration, span, self._window, begins=float(player.times[0]))
        dialog.requested.connect(partial(self._choose_target, str(player.path)))
        dialog.open()

    def _choose_target(self, source: str, name: str, span: tuple[float, float] | None, fps: int | None) -> None:
        from tactile_maps.export.export import FORMATS

        form = FORMATS[name]
        kinds = f"{form.title} (*{form.ending})" if form.ending else "New folder (*)"
        proposed = f"{Path(source).stem}{form.ending or f' {form.name}'}"
        target = self._context.dialogs.save_file("Export recording", proposed, kinds)
        if target:
            self.export(source, form, target, span=span, fps=fps)

    def export(
        self,
        source: str,
        form: ExportFormat,
        target: str,
        *,
        span: tuple[float, float] | None = None,
        fps: int | None = None,
    ) -> None:
        """Start an export of a recording, or of its part from start to end [s]; progress and result are shown.

        ``fps`` is the number of rows per second, None for a row for each reading.
        """
        path = Path(target)
        path = path if path.suffix or not form.ending else path.with_suffix(form.ending)
        self._cancelled.clear()
        self._progress.show("Exporting", 0.0)
        work = partial(self._work, source, form, path, span, fps)
        self._thread = threading.Thread(target=work, name="export", daemon=True)
        self._thread.start()

    def _work(
        self, source: str, form: ExportFormat, path: Path, span: tuple[float, float] | None, fps: int | None
    ) -> None:
        """Export on the thread."""
        from tactile_maps.export.export import ExportOptions, export_recording

        try:
            # The dialog has asked whether a file may be replaced.
            options = ExportOptions(fps=fps)
            player = export_recording(
                source, path, to=form.name, options=options, span=span, overwrite=True, progress=self._on_step
            )
        except _CancelledError:
            self._ended.emit("", False)
        except TactileMapsError as error:
            self._ended.emit(str(error), True)
        except Exception as error:  # the user must see any other error too
            self._ended.emit(f"The export failed: {type(error).__name__}: {error}", True)
        else:
            lost = "" if player.complete else "; the recording is damaged: the table damage lists the losses"
            self._ended.emit(f"Exported {path}{lost}", False)

    def _on_step(self, text: str, fraction: float) -> None:
        if self._cancelled.is_set():
            raise _CancelledError
        self._progressed.emit(text, fraction)

    def _on_progressed(self, text: str, fraction: float) -> None:
        if self._thread is not None:
            self._progress.show(text, fraction)

    def _on_ended(self, text: str, fault: bool) -> None:
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._progress.end()
        if text:
            self._notifier.say(text, fault=fault, of="export recording")

    def toggle_sharing(self, kind: ViewerKind) -> None:
        """Start or stop sharing the session with viewers on this computer."""
        session = self._session
        if session.sharing.kind is kind:
            session.sharing.stop()
        else:
            session.sharing.start(kind)

    def toggle_recorded_for_viewers(self) -> None:
        """Toggle whether recordings hold what viewers show; stored in the settings."""
        on = not self._session.recording.for_viewers
        self._context.settings.recorded_for_viewers = on
        self._session.recording.set_for_viewers(on=on)

    def _on_sharing_changed(self, address: str | None) -> None:
        if address is not None and address != self._announced:  # each scene is shared anew, mostly at the same address
            self._announced = address
            foxglove = f"Viewers on this computer find the session at {address} (Foxglove, Lichtblick: open connection)"
            shown = self._session.sharing.kind is ViewerKind.RERUN
            text = f"Shown in the Rerun viewer at {address}" if shown else foxglove
            self._notifier.say(text, of="share")
