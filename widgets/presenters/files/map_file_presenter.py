"""Where the map being edited is kept: saved, saved by itself, found again after a crash, and never lost unasked."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path

from platformdirs import user_state_path
from PySide6.QtCore import QObject, QTimer, Signal

from app.core.errors import TactileMapsError
from app.core.files import FolderClaim, claim_folder
from app.editing.document import MapDocument
from app.editing.document_file import AUTOSAVE_ENDING, UNTITLED, DocumentFile, load_document
from app.editing.layout_import import adopt_document
from app.maps.formats.export import ENDINGS, write_map
from app.session.prepare import PreparedScene
from app.skin.formats.mujoco_touch import write_touch_sensors
from widgets.context.app_context import AppContext
from widgets.context.dialogs import Button

AUTOSAVE_MS = 20_000
SENSORS_ENDING = ".xml"
"""The robot as MJCF with a touch sensor for each taxel."""
_MAPS = "Tactile maps (*.npz)"


class MapFilePresenter(QObject):
    """The file of the document being edited. Mutable.

    Args:
        context: What it works on.
        parent: Qt parent.
    """

    changed = Signal()
    """Another file, or another answer to whether there is something to save."""

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._context, self._editor = context, context.editor
        self._file: DocumentFile | None = None
        self._claim: FolderClaim | None = None
        self._recovered: MapDocument | None = None
        self._discarded = False  # unsaved edits need not outlive the document, once it really goes
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="autosave")
        self._writing: Future[bool] | None = None
        self._timer = QTimer(self)
        self._timer.setInterval(AUTOSAVE_MS)
        self._timer.timeout.connect(self.autosave)
        self._timer.start()
        self._editor.history_changed.connect(self.changed)
        for name, handler in (
            ("open_map", self.choose_open),
            ("save_map", self.save),
            ("save_map_as", self.choose_save),
            ("export_map", self.choose_export),
            ("restore_map", self.restore),
            ("take_over", partial(self.leave, context.session.take_over)),
        ):
            context.actions.bind(name, handler)

    @property
    def unsaved(self) -> bool:
        """Whether closing now would lose an edit."""
        document = self._editor.document
        return self._file is not None and document is not None and self._file.unsaved(document)

    @property
    def path(self) -> Path | None:
        """The map's file; None until it has one."""
        return None if self._file is None else self._file.path

    def begin(self, prepared: PreparedScene, document: MapDocument) -> None:
        """Begin with another scene, whose map without edits is ``document``. Offer what a crash left of its edits."""
        self._release()
        self._recovered = None
        try:
            self._claim = claim_autosave_folder(prepared.robot.name)
        except OSError as error:
            self._context.notifier.fault(f"Edits are not kept in case of a crash: {error}. Save them now and then.")
        self._file = DocumentFile(None, document, folder=None if self._claim is None else self._claim.folder)
        try:
            found = self._file.recovery()
            if found is not None:
                recovered = load_document(found.file)
                adopt_document(document, recovered)
                self._recovered = recovered
        except TactileMapsError:
            self._recovered = None  # of another skin, or half written: nothing that could be taken back
        if self._recovered is not None:
            self._context.notifier.say(
                "This map has edits that were not saved when the program ended.",
                remedies=[self._context.actions["restore_map"]],
            )
        self.changed.emit()

    def restore(self) -> None:
        """Take back what a crash left, as one edit."""
        recovered, self._recovered = self._recovered, None
        if recovered is not None:
            self._editor.do("Restore", lambda document: adopt_document(document, recovered))

    # Saving.

    def save(self) -> bool:
        """Save where it is kept; ask where, the first time, and whether, if others have changed it. Whether it is."""
        if self._file is None or self._file.path is None:
            return self.choose_save()
        path = self._file.path
        if not self._file.changed_elsewhere:
            return self._save(path)
        text = f"{path} was changed by another window or program since it was opened or saved here."
        buttons = Button.Save | Button.Cancel

        def answered(answer: Button) -> None:
            if answer == Button.Save:
                self._save(path)

        self._context.dialogs.ask("overwrite", "Replace the changed file?", text, buttons, answered,
                                  default=Button.Cancel)  # fmt: skip
        return False

    def choose_save(self) -> bool:
        """Ask where to save. Whether it is saved."""
        path = self._ask_path("Save map", _MAPS, ".npz")
        return bool(path) and self._save(Path(path))

    def _save(self, path: Path) -> bool:
        document = self._editor.document
        if self._file is None or document is None:
            return False
        self._wait()
        try:
            self._file.save_as(document, path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return False
        self._context.notifier.say(f"Saved {path}")
        self._context.settings.add_recent(str(path))
        self.changed.emit()
        return True

    def choose_export(self) -> None:
        """Ask where to write the map for other programs."""
        kinds = ";;".join(f"{ending[1:].upper()} (*{ending})" for ending in (*ENDINGS, SENSORS_ENDING))
        path = self._ask_path("Export map", kinds, "")
        if path:
            self.export(path)

    def export(self, path: str) -> None:
        """Write the map as the file's ending says."""
        document, prepared = self._editor.document, self._context.session.prepared
        if document is None or prepared is None:
            return
        try:
            if Path(path).suffix.lower() == SENSORS_ENDING:
                write_touch_sensors(document.map.skin, prepared.robot, path)
            else:
                write_map(document.map, path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
        else:
            self._context.notifier.say(f"Exported {path}")

    def _ask_path(self, title: str, kinds: str, ending: str) -> str:
        prepared = self._context.session.prepared
        if prepared is None:
            return ""
        return self._context.dialogs.save_file(title, f"{prepared.robot.name}{ending}", kinds)

    # Opening.

    def choose_open(self) -> None:
        """Ask for a saved map."""
        path = self._context.dialogs.open_file("Open map", _MAPS)
        if path:
            self.open(path)

    def open(self, path: str) -> bool:
        """Take over a saved map of this skin, as one edit; it is saved there from then on. Whether it was taken."""
        if self._file is None:
            self._context.notifier.say(f"{path}: open the robot first that this map is of.", fault=True)
            return False
        try:
            other = load_document(path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return False
        if not self._editor.do(f"Open {Path(path).name}", lambda document: adopt_document(document, other)):
            return False
        self._wait()
        self._file.drop_autosave()
        self._file = DocumentFile(Path(path), self._editor.document)
        self._context.settings.add_recent(path)
        self.changed.emit()
        return True

    # Not losing anything.

    def autosave(self) -> None:
        """Keep a copy of what is not saved, beside the window's work."""
        document = self._editor.document
        if self._file is None or document is None or self._editor.gesture or not self._written():
            return
        if self._recovered is None or self._file.unsaved(document):
            self._writing = self._writer.submit(self._file.autosave, document)

    def _written(self) -> bool:
        """Whether the last copy is written; said once, if it could not be."""
        if self._writing is None:
            return True
        if not self._writing.done():
            return False
        writing, self._writing = self._writing, None
        error = writing.exception()
        if error is None:
            return True
        if isinstance(error, TactileMapsError):
            self._context.notifier.fault(str(error))
        else:
            self._context.notifier.unexpected(error)
        self._timer.stop()
        return True

    def _wait(self) -> None:
        if self._writing is not None:
            self._writing.exception()
            self._written()

    def leave(self, then: Callable[[], None]) -> None:
        """Do ``then``, which may lose the document, once whatever is unsaved is saved or may be lost.

        Until another document begins or the window closes, this one stays as it is: a scene may fail to open.
        """
        self._discarded = False
        if not self.unsaved:
            then()
            return

        def answered(answer: Button) -> None:
            self._discarded = answer == Button.Discard
            if self._discarded or (answer == Button.Save and self.save()):
                then()

        buttons = Button.Save | Button.Discard | Button.Cancel
        text = "The map has edits that are not saved."
        self._context.dialogs.ask("leave", "Save the map?", text, buttons, answered, default=Button.Save)

    def give_up(self) -> None:
        """What is not saved is not wanted."""
        self._discarded = True
        self._release()
        self._file = None

    def _release(self) -> None:
        """The document goes; with it the copy of what a person gave up."""
        self._wait()
        if self._file is not None and self._discarded:
            try:
                self._file.drop_autosave()
            except TactileMapsError as error:
                self._context.notifier.fault(str(error))
        self._discarded = False
        if self._claim is not None:
            self._claim.release()
            self._claim = None

    def close(self) -> None:
        """Finish writing; the copy of what was given up goes."""
        self._timer.stop()
        self._release()
        self._writer.shutdown()


def claim_autosave_folder(robot: str) -> FolderClaim:
    """A folder of this window alone for maps without a file of their own; one that a crash left something in, first.

    Raises:
        OSError: It cannot be made.
    """
    folder = user_state_path("tactile-maps", appauthor=False) / "autosave" / "".join(c for c in robot if c.isalnum())
    return claim_folder(folder, holding=f"{UNTITLED}{AUTOSAVE_ENDING}")
