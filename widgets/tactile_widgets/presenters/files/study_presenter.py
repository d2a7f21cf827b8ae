"""Tables of studies: opened by a dialog or a drop, those that ship by the Help menu, each in a window of its own."""

from __future__ import annotations

import secrets
import shutil
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.catalogue import STUDY_NAMES
from tactile_maps.studies.running.study_table import read_study_table
from tactile_widgets.common.file_types import STUDY_FILTER
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.study_dialog import StudyDialog
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import READING_DIED, record_case
from tactile_widgets.presenters.session.session_presenter import free_name, recordings_folder

REPLAY_JOB = "replay-case"
"""Key of the progress of simulating a case."""
_NAMING = ("scene", "effect", "robot", "factor", "level", "path", "controller", "sensor", "seed")
"""Columns that name a case, and its recording."""
_REPLAYED = ("representation", "force-feedback", "controller-accuracy", "needs")
"""Studies whose rows are of one run each; a test compares it with the studies, which take a second to load."""


class StudyPresenter(QObject):
    """Opens tables of studies, and the runs behind their rows.

    Args:
        context: What it works on.
        parent: Over which windows open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(parent)
        self._context = context
        self._window = parent
        self._scratch = Path()
        self._executor = context.backends.executor("recordings", self)
        context.notifier.cancelled.connect(self._on_cancelled)
        context.actions.bind("open_study", self.choose)

    def choose(self) -> None:
        """Ask for a table."""
        path = self._context.dialogs.open_file("Open study table", STUDY_FILTER)
        if path:
            self.open(path)

    def open(self, path: str) -> None:
        """Show a table in a window of its own; say why where it is none."""
        try:
            table = read_study_table(path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return
        study = table.file.stem
        dialog = StudyDialog(table, self._context.theme.theme, no_replay=no_replay(study), parent=self._window)
        dialog.replay_requested.connect(partial(self.replay, study))
        self._context.theme.changed.connect(dialog.set_theme)
        dialog.show()

    def replay(self, study: str, row: Row) -> None:
        """Simulate the run behind a row anew, and open it as a recording; what is simulated before is given up."""
        self.close()
        folder = recordings_folder()
        words = (row[name] for name in _NAMING if row.get(name) is not None)
        name = " ".join(str(word).replace("/", "-") for word in (study, *words))
        self._scratch = folder / f".tactile-maps-{secrets.token_hex(8)}.part"
        progress = partial(self._context.notifier.progress, REPLAY_JOB)
        progress(f"Replaying a run of {study}", 0.0)
        job = Job(record_case, study, row, free_name(folder / f"{name}.mcap"), self._scratch, died=READING_DIED)
        self._executor.start(job, self._on_recorded, self._on_failed, progressed=progress)

    def close(self) -> None:
        """Give up what is simulated; nothing of it stays."""
        self._executor.close()
        if self._scratch.name:
            shutil.rmtree(self._scratch, ignore_errors=True)
        self._context.notifier.done(REPLAY_JOB)

    def _on_recorded(self, path: Path) -> None:
        self._context.session.open_recording(path)
        self._context.notifier.done(REPLAY_JOB)

    def _on_failed(self, text: str) -> None:
        self._context.notifier.fault(text)
        self._context.notifier.done(REPLAY_JOB)

    def _on_cancelled(self, job: str) -> None:
        if job == REPLAY_JOB:
            self.close()

    def list_findings(self, menu: QMenu) -> None:
        """List the tables that ship."""
        if menu.isEmpty():
            for path in sorted(asset("findings").glob("*.csv")):
                item = menu.addAction(path.stem.replace("-", " ").capitalize())
                item.setObjectName(f"finding-{path.stem}")
                item.setToolTip(f"What tactile-maps study {path.stem} measured")
                item.triggered.connect(partial(self._open_listed, str(path)))

    def _open_listed(self, path: str, _checked: bool = False) -> None:
        self.open(path)


def no_replay(study: str) -> str:
    """Why no run of a study can be replayed; empty where they can."""
    if study in _REPLAYED:
        return ""
    if study not in STUDY_NAMES:
        return f"Whose table this is, its file's name says: {study} is no study"
    return f"No row of {study} is of one run; those of {', '.join(_REPLAYED[:-1])} and {_REPLAYED[-1]} are"
