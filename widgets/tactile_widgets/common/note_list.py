"""List of notes that wrap and can be selected and copied, such as findings and messages."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

from PySide6.QtCore import QEvent, QPointF, QRect, QSize, Qt
from PySide6.QtGui import (
    QFont,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPalette,
    QResizeEvent,
    QTextLayout,
    QTextOption,
)
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QStyle, QStyleOptionViewItem, QWidget

from tactile_widgets.common.lists import ModelIndex, RowDelegate, flat_list
from tactile_widgets.common.make import small_font

_HEIGHT = 120
_MARGIN = 4
_NOTE = int(Qt.ItemDataRole.UserRole)
_LINE_SEPARATOR = "\u2028"
"""End of a line in Qt's text layouts."""


class Note(NamedTuple):
    """An entry of a list.

    Attributes:
        head: Subject, in a few words.
        text: The message.
        fault: Whether something is wrong.
    """

    head: str
    text: str
    fault: bool = False

    @property
    def words(self) -> str:
        """Head and text in the form in which they are copied."""
        return f"{self.head}: {self.text}"


class _NoteDelegate(RowDelegate):
    """Draws the head in a quiet colour, the text below it, and a coloured mark at the left of a fault."""

    def sizeHint(self, option: QStyleOptionViewItem, index: ModelIndex) -> QSize:
        view = self.parent()
        assert isinstance(view, QListWidget)
        width = view.viewport().width()
        font = small_font(option.font)
        note = index.data(_NOTE)
        parts = [_wrapped(part, font, _text_width(width)) for part in (note.head, note.text)]
        return QSize(width, ceil(sum(part.boundingRect().height() for part in parts) + 2 * _MARGIN))

    def draw(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        note = index.data(_NOTE)
        rect = option.rect
        role = QPalette.ColorRole
        painter.setFont(small_font(option.font))
        if option.state & QStyle.StateFlag.State_Selected:
            accent = option.palette.color(role.Link)
            accent.setAlphaF(0.2)
            painter.fillRect(rect, accent)
        if note.fault:
            mark = QRect(rect.left(), rect.top() + _MARGIN, 3, rect.height() - 2 * _MARGIN)
            painter.fillRect(mark, option.palette.color(role.BrightText))
        below = QPointF(rect.left() + 2 * _MARGIN, rect.top() + _MARGIN)
        for part, ink in ((note.head, role.PlaceholderText), (note.text, role.Text)):
            painter.setPen(option.palette.color(ink))
            lines = _wrapped(part, painter.font(), _text_width(rect.width()))
            lines.draw(painter, below)
            below.setY(below.y() + lines.boundingRect().height())


def _wrapped(text: str, font: QFont, width: int) -> QTextLayout:
    """Break a text into lines between words, and within a word, such as a path, that is longer than a line."""
    layout = QTextLayout(text.replace("\n", _LINE_SEPARATOR), font)
    option = QTextOption()
    option.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
    layout.setTextOption(option)
    layout.beginLayout()
    bottom = 0.0
    while (line := layout.createLine()).isValid():
        line.setLineWidth(width)
        line.setPosition(QPointF(0.0, bottom))
        bottom += line.height()
    layout.endLayout()
    return layout


def _text_width(width: int) -> int:
    return max(width - 4 * _MARGIN, 40)


class NoteList(QListWidget):
    """A list of notes of fixed height, so that nothing below it moves; Ctrl+C copies the selected notes, or all.

    Args:
        name: Object name.
        accessible_name: Name for assistive technology.
        empty: Text of an empty list.
        parent: Qt parent.
    """

    def __init__(self, name: str, accessible_name: str, empty: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._empty = empty
        flat_list(self, name, accessible_name)
        self.setFixedHeight(_HEIGHT)
        self.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
        self.setVerticalScrollMode(QListWidget.ScrollMode.ScrollPerPixel)
        self.setItemDelegate(_NoteDelegate(0, self))

    @property
    def notes(self) -> tuple[Note, ...]:
        """The notes from the top."""
        return tuple(found for row in range(self.count()) if (found := self.item(row).data(_NOTE)) is not None)

    def show_notes(self, notes: Sequence[Note]) -> None:
        """List these notes only."""
        self.clear()
        for note in notes:
            self._insert(self.count(), note)

    def show_all(self) -> None:
        """Make the list as high as its notes, at least as high as the text of an empty list, so that it never scrolls.

        For notes that change only with the scene: what is below moves.
        """
        self.doItemsLayout()
        notes = sum(max(self.sizeHintForRow(row), 0) for row in range(self.count()))
        empty = _wrapped(self._empty, small_font(self.font()), _text_width(self.viewport().width()))
        self.setFixedHeight(max(notes, ceil(empty.boundingRect().height()) + 2 * _MARGIN) + 2 * self.frameWidth())

    def put_first(self, note: Note, *, most: int) -> None:
        """Insert a note at the top, and remove the last ones beyond ``most``."""
        self._insert(0, note)
        while self.count() > most:
            self.takeItem(self.count() - 1)

    def _insert(self, row: int, note: Note) -> None:
        item = QListWidgetItem()
        item.setData(_NOTE, note)
        item.setData(Qt.ItemDataRole.AccessibleTextRole, note.words)
        item.setToolTip(note.words)
        self.insertItem(row, item)

    def copy(self) -> None:
        """Copy the selected notes to the clipboard, one per line; all of them if none is selected."""
        rows = sorted(index.row() for index in self.selectedIndexes()) or range(self.count())
        QGuiApplication.clipboard().setText("\n".join(self.notes[row].words for row in rows))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Lay the rows out again: another width wraps the texts differently."""
        super().resizeEvent(event)
        self.scheduleDelayedItemsLayout()

    def viewportEvent(self, event: QEvent) -> bool:
        """Draw the text of an empty list."""
        done = super().viewportEvent(event)
        if event.type() == QEvent.Type.Paint and not self.count():
            painter = QPainter(self.viewport())
            painter.setFont(small_font(self.font()))
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            inner = self.viewport().rect().adjusted(2 * _MARGIN, _MARGIN, -2 * _MARGIN, 0)
            _wrapped(self._empty, painter.font(), inner.width()).draw(painter, QPointF(inner.topLeft()))
            painter.end()
        return done
