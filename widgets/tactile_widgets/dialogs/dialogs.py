"""Standard dialogs: files, questions, and short texts."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QInputDialog, QMessageBox, QWidget

from tactile_widgets.common.file_dialogs import RECORDING_FILTER, FileDialog
from tactile_widgets.common.make import DELETED_ON_CLOSE, make
from tactile_widgets.common.settings import Settings

Button = QMessageBox.StandardButton

FOLDERS_OF_RECORDINGS = ("Recordings", "Folder of recordings", "Save episodes")
"""Titles of dialogs for a folder of recordings."""
_State = tuple[int, int, int]


@dataclass(frozen=True)
class _ChosenFile:
    """A file that was chosen in a dialog for saving, and its state ``before`` it is written."""

    title: str
    default: str
    kinds: str
    path: str
    before: _State | None


class Dialogs:
    """Dialogs of a window. A file dialog opens in the folder of the last file of its kind.

    The first dialog for recordings opens in the folder of recordings, any other first one in the folder of the document
    or, without one, in the user's documents.

    Folder and name of a file to save are stored once the file is written, which may be in the background. The folder
    of a file to read is stored once the caller reports with ``remember_opened`` that the file could be used.

    Args:
        parent: The window.
        settings: Stores folders by kind of file, and names.

    Attributes:
        document: Returns the file of the document or recording that is shown; None if there is none.
    """

    def __init__(self, parent: QWidget, settings: Settings) -> None:
        self._parent = parent
        self._settings = settings
        self.document: Callable[[], Path | None] = lambda: None
        self._shown: dict[str, QMessageBox] = {}
        self._saving: list[_ChosenFile] = []
        self._opening: dict[str, tuple[str, str]] = {}
        """Kind and folder by chosen file or folder."""

    def open_file(self, title: str, kinds: str, *, over: QWidget | None = None) -> str:
        """Ask for a file to read, ``over`` a dialog of the window; return an empty text if none is chosen."""
        start = self._folder(title, kinds)
        chosen = FileDialog.open_file(over or self._parent, title, start, f"{kinds};;All files (*)")
        self._expect_opened(_kind(title, kinds), chosen)
        return chosen

    def open_files(self, title: str, kinds: str) -> list[str]:
        """Ask for several files to read; return an empty list if none is chosen."""
        paths = FileDialog.open_files(self._parent, title, self._folder(title, kinds), f"{kinds};;All files (*)")
        self._expect_opened(_kind(title, kinds), *paths)
        return paths

    def open_folder(self, title: str) -> str:
        """Ask for a folder; return an empty text if none is chosen."""
        chosen = FileDialog.choose_folder(self._parent, title, self._folder(title, ""))
        if chosen:
            self._opening[_key(chosen)] = title, chosen
        return chosen

    def _expect_opened(self, kind: str, *paths: str) -> None:
        self._opening.update({_key(path): (kind, str(Path(path).parent)) for path in paths if path})

    def remember_opened(self, *paths: str | Path | None) -> None:
        """Store the folders of files or folders that were chosen to be read, and could be used."""
        for path in paths:
            if path is not None and (chosen := self._opening.pop(_key(path), None)) is not None:
                self._settings.set_folder(*chosen)

    def save_file(
        self, title: str, name: str, kinds: str, *, over: QWidget | None = None, remembers: bool = True
    ) -> str:
        """Ask for a file to write, by default called ``name``; return an empty text if none is chosen.

        With ``remembers``, the name that was chosen the last time instead of the same default name is proposed, with
        a number if it exists. Without it, ``name`` is proposed: that of the document, which may be replaced.

        A name without an extension gets that of ``name``. If the completed file exists, the dialog opens again
        with it, as Qt asked about the typed name only.
        """
        folder = self._folder(title, kinds)  # which stores the last name
        start = str(Path(folder) / name)
        if remembers:
            start = str(_free_name(Path(folder) / (self._settings.name_for(title, name) or name)))
        ending = Path(name).suffix
        while True:
            path = FileDialog.save_file(over or self._parent, title, start, kinds)
            if not path or Path(path).suffix or not ending or f"*{ending}" not in kinds:
                return self._saved(title, name, kinds, path)
            start = path + ending
            if not os.path.lexists(start):
                return self._saved(title, name, kinds, start)

    def _saved(self, title: str, default: str, kinds: str, path: str) -> str:
        if path:
            self._saving.append(_ChosenFile(title, default, kinds, path, _state(path)))
        return path

    def remember_saved(self) -> None:
        """Store the folders and names of chosen files that have been written since."""
        written = [one for one in self._saving if _state(one.path) not in (None, one.before)]
        self._saving = [one for one in self._saving if one not in written]
        for one in written:
            self._settings.set_name(one.title, one.default, Path(one.path).name)
            self._settings.set_folder(_kind(one.title, one.kinds), str(Path(one.path).parent))

    def _folder(self, title: str, kinds: str) -> str:
        self.remember_saved()
        found = (self._settings.folder(key) for key in (_kind(title, kinds), title))
        known = next((folder for folder in found if folder and Path(folder).is_dir()), "")
        return known or str(self._first_folder(title, kinds))

    def _first_folder(self, title: str, kinds: str) -> Path:
        document = self.document()
        if kinds == RECORDING_FILTER or title in FOLDERS_OF_RECORDINGS:
            folder = self._settings.recordings_folder
        else:
            folder = self._settings.documents_folder if document is None else document.absolute().parent
        return next((one for one in (folder, *folder.parents) if os.path.isdir(one)), Path())

    def ask(
        self, name: str, title: str, text: str, buttons: Button, then: Callable[[Button], None], *, default: Button
    ) -> None:
        """Ask a question; ``then`` is called with the pressed button."""
        box = self._show(name, title, text, buttons)
        box.setDefaultButton(default)
        box.finished.connect(lambda button: then(Button(button)))

    def ask_text(self, name: str, title: str, text: str, then: Callable[[str], None], *, value: str = "") -> None:
        """Ask for a line of text, by default ``value``; ``then`` is called with it unless the dialog is cancelled."""
        self._ask_input(name, then, windowTitle=title, labelText=text, textValue=value)

    def ask_choice(
        self,
        name: str,
        title: str,
        text: str,
        choices: Sequence[str],
        then: Callable[[str], None],
        *,
        proposed: str | None = None,
    ) -> None:
        """Ask for one of ``choices``; ``then`` is called with it unless the dialog is cancelled.

        ``proposed`` is chosen at first; None for the first choice.
        """
        chosen = choices[0] if proposed is None else proposed
        self._ask_input(name, then, windowTitle=title, labelText=text, comboBoxItems=list(choices), textValue=chosen)

    def ask_button(self, name: str, title: str, text: str, choices: Sequence[str], then: Callable[[str], None]) -> None:
        """Ask a question with a button for each choice; ``then`` is called with its text unless it is cancelled.

        The last choice is the default.
        """
        box = self._show(name, title, text, Button.Cancel)
        buttons = [box.addButton(choice, QMessageBox.ButtonRole.AcceptRole) for choice in choices]
        box.setDefaultButton(buttons[-1])

        def finished(_result: int) -> None:
            chosen = box.clickedButton()
            if chosen in buttons:
                then(chosen.text())

        box.finished.connect(finished)

    def _ask_input(self, name: str, then: Callable[[str], None], **settings: object) -> None:
        delete = DELETED_ON_CLOSE
        make(QInputDialog, self._parent, objectName=name, textValueSelected=then, attribute=delete, **settings).open()

    def show_text(self, name: str, title: str, text: str) -> None:
        """Show a text with a button that closes it; if it is open already, bring it to the front."""
        if name in self._shown:
            self._shown[name].activateWindow()
        else:
            self._shown[name] = self._show(name, title, text, Button.Close)
            self._shown[name].finished.connect(lambda _button: self._shown.pop(name, None))

    def _show(self, name: str, title: str, text: str, buttons: Button) -> QMessageBox:
        box = QMessageBox(QMessageBox.Icon.NoIcon, title, text, buttons, self._parent)
        box.setObjectName(name)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.open()
        return box


def _free_name(path: Path) -> Path:
    """Return ``path``, or with the next number if it exists."""
    while os.path.lexists(path):
        ending = "" if path.is_dir() else path.suffix
        whole = path.name.removesuffix(ending)
        name, _, number = whole.rpartition(" ")
        path = path.with_name((f"{name} {int(number) + 1}" if name and number.isdecimal() else f"{whole} 2") + ending)
    return path


def _state(path: str) -> _State | None:
    """Return what changes when a file or folder is written or replaced; None if there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


def _key(path: str | Path) -> str:
    """Return a path without repeated separators."""
    return str(Path(path))


def _kind(title: str, kinds: str) -> str:
    """Return the kind of the files of a dialog: the words of its only filter, or else the title of the dialog."""
    return title if not kinds or ";;" in kinds else kinds.partition(" (")[0]
