"""The patch tree: a row a patch, which can be named, shown and hidden, selected and dragged to another place."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QEvent, QItemSelection, QItemSelectionModel, QModelIndex, QPoint, QSize, Qt, Signal
from PySide6.QtGui import QDropEvent, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QAbstractItemView, QListView, QWidget

from app.editing.patches import show
from widgets.editor import Editor
from widgets.panels.panel import SLIM
from widgets.panels.patch_model import MIME, NUMBER, PatchModel, only
from widgets.panels.patch_rows import EYE, ROW, PatchRows

_MOST_ROWS = 9


class PatchList(QListView):
    """The rows; selection goes both ways between it and the editor.

    Args:
        editor: Whose document is shown.
        parent: Qt parent.
    """

    hovered = Signal(object)
    """The number of the patch under the pointer, or None."""

    def __init__(self, editor: Editor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("patch-list")
        self.setAccessibleName("Patches")
        self._editor, self.patches = editor, PatchModel(editor, self)
        self._rows = PatchRows(self.patches, self)
        self._following = False
        self.setModel(self.patches)
        self.setItemDelegate(self._rows)
        self._behave()
        self.selectionModel().selectionChanged.connect(self._on_selection_changed)
        self.entered.connect(self._on_entered)
        self.patches.modelAboutToBeReset.connect(self._on_reset_began)
        self.patches.modelReset.connect(self._on_reset)
        editor.selection_changed.connect(self._follow)
        self._on_reset()

    def _behave(self) -> None:
        self.setFrameShape(QListView.Shape.NoFrame)
        self.setUniformItemSizes(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setDragDropMode(QAbstractItemView.DragDropMode.DragDrop)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        trigger = QAbstractItemView.EditTrigger
        self.setEditTriggers(trigger.DoubleClicked | trigger.EditKeyPressed)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setMouseTracking(True)
        self.verticalScrollBar().setStyleSheet(SLIM)

    def show_hover(self, number: int | None) -> None:
        """Tint the row of the patch that the pointer is on elsewhere."""
        marked = -1 if number is None else number
        if marked != self._rows.hovered:
            self._rows.hovered = marked
            self.viewport().update()

    def toggle_visible(self, number: int, *, alone: bool = False) -> None:
        """Show or hide a patch; ``alone``: show only it, or all where it is alone already."""
        document = self._editor.document
        if document is None:
            return
        everyone = range(len(document.patches))
        if not alone:
            visible = not document.patches[number].visible
            name = f"{'Show' if visible else 'Hide'} {document.patches[number].name}"
            self._editor.do(name, partial(show, numbers=[number], visible=visible))
        elif all(document.patches[k].visible == (k == number) for k in everyone):
            self._editor.do("Show all patches", partial(show, numbers=everyone))
        else:
            self._editor.do(f"Show only {document.patches[number].name}", partial(only, numbers=[number]))

    # Qt.

    def event(self, event: QEvent) -> bool:
        """Qt: F2 names a patch here, whatever it does in the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and _names(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Alt with up and down moves what is selected in the tree."""
        arrow = event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down)
        if event.modifiers() == Qt.KeyboardModifier.AltModifier and arrow:
            rows = sorted(index.row() for index in self.selectedIndexes())
            if rows:
                before = rows[0] - 1 if event.key() == Qt.Key.Key_Up else rows[-1] + 2
                self.patches.move([self.patches.numbers[row] for row in rows], max(before, 0))
        elif event.key() == Qt.Key.Key_F2 and not event.modifiers():
            self.edit(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: a press on an eye is no selection."""
        index = self.indexAt(event.position().toPoint())
        if event.button() == Qt.MouseButton.LeftButton and self._on_eye(index, event.position().toPoint()):
            alone = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            self.toggle_visible(int(index.data(NUMBER)), alone=alone)
        else:
            super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: the second press on an eye is another press on it."""
        if self._on_eye(self.indexAt(event.position().toPoint()), event.position().toPoint()):
            self.mousePressEvent(event)
        else:
            super().mouseDoubleClickEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: the pointer is on no row."""
        super().leaveEvent(event)
        self._on_entered(QModelIndex())

    def dropEvent(self, event: QDropEvent) -> None:
        """Qt: patches dropped above, below or on a row, as the line shows."""
        if event.mimeData().hasFormat(MIME):
            at = self.indexAt(event.position().toPoint())
            below = self.dropIndicatorPosition() != QAbstractItemView.DropIndicatorPosition.AboveItem
            row = at.row() + below if at.isValid() else len(self.patches.numbers)
            self.patches.dropMimeData(event.mimeData(), event.dropAction(), row, 0, QModelIndex())
            event.accept()
        self.setState(QAbstractItemView.State.NoState)
        self.viewport().update()

    def sizeHint(self) -> QSize:
        """Qt: all rows, up to a few; then they scroll."""
        return QSize(200, ROW * min(max(len(self.patches.numbers), 1), _MOST_ROWS))

    def _on_eye(self, index: QModelIndex, at: QPoint) -> bool:
        return index.isValid() and at.x() < self.visualRect(index).left() + EYE

    # Between the rows and the editor.

    def _on_entered(self, index: QModelIndex) -> None:
        number = int(index.data(NUMBER)) if index.isValid() else None
        self.show_hover(number)
        self.hovered.emit(number)

    def _on_selection_changed(self) -> None:
        if not self._following:
            self._editor.select(int(index.data(NUMBER)) for index in self.selectedIndexes())

    def _on_reset_began(self) -> None:
        self._following = True

    def _on_reset(self) -> None:
        self._following = False
        self.setFixedHeight(self.sizeHint().height())
        self._follow()

    def _follow(self) -> None:
        """Select what the editor has selected."""
        selection = QItemSelection()
        rows = [row for number in self._editor.selected if (row := self.patches.row_of(number)) >= 0]
        for row in rows:
            selection.select(self.patches.index(row), self.patches.index(row))
        self._following = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows and self.currentIndex().row() not in rows:
            self.selectionModel().setCurrentIndex(
                self.patches.index(rows[0]), QItemSelectionModel.SelectionFlag.NoUpdate
            )
        self._following = False


def _names(event: QKeyEvent) -> bool:
    return event.key() == Qt.Key.Key_F2 and not event.modifiers()
