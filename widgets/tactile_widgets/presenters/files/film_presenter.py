"""Films from the menu: of the recording that is shown, of the session by way of one, or of a file."""

from __future__ import annotations

import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import cast

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import ExportError, TactileMapsError
from tactile_maps.core.files import move_into_place
from tactile_maps.recording.player import open_recording
from tactile_widgets.common.file_types import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.figures.film_dialog import FilmDialog
from tactile_widgets.dialogs.figures.film_worker import FilmRequest, make_film_handler
from tactile_widgets.workers.worker_process import Result, SourceToken, WorkerProcess

FILM_JOB = "film"
"""Key of the progress of a film."""
_DIED = "The film ended unexpectedly. It may need more memory: choose a smaller size."


class FilmPresenter(QObject):
    """Makes one film at a time in a process beside the window.

    Args:
        context: What it works on.
        parent: Qt parent, over which the dialog opens.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(parent)
        self._context = context
        self._window = parent
        self.dialog: FilmDialog | None = None
        self._process = WorkerProcess("film", make_film_handler, self)
        self._process.answered.connect(self._on_answered)
        self._process.ended.connect(self._on_ended)
        self._token = SourceToken("film")
        self._target: Path | None = None
        self._folder: Path | None = None
        self._of_session = False
        context.actions.bind("film", self.film_shown)
        context.actions.bind("film_file", self.choose_file)
        context.session.saved.connect(self._on_saved)
        context.notifier.cancelled.connect(self._on_cancelled)

    def close(self) -> None:
        """Give up the film that is being made; nothing of it stays."""
        self._end()

    # What is filmed.

    def film_shown(self) -> None:
        """The recording that is shown; live, a recording is begun, or ended and filmed."""
        session = self._context.session
        actions = self._context.actions
        if session.player is not None:
            self.ask(session.player.path)
        elif session.recorder is not None:
            self._of_session = True
            session.stop_recording()
        else:
            actions["record"].trigger()
            if session.recorder is not None:
                self._of_session = True
                self._context.notifier.say("Recording for a film; stop the recording to choose size and rate.")

    def _on_saved(self, path: str) -> None:
        if self._of_session:
            self._of_session = False
            self.ask(Path(path))

    def choose_file(self) -> None:
        """Ask which recording."""
        path = self._context.dialogs.open_file("Film a recording", RECORDING_FILTER)
        if path:
            self.ask(Path(path))

    # How, and where to.

    def ask(self, recording: Path) -> None:
        """Ask size, rate and range for a recording."""
        if self._target is not None:
            self._context.notifier.fault("A film is being made; wait until it is done, or cancel it.")
            return
        player = self._context.session.player
        chosen = None
        try:
            if player is None or player.path != recording:
                player = open_recording(recording)
            else:
                chosen = self._context.timeline.range
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return
        span = None if chosen is None else (chosen.start, chosen.end)
        self.dialog = FilmDialog(player.duration, span, self._context.theme.theme.name, self._window)
        self.dialog.wanted.connect(partial(self._on_wanted, recording))
        self.dialog.finished.connect(self._on_closed)
        self.dialog.open()

    def _on_closed(self) -> None:
        self.dialog = None

    def _on_wanted(
        self, recording: Path, size: tuple[int, int], rate: float, span: tuple[float, float], theme: str
    ) -> None:
        path = self._context.dialogs.save_file("Film", f"{recording.stem}.mp4", "Film (*.mp4)")
        if path:
            self.make(FilmRequest(recording, Path(path), size, rate, span, theme))

    # The work.

    def make(self, request: FilmRequest) -> None:
        """Begin a film; progress and what became of it are shown."""
        try:
            folder = Path(tempfile.mkdtemp(prefix=".tactile-maps-film-", dir=request.target.parent))
        except OSError as error:
            self._context.notifier.fault(f"{request.target}: the film cannot be written there: {error.strerror}")
            return
        # There until it is whole: a process that is ended cannot tidy up.
        self._target = request.target
        self._folder = folder
        part = FilmRequest(
            request.recording, folder / "film.mp4", request.size, request.rate, request.span, request.theme
        )
        self._context.notifier.progress(FILM_JOB, "Filming", 0.0)
        self._process.send(part, self._token)

    def _on_answered(self, _number: int, kind: str, result: Result[object]) -> None:
        if result.token != self._token or self._target is None or self._folder is None:
            return
        notifier = self._context.notifier
        target = self._target
        if kind == "progress":
            notifier.progress(FILM_JOB, *cast("tuple[str, float]", result.value))
        elif kind == "failed":
            self._end()
            notifier.fault(str(result.value))
        elif kind == "filmed":
            try:
                move_into_place(self._folder / "film.mp4", target, error=ExportError)
            except ExportError as error:
                notifier.fault(str(error))
            else:
                lost = (
                    "" if result.value else "; the recording is damaged, and the last picture stays where some is lost"
                )
                notifier.say(f"Filmed {target}{lost}")
            self._end()

    def _on_ended(self, _token: SourceToken) -> None:
        if self._target is not None:
            self._end()
            self._context.notifier.fault(_DIED)

    def _on_cancelled(self, job: str) -> None:
        if job == FILM_JOB:
            self._end()

    def _end(self) -> None:
        self._token = self._token.next()
        self._process.close()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._target = self._folder = None
        self._context.notifier.done(FILM_JOB)
