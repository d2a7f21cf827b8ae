"""List of the recordings in a folder with picture, scene and outcome, to replay, label, find or delete them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLocale, QPoint, QSize, Qt, Signal, SignalInstance
from PySide6.QtGui import QIcon, QImage, QKeySequence, QPixmap, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QHeaderView,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QStyledItemDelegate,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from tactile_maps.maps.pressure_colours import rounded_scale
from tactile_maps.recording.encoding.annotations import Annotations, Outcome
from tactile_maps.recording.overview.summary import RecordingSummary
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.common.make import (
    DELETED_ON_CLOSE,
    add_entry,
    column_layout,
    make,
    push_button,
    resize_on_screen,
    row_layout,
)
from tactile_widgets.plots.timeline.playhead import clock_text

_COLUMNS = ("Recording", "Length", "Robot", "Scene", "Taxels", "Outcome", "Label", "Recorded")
_PICTURE = QSize(144, 88)
_WORDS: dict[Outcome | None, str] = {Outcome.SUCCESS: "✓ Success", Outcome.FAILURE: "✗ Failure", None: ""}
_EMPTY = "This folder contains no recordings yet. Ctrl+R in the window records the session."


class RecordingsDialog(QDialog):
    """List of recordings, and requests of the user for the selected one.

    Args:
        parent: Qt parent.
    """

    replay_requested = Signal(Path)
    """Recording to open."""
    overlay_requested = Signal(Path)
    """Recording to overlay on the current one."""
    show_requested = Signal(Path)
    """File to show in its folder."""
    delete_requested = Signal(Path)
    """Recording to delete."""
    undo_requested = Signal()
    """The recording that was deleted last is to be moved back."""
    outcome_chosen = Signal(Path, Outcome)
    """Outcome of a recording; None to remove it."""
    label_requested = Signal(Path, str)
    """Recording that is to be labelled, and its current label."""
    folder_requested = Signal()
    """The user chooses another folder."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("recordings-dialog")
        self.setWindowTitle("Recordings")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        resize_on_screen(self, 980, 560)
        self._summaries: dict[Path, RecordingSummary] = {}
        self._paths: list[Path] = []
        self._trashed: Path | None = None
        self.overlay_possible = False
        self.search = make(
            QLineEdit,
            self,
            objectName="recordings-search",
            placeholderText="Search by name, robot, scene or label",
            clearButtonEnabled=True,
            textChanged=self._filter,
        )
        self.table = self._make_table()
        self.folder = QLabel(self)
        self.note = make(QLabel, self, wordWrap=True)
        self._buttons: dict[str, QPushButton] = {}
        self._replay = partial(self._request, self.replay_requested)
        self._delete = partial(self._request, self.delete_requested)
        self.table.doubleClicked.connect(self._replay)
        keys = {Qt.Key.Key_Delete: self._delete, Qt.Key.Key_Return: self._replay, Qt.Key.Key_Enter: self._replay}
        for key, act in keys.items():
            QShortcut(QKeySequence(key), self.table, act, context=Qt.ShortcutContext.WidgetShortcut)
        QShortcut(QKeySequence(QKeySequence.StandardKey.Undo), self, self.undo_requested.emit)
        self._lay_out()
        self._show_selected()

    def _make_table(self) -> QTableWidget:
        table = make(
            QTableWidget,
            0,
            len(_COLUMNS),
            self,
            objectName="recordings-table",
            accessibleName="Recordings, the newest first",
            horizontalHeaderLabels=_COLUMNS,
            selectionBehavior=QAbstractItemView.SelectionBehavior.SelectRows,
            selectionMode=QAbstractItemView.SelectionMode.SingleSelection,
            editTriggers=QAbstractItemView.EditTrigger.NoEditTriggers,
            iconSize=_PICTURE,
            showGrid=False,
            wordWrap=True,
            textElideMode=Qt.TextElideMode.ElideMiddle,
            contextMenuPolicy=Qt.ContextMenuPolicy.CustomContextMenu,
            customContextMenuRequested=self._open_menu,
            itemSelectionChanged=self._show_selected,
        )
        table.setItemDelegateForColumn(0, _NameDelegate(table))
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(_PICTURE.height() + 8)
        table.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        return table

    def _lay_out(self) -> None:
        choose = push_button(self, "recordings-folder", "Choose folder…", "", self.folder_requested, autoDefault=False)
        overlay = partial(self._request, self.overlay_requested)
        for name, words, tip, act in (
            ("replay", "Replay", "Open the recording (Return, double click)", self._replay),
            ("overlay", "Overlay", "Draw it dashed over the open recording", overlay),
            ("success", "Success", "The demonstration succeeded", partial(self._judge, Outcome.SUCCESS)),
            ("failure", "Failure", "The demonstration failed", partial(self._judge, Outcome.FAILURE)),
            ("clear", "Clear", "Remove the outcome", partial(self._judge, None)),
            ("label", "Label…", "Set its label", self._label),
            ("show", "Show in folder", "Show the folder of its file", partial(self._request, self.show_requested)),
            ("delete", "Delete…", "Move its file and annotations to the trash (Delete)", self._delete),
            ("undo", "Undo delete", "", self.undo_requested),
        ):
            self._buttons[name] = push_button(self, f"recordings-{name}", words, tip, act, autoDefault=False)
        top = row_layout(self.folder, choose, stretch=self.folder)
        bottom = row_layout(*self._buttons.values(), None)
        column_layout(
            top, self.search, self.table, self.note, bottom, parent=self, stretch=self.table, margins=(12, 12, 12, 12)
        )

    def show_folder(self, folder: Path, paths: Sequence[Path], more: int) -> None:
        """List files of a folder; ``more`` older ones are left out."""
        self._summaries = {}
        self._paths = list(paths)
        self.folder.setText(str(folder))
        self.table.setRowCount(len(paths))
        for row, path in enumerate(paths):
            for column in range(len(_COLUMNS)):
                self.table.setItem(row, column, QTableWidgetItem(path.name if column == 0 else ""))
        self._more = f"The newest {len(paths)} are listed; {more} older ones are left out." if more else ""
        self._show_note()
        self._show_selected()

    def select(self, path: Path) -> None:
        """Select a recording if it is listed."""
        if path in self._paths:
            self.table.selectRow(self._paths.index(path))

    def show_summary(self, summary: RecordingSummary) -> None:
        """Show the summary of a listed recording."""
        if summary.path not in self._paths:
            return
        self._summaries[summary.path] = summary
        row = self._paths.index(summary.path)
        annotations = summary.annotations
        length = "" if summary.seconds is None else clock_text(summary.seconds)
        taxels = str(summary.taxels) if summary.taxels else ""
        when = f"{datetime.fromtimestamp(summary.modified):%Y-%m-%d %H:%M}"
        label = "\n".join(part for part in (annotations.label, _episodes_text(annotations)) if part)
        texts = ("", length, summary.robot, summary.scene, taxels, _WORDS[annotations.outcome], label, when)
        name = summary.path.name
        for column, text in enumerate((f"⚠ {name}" if summary.problem else name, *texts[1:])):
            item = QTableWidgetItem(text)
            item.setToolTip("\n".join(filter(None, (name if column == 0 else text, summary.problem))))
            if column == 0 and summary.picture is not None:
                item.setIcon(_icon(summary.picture))
            self.table.setItem(row, column, item)
        self._show_note()
        self._show_selected()
        self._filter()

    def remove(self, path: Path) -> None:
        """Remove a recording from the list."""
        if path in self._paths:
            self.table.removeRow(self._paths.index(path))
            self._paths.remove(path)
            self._summaries.pop(path, None)
            self._show_note()

    def show_trashed(self, path: Path | None) -> None:
        """Show which recording *Undo delete* moves back from the trash; None if there is none."""
        self._trashed = path
        self._buttons["undo"].setToolTip("" if path is None else f"Move {path.name} back from the trash (Ctrl+Z)")
        self._show_selected()

    def set_overlay_possible(self, *, possible: bool) -> None:
        """Set whether a recording is open on which another one can be overlaid."""
        self.overlay_possible = possible
        self._show_selected()

    @property
    def selected(self) -> Path | None:
        """Selected recording; None if there is none."""
        rows = self.table.selectionModel().selectedRows()
        return self._paths[rows[0].row()] if rows else None

    def _show_note(self) -> None:
        missing = len(self._paths) - len(self._summaries)
        if not self._paths:
            self.note.setText(_EMPTY)
        elif missing:
            self.note.setText(f"Reading {missing} of {len(self._paths)}")
        else:
            self.note.setText(self._more)

    def _show_selected(self) -> None:
        path = self.selected
        summary = None if path is None else self._summaries.get(path)
        readable = summary is not None and summary.seconds is not None
        for name, button in self._buttons.items():
            button.setEnabled(path is not None if name in ("replay", "show", "delete") else readable)
        self._buttons["overlay"].setEnabled(readable and self.overlay_possible)
        self._buttons["undo"].setEnabled(self._trashed is not None)
        if summary is not None and summary.problem:
            self.note.setText(summary.problem)
        else:
            self._show_note()

    def _filter(self) -> None:
        words = self.search.text().casefold().split()
        for row in range(self.table.rowCount()):
            items = (self.table.item(row, column) for column in range(len(_COLUMNS)))
            text = " ".join(item.text() for item in items if item is not None).casefold()
            self.table.setRowHidden(row, not all(word in text for word in words))

    def _request(self, signal: SignalInstance, *_ignored: object) -> None:
        """Emit a signal with the selected recording."""
        if (path := self.selected) is not None:
            signal.emit(path)

    def _judge(self, outcome: Outcome | None) -> None:
        if (path := self.selected) is not None:
            self.outcome_chosen.emit(path, outcome)

    def _label(self) -> None:
        if (path := self.selected) is not None:
            self.label_requested.emit(path, self._summaries[path].annotations.label)

    def _open_menu(self, place: QPoint) -> None:
        if self.selected is None:
            return
        menu = make(QMenu, self, attribute=DELETED_ON_CLOSE)
        for button in self._buttons.values():
            add_entry(menu, button.text(), button.click, enabled=button.isEnabled())
        menu.popup(self.table.viewport().mapToGlobal(place))


class _NameDelegate(QStyledItemDelegate):
    """Wraps long names of files, also after an underscore."""

    def displayText(self, value: object, locale: QLocale | QLocale.Language) -> str:
        return super().displayText(value, locale).replace("_", "_\u200b")


def _episodes_text(annotations: Annotations) -> str:
    """Return the labels of the episodes with their number, such as ``grasp ×3, lift``; empty without episodes."""
    counts = Counter(episode.label or "no label" for episode in annotations.episodes)
    return ", ".join(f"{label} ×{count}" if count > 1 else label for label, count in counts.items())


def _icon(picture: NDArray[np.float32]) -> QIcon:
    """Return a tactile image [kPa] in the colours of the map view, transparent where it is NaN.

    The full scale is the least round number that is not below the highest pressure.
    """
    rows, columns = picture.shape
    skin = np.isfinite(picture)
    scale = PressureScale(rounded_scale(float(np.nanmax(picture, initial=0.0))))
    colours = scale.rgb(np.where(skin, picture, 0.0).ravel()).reshape(rows, columns, 3)
    data = np.concatenate([colours, np.where(skin, 255, 0).astype(np.uint8)[..., None]], axis=2)
    image = QImage(data.tobytes(), columns, rows, 4 * columns, QImage.Format.Format_RGBA8888).copy()
    whole = Qt.AspectRatioMode.KeepAspectRatio
    return QIcon(QPixmap.fromImage(image.scaled(_PICTURE * 2, whole, Qt.TransformationMode.SmoothTransformation)))
