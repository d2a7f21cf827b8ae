"""Lists without a frame: their settings, a model with one row per item, and a delegate with rows of fixed height."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, TypeVar

from PySide6.QtCore import QAbstractListModel, QModelIndex, QObject, QPersistentModelIndex, QSize, Qt
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QAbstractItemView, QListView, QStyledItemDelegate, QStyleOptionViewItem

from tactile_widgets.common.panel import SLIM_SCROLL_BAR

ModelIndex = QModelIndex | QPersistentModelIndex
NOWHERE = QModelIndex()

A = TypeVar("A", bound=QAbstractItemView)
V = TypeVar("V", bound=QListView)


def flat_list(view: A, name: str, accessible_name: str) -> A:
    """Give a list or tree the look of the panels: no frame, no horizontal scroll bar, a slim vertical one."""
    view.setObjectName(name)
    view.setAccessibleName(accessible_name)
    view.setFrameShape(QAbstractItemView.Shape.NoFrame)
    view.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    view.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
    return view


def read_only_list(view: V, name: str, accessible_name: str) -> V:
    """Give a list the look of the panels, with rows of equal height that can be clicked but not selected or edited."""
    view.setUniformItemSizes(True)
    view.setSelectionMode(QListView.SelectionMode.NoSelection)
    view.setEditTriggers(QListView.EditTrigger.NoEditTriggers)
    return flat_list(view, name, accessible_name)


class SequenceModel(QAbstractListModel):
    """Model with one row per item of a sequence, which is read lazily."""

    items: Sequence[Any] = ()

    def show_items(self, items: Sequence[Any]) -> None:
        """List other items."""
        self.beginResetModel()
        self.items = items
        self.endResetModel()

    def rowCount(self, parent: ModelIndex = NOWHERE) -> int:
        return 0 if parent.isValid() else len(self.items)

    def data(self, index: ModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        return self.value(index.row(), role) if index.isValid() else None

    @abstractmethod
    def value(self, row: int, role: int) -> object:
        """Return the data of a row for an item role; None if there is none."""


class RowDelegate(QStyledItemDelegate):
    """Delegate with rows of fixed height; subclasses implement ``draw``.

    Args:
        height: Height of a row [px].
        parent: Qt parent.
    """

    def __init__(self, height: int, parent: QObject) -> None:
        super().__init__(parent)
        self._size = QSize(120, height)

    def sizeHint(self, _option: QStyleOptionViewItem, _index: ModelIndex) -> QSize:
        return self._size

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        painter.save()
        self.draw(painter, option, index)
        painter.restore()

    @abstractmethod
    def draw(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        """Draw a row; the painter is restored afterwards."""
