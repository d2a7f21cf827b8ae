"""Message at the start about unsaved edits that a crash left of documents other than the one that is opened."""

from __future__ import annotations

from contextlib import suppress
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import counted
from tactile_maps.editing.leftovers import Leftover, leftovers_of_all
from tactile_maps.scene.scene_file import load_scene, scene_from_toml
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.presenters.files.file_presenter import FilePresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter, autosave_folder


class UnsavedPresenter(Presenter):
    """Names the newest unsaved document of a crash and opens it. Mutable: that document.

    It searches once the first scene is shown, and again once the document that it named is shown, whose edits
    ``MapFilePresenter`` offers. Documents of running windows are left out, because these have claimed them.

    Args:
        context: Session, views, panels and services of the window.
        map_files: Offers the edits of the document that is shown.
        files: Opens the document.
        parent: Window over which dialogs open.
    """

    changed = Signal()
    """``found`` has changed."""

    def __init__(self, context: AppContext, map_files: MapFilePresenter, files: FilePresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._map_files = map_files
        self._files = files
        self._searched = False
        self._newest: Leftover | None = None
        map_files.begun.connect(self._on_begun)
        context.actions.bind(open_unsaved=self.open)

    @property
    def found(self) -> bool:
        """Whether a crash left edits of a document that is not shown."""
        return self._newest is not None

    def _on_begun(self, _chosen: object) -> None:
        if not self._searched or (self._newest is not None and self._map_files.offers(self._newest)):
            self._searched = True
            self.search()

    def search(self) -> None:
        """Find the newest document, and show a message about it."""
        found: list[Leftover] = []
        with suppress(OSError):
            found = [leftover for leftover in leftovers_of_all(autosave_folder("")) if leftover.openable]
        self._newest = newest = found[0] if found else None
        self.changed.emit()
        if newest is None:
            return
        others = len({leftover.name for leftover in found} - {newest.name})
        more = f" {counted(others, 'other document')} with such edits can be opened after it." if others else ""
        when = f"{datetime.fromtimestamp(newest.written):%Y-%m-%d %H:%M}"
        self._notifier.say(
            f"{newest.name} has edits that were not saved when the program ended (copy of {when}).{more}",
            remedies=[self._context.actions["open_unsaved"]],
            of="unsaved document",
            pending=lambda: self._newest is newest,
            lasting=True,
        )

    def open(self) -> None:
        """Open the document that was named; its edits are offered once it is shown."""
        found = self._newest
        if found is None:
            return
        with self._notifier.errors_shown("open file", finishes=False):
            file = Path(found.opened_file)
            if found.opened_file and file.is_file():
                self._files.open_scene(load_scene(str(file)), file=file, recent=str(file))
            else:
                scene = scene_from_toml(found.opened or found.scene, name=found.name)
                self._files.open_scene(scene, chosen=not found.opened)
