"""Files of recordings: list of a folder, parts and episodes saved as files, labels, and the trash."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QFile, QStandardPaths, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QMessageBox, QWidget

from tactile_maps.core.errors import RecordingError, names_text
from tactile_maps.recording.encoding.annotations import Outcome, annotations_file
from tactile_maps.recording.overview.summary import RecordingSummary
from tactile_maps.recording.trim import TrimResult
from tactile_widgets.common.file_dialogs import RECORDING_FILTER
from tactile_widgets.common.settings import Question
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.dialogs.recordings_dialog import RecordingsDialog
from tactile_widgets.jobs.executor import Job
from tactile_widgets.jobs.recording_jobs import (
    READING_DIED,
    annotate,
    save_labelled_episodes,
    save_part,
    send_summaries,
)
from tactile_widgets.presenters.files.file_presenter import FilePresenter
from tactile_widgets.presenters.session.overlay_presenter import OverlayPresenter

MOST_LISTED = 500
_MOST_DAMAGE = 3
_FOLDER = "Recordings"
"""Key in the settings of the folder that was listed last."""


@dataclass(frozen=True)
class TrashedFile:
    """A file that was moved to the trash.

    Attributes:
        path: Its path before.
        place: Its path in the trash; None if the system does not state it.
    """

    path: Path
    place: Path | None


class RecordingsPresenter(Presenter):
    """Lists, cuts, labels and deletes recordings; their data is never changed.

    Args:
        context: Session, views, panels and services of the window.
        files: Opens recordings.
        overlay: Draws a second recording over the one that is shown.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, files: FilePresenter, overlay: OverlayPresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._files = files
        self._overlay = overlay
        self.dialog: RecordingsDialog | None = None
        self._folder = Path()
        self._scratch: list[Path] = []
        self._trashed: list[tuple[TrashedFile, ...]] = []  # with the notes, the last one at the end
        self._cutter = context.backends.executor("recordings", self)
        self._summaries = context.backends.executor("recordings", self)
        self._progress = JobProgress(self._notifier, self._cancel_cutting)
        context.actions.bind(
            recordings=self.list_recordings,
            trim_range=self.choose_part,
            save_episodes=self.choose_episodes,
            delete_recording=self.delete_shown,
            restore_recording=self.restore_deleted,
        )
        self._session.replay.player_changed.connect(self._on_player_changed)

    def close(self) -> None:
        """Cancel all work and remove its files."""
        self._cancel_cutting()
        self._summaries.close()

    def _cancel_cutting(self) -> None:
        self._cutter.close()
        for scratch in self._scratch:
            shutil.rmtree(scratch, ignore_errors=True)
        self._scratch.clear()
        self._progress.end()

    # Parts.

    def choose_part(self) -> None:
        """Ask for a file, and save the range as a recording."""
        player = self._session.replay.player
        chosen = self._context.timeline.range
        if player is None or chosen is None:
            return
        first = player.tick_at(chosen.start)
        last = player.tick_at(chosen.end)
        path = self._context.dialogs.save_file("Save range", f"{player.path.stem} part.mcap", RECORDING_FILTER)
        if path:
            target = Path(path)
            scratch = self._scratch_in(target.parent)
            self._cut(Job(save_part, player.path, target, (first, last), scratch, died=READING_DIED))

    def choose_episodes(self) -> None:
        """Ask for a folder, and save each episode as a recording in it."""
        player = self._session.replay.player
        if player is not None and (folder := self._context.dialogs.open_folder("Save episodes")):
            scratch = self._scratch_in(Path(folder).parent)
            self._cut(Job(save_labelled_episodes, player.path, Path(folder), scratch, died=READING_DIED))

    def _cut(self, job: Job[list[TrimResult]]) -> None:
        self._progress.show("Writing the part", 0.0)
        self._cutter.start(job, self._on_cut, self._on_failed, progressed=self._progress.show)

    def _scratch_in(self, folder: Path) -> Path:
        """Return the name of a new folder for files that are being written; it is removed if they are cancelled."""
        scratch = folder / f".tactile-maps-{secrets.token_hex(8)}.part"
        self._scratch.append(scratch)
        return scratch

    def _on_failed(self, text: str) -> None:
        self._notifier.fault(text, of="save range")
        self._progress.end()

    def _on_cut(self, written: list[TrimResult]) -> None:
        """Show what was saved, and which damage of the recording affects it."""
        notifier = self._notifier
        self._progress.end()
        single = len(written) == 1
        saved = written[0].file if single else f"{len(written)} episodes in {Path(written[0].file).parent}"
        if single:
            self._session.recording.saved.emit(saved)
        else:
            notifier.say(f"Saved {saved}", of="save range")
        self._context.dialogs.remember_opened(Path(written[0].file).parent)
        damage = list(dict.fromkeys(text for part in written for text in part.damage_texts))
        if damage:
            texts = names_text(damage, _MOST_DAMAGE, separator="; ")
            text = f"Saved {saved} with the damage of the recording: {texts}"
            remedies = [self._context.actions[name] for name in ("replay_saved", "show_saved")] if single else []
            notifier.say(text, fault=True, remedies=remedies, of="save range")

    # The list.

    def list_recordings(self) -> None:
        """Show the recordings of the folder that was listed last, or of the default folder."""
        if self.dialog is None:
            dialog = self.dialog = RecordingsDialog(self._window)
            dialog.replay_requested.connect(self._replay)
            dialog.overlay_requested.connect(self._overlay.open)
            dialog.show_requested.connect(self._show_file)
            dialog.delete_requested.connect(self.delete)
            dialog.undo_requested.connect(self.restore_deleted)
            dialog.outcome_chosen.connect(self.judge)
            dialog.label_requested.connect(self._ask_label)
            dialog.folder_requested.connect(self._choose_folder)
            dialog.finished.connect(self._on_dialog_closed)
        usual = self._context.settings.recordings_folder
        known = Path(self._context.settings.folder(_FOLDER) or usual)
        self.show_folder(known if known.is_dir() else usual)
        self.dialog.set_overlay_possible(possible=self._session.replay.player is not None)
        self._show_trashed()
        self.dialog.show()
        self.dialog.activateWindow()

    def _replay(self, path: Path) -> None:
        """Open a recording, and close the list, which would cover it and its messages."""
        if self.dialog is not None:
            self.dialog.close()
        self._files.open_path(str(path))

    def _on_dialog_closed(self) -> None:
        self._summaries.close()
        self.dialog = None

    def show_folder(self, folder: Path) -> None:
        """List the recordings of a folder, the newest first, select the one shown, and read their summaries."""
        assert self.dialog is not None
        self._folder = folder
        recorder = self._session.recording.recorder
        being_written = None if recorder is None else recorder.written
        found = [(_written(path), path) for path in folder.glob("*.mcap") if path != being_written]
        paths = [path for _, path in sorted(found, reverse=True)]
        listed = paths[:MOST_LISTED]
        self.dialog.show_folder(folder, listed, len(paths) - len(listed))
        if (player := self._session.replay.player) is not None:
            self.dialog.select(player.path)
        self._summaries.close()
        self._notifier.succeed("list recordings")
        if listed:
            job = Job(send_summaries, tuple(listed), died=READING_DIED)
            self._summaries.start(
                job, failed=partial(self._notifier.fault, of="list recordings"), received=self._show_summary
            )

    def _show_summary(self, summary: RecordingSummary) -> None:
        if self.dialog is not None:
            self.dialog.show_summary(summary)

    def _choose_folder(self) -> None:
        if folder := self._context.dialogs.open_folder(_FOLDER):
            self.show_folder(Path(folder))
            self._context.dialogs.remember_opened(folder)

    def _show_file(self, path: Path) -> None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.parent)))

    # Notes on recordings.

    def judge(self, path: Path, outcome: Outcome | None) -> None:
        """Set the outcome of a recording."""
        self._annotate(path, {"outcome": outcome})

    def _ask_label(self, path: Path, label: str) -> None:
        def labelled(text: str) -> None:
            self._annotate(path, {"label": text.strip()})

        self._context.dialogs.ask_text("recording-label", "Label", f"What is {path.name}?", labelled, value=label)

    def _annotate(self, path: Path, changes: dict[str, Any]) -> None:
        """Change notes: in the document for the recording that is shown, in the file for any other."""
        player = self._session.replay.player
        notes = self._context.notes
        if player is not None and player.path == path and notes.editable:
            notes.edit("Label recording", replace(notes.value, **changes))
            changes = {}
        job = Job(annotate, path, changes, died=READING_DIED)
        self._cutter.start(job, self._show_summary, partial(self._notifier.fault, of="list recordings"))

    # The trash.

    def delete_shown(self) -> None:
        """Ask whether to delete the recording that is shown."""
        if (player := self._session.replay.player) is not None:
            self.delete(player.path)

    def delete(self, path: Path) -> None:
        """Ask unless the user switched that off, then move a recording and its notes to the trash."""
        button = QMessageBox.StandardButton
        then: Callable[[QMessageBox.StandardButton], None] = partial(self._on_delete_answered, path)
        if not self._context.settings.preferences.asks(Question.TRASH):
            then(button.Yes)
            return
        text = f"Move {path.name} to the trash? Its notes are moved too."
        self._context.dialogs.ask(
            "delete-recording", "Delete recording", text, button.Yes | button.Cancel, then, default=button.Cancel
        )

    def _on_delete_answered(self, path: Path, answer: QMessageBox.StandardButton) -> None:
        if answer is not QMessageBox.StandardButton.Yes:
            return
        player = self._session.replay.player
        if player is not None and player.path == path:
            self._session.replay.leave()
        moved = [_to_trash(path)]
        if moved[0] is not None and (notes := annotations_file(path)).exists():
            moved.append(_to_trash(notes))
        trashed = tuple(file for file in moved if file is not None)
        if not trashed:
            self._notifier.fault(
                f"{path} cannot be moved to the trash and remains. Delete it in its folder.", of="delete recording"
            )
            return
        remedies = []
        if trashed[0].place is not None:
            self._trashed.append(trashed)
            remedies.append(self._context.actions["restore_recording"])
        self._notifier.say(f"{path.name} is in the trash", remedies=remedies, of="delete recording", lasting=True)
        if self.dialog is not None:
            self.dialog.remove(path)
            self._show_trashed()

    def restore_deleted(self) -> None:
        """Move the recording that was deleted last back from the trash, with its notes."""
        if not self._trashed:
            return
        files = self._trashed[-1]
        path = files[0].path
        with self._notifier.errors_shown("delete recording", finishes=False):
            for file in files:
                _from_trash(file)
            self._notifier.say(f"{path.name} is back in {path.parent}", of="delete recording")
        left = tuple(file for file in files if file.place is not None and file.place.exists())
        self._trashed[-1:] = [left] if left else []
        if self.dialog is not None:
            self.show_folder(self._folder)
            self.dialog.select(path)
            self._show_trashed()

    def _show_trashed(self) -> None:
        if self.dialog is not None:
            self.dialog.show_trashed(self._trashed[-1][0].path if self._trashed else None)

    def _on_player_changed(self, player: object) -> None:
        if self.dialog is not None:
            self.dialog.set_overlay_possible(possible=player is not None)


def _written(path: Path) -> float:
    """Return the time of the last change of a file [s since 1970]; 0 if the file is gone."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _to_trash(path: Path) -> TrashedFile | None:
    """Move a file to the trash; return None if that failed."""
    with suppress(OSError):  # if it cannot be created, moveToTrash fails too
        Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericDataLocation)).mkdir(
            parents=True, exist_ok=True
        )
    file = QFile(str(path))
    if not file.moveToTrash():
        return None
    return TrashedFile(path, Path(file.fileName()) if file.fileName() else None)


def _from_trash(file: TrashedFile) -> None:
    """Move a file back from the trash, and delete what the trash of a Linux desktop noted about it.

    Raises:
        RecordingError: It is not in the trash any more, or cannot be moved.
    """
    place = file.place
    if place is None or not place.exists():
        raise RecordingError("the file is no longer in the trash", file=file.path)
    if file.path.exists():
        remedy = "Rename it; the deleted file remains in the trash"
        raise RecordingError("there is another file of this name", file=file.path, remedy=remedy)
    try:
        shutil.move(place, file.path)
        if place.parent.name == "files":
            (place.parent.parent / "info" / f"{place.name}.trashinfo").unlink(missing_ok=True)
    except OSError as error:
        raise RecordingError(
            "the file cannot be moved back from the trash", file=file.path, value=error.strerror
        ) from error
