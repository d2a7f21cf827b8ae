"""Tables of studies, each in its own window: files, and the findings of the Help menu."""

from __future__ import annotations

import secrets
import shutil
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.core.assets import asset
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.catalogue import STUDY_NAMES
from tactile_maps.studies.running.study_table import read_study_table
from tactile_widgets.common.file_dialogs import STUDY_FILTER
from tactile_widgets.common.make import add_entry
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.dialogs.study_dialog import StudyDialog
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import READING_DIED, record_case
from tactile_widgets.presenters.session.session_presenter import free_name

_NAMING = ("scene", "effect", "robot", "factor", "level", "path", "controller", "sensor", "seed")
"""Columns that name a case, and its recording."""
_REPLAYED = ("representation", "force-feedback", "controller-accuracy", "needs")
"""Studies with one run per row. A test compares this with the studies, which take a second to load."""


class StudyPresenter(Presenter):
    """Opens tables of studies, and replays the runs of their rows.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._scratch = Path()
        self._executor = context.backends.executor("recordings", self)
        self._progress = JobProgress(self._notifier, self.close)
        context.actions.bind(open_study=self.choose)

    def choose(self) -> None:
        """Ask for a table file."""
        path = self._context.dialogs.open_file("Open study table", STUDY_FILTER)
        if path:
            self.open(path)

    def open(self, path: str) -> None:
        """Show a table in its own window, or the error if the file is not one."""
        with self._notifier.errors_shown("open study"):
            table = read_study_table(path)
            study = table.file.stem
            dialog = StudyDialog(table, self._context.theme.theme, no_replay=no_replay(study), parent=self._window)
            dialog.replay_requested.connect(partial(self.replay, study))
            self._context.theme.changed.connect(dialog.set_theme)
            dialog.show()
            self._context.dialogs.remember_opened(path)

    def replay(self, study: str, row: Row) -> None:
        """Simulate the run of a row again and open it as a recording; cancel a previous simulation."""
        self.close()
        folder = self._context.settings.recordings_folder
        words = (row[name] for name in _NAMING if row.get(name) is not None)
        name = " ".join(str(word).replace("/", "-") for word in (study, *words))
        self._scratch = folder / f".tactile-maps-{secrets.token_hex(8)}.part"
        self._progress.show(f"Replaying a run of {study}", 0.0)
        job = Job(record_case, study, row, free_name(folder / f"{name}.mcap"), self._scratch, died=READING_DIED)
        self._executor.start(job, self._on_recorded, self._on_failed, progressed=self._progress.show)

    def close(self) -> None:
        """Cancel the simulation and remove its files."""
        self._executor.close()
        if self._scratch.name:
            shutil.rmtree(self._scratch, ignore_errors=True)
        self._progress.end()

    def _on_recorded(self, path: Path) -> None:
        self._notifier.succeed("replay trial")
        self._session.open_recording(path)
        self._progress.end()

    def _on_failed(self, text: str) -> None:
        self._notifier.fault(text, of="replay trial")
        self._progress.end()

    def list_findings(self, menu: QMenu) -> None:
        """List the tables of the findings."""
        if menu.isEmpty():
            for path in sorted(asset("findings").glob("*.csv")):
                about = {"objectName": f"finding-{path.stem}", "toolTip": f"Results of tactile-maps study {path.stem}"}
                add_entry(menu, path.stem.replace("-", " ").capitalize(), partial(self.open, str(path)), **about)


def no_replay(study: str) -> str:
    """Return why runs of a study cannot be replayed; empty if they can."""
    if study in _REPLAYED:
        return ""
    if study not in STUDY_NAMES:
        return f"The file is not named after a study: {study} is unknown"
    singles = f"{', '.join(_REPLAYED[:-1])} and {_REPLAYED[-1]}"
    return f"A row of {study} summarizes several runs; rows of {singles} are single runs"
