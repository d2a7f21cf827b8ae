"""Films from the menu: of the recording that is shown, of the session by way of one, or of a file."""

from __future__ import annotations

import shutil
import tempfile
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import ExportError, TactileMapsError
from tactile_maps.core.files import move_into_place
from tactile_maps.recording.player import open_recording
from tactile_widgets.common.file_types import RECORDING_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.figures.film_dialog import FilmDialog
from tactile_widgets.dialogs.figures.film_job import FilmRequest, film
from tactile_widgets.jobs.executor import Job, ProcessExecutor

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
        self._executor = ProcessExecutor("film", self)
        self._target: Path | None = None
        self._folder: Path | None = None
        self._of_session = False
        context.actions.bind("film", self.film_shown)
        context.actions.bind("film_file", self.choose_file)
        context.session.recording.saved.connect(self._on_saved)
        context.notifier.cancelled.connect(self._on_cancelled)

    def close(self) -> None:
        """Give up the film that is being made; nothing of it stays."""
        self._end()

    # What is filmed.

    def film_shown(self) -> None:
        """The recording that is shown; live, a recording is begun, or ended and filmed."""
        session = self._context.session
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
        player = self._context.session.replay.player
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
        self.dialog.requested.connect(partial(self._on_wanted, recording))
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
        progress = partial(self._context.notifier.progress, FILM_JOB)
        progress("Filming", 0.0)
        filmed = partial(self._on_filmed, part.target, request.target)
        self._executor.start(Job(film, part, died=_DIED), filmed, self._on_failed, progressed=progress)

    def _on_filmed(self, part: Path, target: Path, complete: bool) -> None:
        notifier = self._context.notifier
        try:
            move_into_place(part, target, error=ExportError)
        except ExportError as error:
            notifier.fault(str(error))
        else:
            lost = "" if complete else "; the recording is damaged, and the last picture stays where some is lost"
            notifier.say(f"Filmed {target}{lost}")
        self._end()

    def _on_failed(self, text: str) -> None:
        self._end()
        self._context.notifier.fault(text)

    def _on_cancelled(self, job: str) -> None:
        if job == FILM_JOB:
            self._end()

    def _end(self) -> None:
        self._executor.close()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._target = self._folder = None
        self._context.notifier.done(FILM_JOB)
