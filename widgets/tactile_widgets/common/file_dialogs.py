"""File dialogs, their filters, and the files that the window opens. The dialogs read no files.

Qt's own dialog reads the beginning of each listed file to choose its icon and to describe its type. On special files,
such as some below ``/proc``, that never returns, and the window hangs.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import overload

from PySide6.QtCore import QFileInfo
from PySide6.QtGui import QIcon, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QFileDialog, QFileIconProvider, QWidget

from tactile_maps.core.file_kinds import SOURCES, FileKind
from tactile_maps.skin.formats.identify import suffixes_of

OPENED = frozenset(FileKind) - SOURCES
"""Kinds that the window opens when they are chosen, dropped or named on the command line."""
ROBOTS = (FileKind.ROBOT, FileKind.ROBOT_WITH_TAXELS, FileKind.MESH)

_Icon = QFileIconProvider.IconType


class FileDialog(QFileDialog):
    """File dialog with the same icon for all files. ``directory`` may end with a file name, which is then proposed."""

    def __init__(self, parent: QWidget | None, title: str, directory: str = "", kinds: str = "") -> None:
        super().__init__(parent, title, directory, kinds)
        self._icons = _PlainIcons()  # the dialog does not keep it alive
        self.setIconProvider(self._icons)

    @classmethod
    def open_file(cls, parent: QWidget | None, title: str, directory: str, kinds: str) -> str:
        """Ask for a file to read; return an empty text if none is chosen."""
        dialog = cls(parent, title, directory, kinds)
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        return dialog._first()

    @classmethod
    def open_files(cls, parent: QWidget | None, title: str, directory: str, kinds: str) -> list[str]:
        """Ask for several files to read; return an empty list if none is chosen."""
        dialog = cls(parent, title, directory, kinds)
        dialog.setFileMode(QFileDialog.FileMode.ExistingFiles)
        return dialog._chosen()

    @classmethod
    def save_file(cls, parent: QWidget | None, title: str, directory: str, kinds: str) -> str:
        """Ask for a file to write, and before one is replaced; return an empty text if none is chosen.

        The kind of the proposed name is chosen at first. A kind without a pattern, such as
        ``JSON: only for one link ()``, is greyed: it states why it cannot be chosen.
        """
        dialog = cls(parent, title, directory, kinds)
        dialog._grey_kinds()
        dialog._choose_kind(PurePath(directory).suffix)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setFileMode(QFileDialog.FileMode.AnyFile)
        if ";;" in kinds:  # a name without an extension gets that of the chosen format
            dialog.filterSelected.connect(dialog._on_filter_selected)
            dialog._on_filter_selected(dialog.selectedNameFilter())
        return dialog._first()

    def _choose_kind(self, suffix: str) -> None:
        for kind in self.nameFilters():
            if suffix and f"*{suffix}" in kind.rpartition("(")[2].rstrip(")").split():
                self.selectNameFilter(kind)
                return

    def _grey_kinds(self) -> None:
        box = self.findChild(QComboBox, "fileTypeCombo")
        assert isinstance(box, QComboBox)
        model = box.model()
        assert isinstance(model, QStandardItemModel)
        for row in range(box.count()):
            reason = box.itemText(row).removesuffix(" ()")
            if reason != box.itemText(row):
                box.setItemText(row, reason)
                model.item(row).setEnabled(False)

    def _on_filter_selected(self, chosen: str) -> None:
        self.setDefaultSuffix(chosen.rpartition("*")[2].rstrip(")").lstrip("."))

    @classmethod
    def choose_folder(cls, parent: QWidget | None, title: str, directory: str) -> str:
        """Ask for a folder; return an empty text if none is chosen."""
        dialog = cls(parent, title, directory)
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.setOption(QFileDialog.Option.ShowDirsOnly)
        return dialog._first()

    def _first(self) -> str:
        return next(iter(self._chosen()), "")

    def _chosen(self) -> list[str]:
        accepted = self.exec()
        self.deleteLater()
        return self.selectedFiles() if accepted else []


class _PlainIcons(QFileIconProvider):
    """Icons and descriptions of folders and files, without reading them."""

    @overload
    def icon(self, what: QFileIconProvider.IconType) -> QIcon: ...
    @overload
    def icon(self, what: QFileInfo) -> QIcon: ...
    def icon(self, what: QFileIconProvider.IconType | QFileInfo) -> QIcon:
        """Return the icon of a kind, or of a file or folder."""
        if isinstance(what, QFileInfo):
            return super().icon(_Icon.Folder if what.isDir() else _Icon.File)
        return super().icon(what)

    def type(self, info: QFileInfo) -> str:
        """Return the description of a file or folder."""
        return "Folder" if info.isDir() else "File"


def file_filter(title: str, *kinds: FileKind) -> str:
    """Return the filter of a file dialog for some kinds, with the suffixes of plug-ins."""
    suffixes = dict.fromkeys(suffix for kind in kinds for suffix in suffixes_of(kind))
    return f"{title} ({' '.join(f'*{suffix}' for suffix in suffixes)})"


def taxel_filter() -> str:
    """Return the filter for files with taxels, among them robots that state their own."""
    return file_filter("Taxels", FileKind.TAXELS, FileKind.SKIN, FileKind.LAYOUT, FileKind.ROBOT)


ROBOT_FILTER = file_filter("Robots and meshes", *ROBOTS, FileKind.SCENE)
RECORDING_FILTER = file_filter("Recordings", FileKind.RECORDING)
SCENE_FILTER = file_filter("Scenes", FileKind.SCENE)
STUDY_FILTER = file_filter("Tables of studies", FileKind.STUDY_TABLE)
SCRIPT_FILTER = "Stimulus scripts (*.toml)"
