"""Films of the recording that is shown, of the session (recorded first), or of a recording file."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import move_into_place
from tactile_maps.recording.player import open_recording
from tactile_widgets.common.file_dialogs import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.dialogs.figures.film_dialog import FilmDialog
from tactile_widgets.dialogs.figures.film_job import FilmRequest, film
from tactile_widgets.jobs.executor import Job, ProcessExecutor
from tactile_widgets.plots.timeline.playhead import Span

_DIED = "The film ended unexpectedly. It may need more memory: choose a smaller size."


class FilmPresenter(Presenter):
    """Makes one film at a time in a separate process.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self.dialog: FilmDialog | None = None
        self._executor = ProcessExecutor("film", self)
        self._progress = JobProgress(self._notifier, self.close)
        self._target: Path | None = None
        self._folder: Path | None = None
        self._of_session = False
        context.actions.bind(film=self.film_shown, film_file=self.choose_file)
        context.session.recording.saved.connect(self._on_saved)

    def film_shown(self) -> None:
        """Film the recording that is shown; for a running session, start a recording, or stop and film it."""
        session = self._session
        actions = self._context.actions
        if session.replay.player is not None:
            self.ask(session.replay.player.path)
        elif session.recording.recorder is not None:
            self._of_session = True
            session.recording.stop()
        else:
            actions["record"].trigger()
            if session.recording.recorder is not None:
                self._of_session = True
                self._notifier.say("Recording for a film; stop the recording to choose size and rate.")

    def _on_saved(self, path: str) -> None:
        if self._of_session:
            self._of_session = False
            self.ask(Path(path))

    def choose_file(self) -> None:
        """Ask for a recording file."""
        path = self._context.dialogs.open_file("Film a recording", RECORDING_FILTER)
        if path:
            self.ask(Path(path))

    def ask(self, recording: Path) -> None:
        """Ask size, rate and range for a recording."""
        if self._target is not None:
            self._notifier.fault("A film is being made; wait until it is done, or cancel it.", of="film")
            return
        player = self._session.replay.player
        chosen = None
        with self._notifier.errors_shown("film", finishes=False):
            if player is None or player.path != recording:
                player = open_recording(recording)
            else:
                chosen = self._context.timeline.range
            self._ask(recording, player.duration, chosen)
            self._context.dialogs.remember_opened(recording)

    def _ask(self, recording: Path, duration: float, chosen: Span | None) -> None:
        span = None if chosen is None else (chosen.start, chosen.end)
        self.dialog = FilmDialog(duration, span, self._context.theme.theme.name, self._window)
        self.dialog.requested.connect(partial(self._on_requested, recording))
        self.dialog.finished.connect(self._on_closed)
        self.dialog.open()

    def _on_closed(self) -> None:
        self.dialog = None

    def _on_requested(
        self, recording: Path, size: tuple[int, int], rate: float, span: tuple[float, float], theme: str
    ) -> None:
        path = self._context.dialogs.save_file("Film", f"{recording.stem}.mp4", "Film (*.mp4)")
        if path:
            self.make(FilmRequest(recording, Path(path), size, rate, span, theme))

    def make(self, request: FilmRequest) -> None:
        """Start a film; progress and result are shown."""
        try:
            folder = Path(tempfile.mkdtemp(prefix=".tactile-maps-film-", dir=request.target.parent))
        except OSError as error:
            self._notifier.fault(f"{request.target}: the film cannot be written there: {error.strerror}", of="film")
            return
        # The film is moved from this folder once it is complete: a process that is ended cannot remove its files.
        self._target = request.target
        self._folder = folder
        part = replace(request, target=folder / "film.mp4")
        self._progress.show("Filming", 0.0)
        filmed = partial(self._on_filmed, part.target, request.target)
        self._executor.start(Job(film, part, died=_DIED), filmed, self._on_failed, progressed=self._progress.show)

    def _on_filmed(self, part: Path, target: Path, complete: bool) -> None:
        with self._notifier.errors_shown("film"):
            move_into_place(part, target, error=ExportError)
            lost = "" if complete else "; the recording is damaged: the last picture is repeated where data are missing"
            self._notifier.say(f"Filmed {target}{lost}")
        self.close()

    def _on_failed(self, text: str) -> None:
        self.close()
        self._notifier.fault(text, of="film")

    def close(self) -> None:
        """Cancel the film that is being made and remove its files."""
        self._executor.close()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._target = None
        self._folder = None
        self._progress.end()
