"""Lists of notes that wrap and can be selected and copied: findings from opening a scene, and the message log."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

from PySide6.QtCore import QEvent, QModelIndex, QPersistentModelIndex, QPointF, QRect, QSize, Qt, QTime
from PySide6.QtGui import (
    QFont,
    QFontMetrics,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPalette,
    QResizeEvent,
    QTextLayout,
    QTextOption,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from tactile_maps.core.errors import Finding
from tactile_maps.session.prepare import PreparedScene, findings_of
from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel

_HEIGHT = 120
_NO_FINDINGS = "What opening a robot, skin or scene noticed or repaired is listed here."
_FAULTS = ("missing-mesh", "scene-warning")
"""Kinds after which what is shown is not what was meant."""
_MOST = 200
_NO_MESSAGES = "Messages and errors are listed here; Ctrl+C copies them."
_TEXT_PX = 11
_MARGIN = 4
_NOTE = int(Qt.ItemDataRole.UserRole)
_LINE_SEPARATOR = "\u2028"
"""What Qt's layouts take for the end of a line."""


class Note(NamedTuple):
    """What is said.

    Attributes:
        head: What it is about, in a few words.
        text: The rest.
        fault: Whether something is wrong.
    """

    head: str
    text: str
    fault: bool = False

    @property
    def words(self) -> str:
        """Head and text, as they are copied."""
        return f"{self.head}: {self.text}"


class _NoteDelegate(QStyledItemDelegate):
    """The head quiet, the text below it, a mark in the colour of faults beside what is wrong."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        """Qt: as high as its text wraps."""
        view = self.parent()
        assert isinstance(view, QListWidget)
        width = view.viewport().width()
        font = _small(option.font)
        text = _wrapped(index.data(_NOTE).text, font, _text_width(width))
        height = QFontMetrics(font).lineSpacing() + text.boundingRect().height() + 2 * _MARGIN
        return QSize(width, ceil(height))

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        """Qt."""
        note = index.data(_NOTE)
        rect = option.rect
        role = QPalette.ColorRole
        painter.save()
        painter.setFont(_small(option.font))
        metrics = painter.fontMetrics()
        if option.state & QStyle.StateFlag.State_Selected:
            accent = option.palette.color(role.Link)
            accent.setAlphaF(0.2)
            painter.fillRect(rect, accent)
        if note.fault:
            mark = QRect(rect.left(), rect.top() + _MARGIN, 3, rect.height() - 2 * _MARGIN)
            painter.fillRect(mark, option.palette.color(role.BrightText))
        inner = QRect(rect.left() + 2 * _MARGIN, rect.top() + _MARGIN, _text_width(rect.width()), rect.height())
        painter.setPen(option.palette.color(role.PlaceholderText))
        head = metrics.elidedText(note.head, Qt.TextElideMode.ElideMiddle, inner.width())
        painter.drawText(inner, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop, head)
        painter.setPen(option.palette.color(role.Text))
        below = QPointF(inner.left(), inner.top() + metrics.lineSpacing())
        _wrapped(note.text, painter.font(), inner.width()).draw(painter, below)
        painter.restore()


def _small(font: QFont) -> QFont:
    made = QFont(font)
    made.setPixelSize(_TEXT_PX)
    return made


def _wrapped(text: str, font: QFont, width: int) -> QTextLayout:
    """Lines that break between words, within one only where it is longer than a line: paths are."""
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
    """Shows notes, of a fixed height, so that what is below stands still; Ctrl+C copies those selected, or all.

    Args:
        name: Of the object.
        empty: What is said where there is none.
        height: Of the list [px].
        parent: Qt parent.
    """

    def __init__(self, name: str, empty: str, height: int, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._empty = empty
        self.setObjectName(name)
        self.setFrameShape(QListWidget.Shape.NoFrame)
        self.setFixedHeight(height)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
        self.setItemDelegate(_NoteDelegate(self))
        self.show_notes(())

    @property
    def notes(self) -> tuple[Note, ...]:
        """Those listed, from the top."""
        return tuple(found for row in range(self.count()) if (found := self.item(row).data(_NOTE)) is not None)

    def show_notes(self, notes: Sequence[Note]) -> None:
        """List these, and no others."""
        self.clear()
        for note in notes:
            self._put(self.count(), note)

    def put_first(self, note: Note, *, most: int) -> None:
        """List one more above the others, of which the last go where there are more than ``most``."""
        self._put(0, note)
        while self.count() > most:
            self.takeItem(self.count() - 1)

    def _put(self, row: int, note: Note) -> None:
        item = QListWidgetItem()
        item.setData(_NOTE, note)
        item.setData(Qt.ItemDataRole.AccessibleTextRole, note.words)
        item.setToolTip(note.words)
        self.insertItem(row, item)

    def copy(self) -> None:
        """Put what is selected on the clipboard, one note a line; all where nothing is."""
        rows = sorted(index.row() for index in self.selectedIndexes()) or range(self.count())
        QGuiApplication.clipboard().setText("\n".join(self.notes[row].words for row in rows))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt."""
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: other widths wrap otherwise."""
        super().resizeEvent(event)
        self.scheduleDelayedItemsLayout()

    def viewportEvent(self, event: QEvent) -> bool:
        """Qt: say what would be here, where nothing is."""
        done = super().viewportEvent(event)
        if event.type() == QEvent.Type.Paint and not self.count():
            painter = QPainter(self.viewport())
            painter.setFont(_small(self.font()))
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            inner = self.viewport().rect().adjusted(2 * _MARGIN, _MARGIN, -2 * _MARGIN, -_MARGIN)
            _wrapped(self._empty, painter.font(), inner.width()).draw(painter, QPointF(inner.topLeft()))
            painter.end()
        return done


def note_of(finding: Finding) -> Note:
    """``Missing mesh, link_3.stl: a small box stands in``."""
    kind = finding.kind.replace("-", " ").replace("_", " ")
    times = f"{finding.count} × " if finding.count > 1 else ""
    head = f"{times}{kind}, {finding.where}" if finding.where else f"{times}{kind}"
    action = f"{finding.action[:1].upper()}{finding.action[1:]}"
    return Note(f"{head[:1].upper()}{head[1:]}", action, fault=finding.kind in _FAULTS)


class FindingsPanel(Panel):
    """Lists them; its heading says how many there are."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Findings", "findings-panel", parent)
        self.list = NoteList("findings-list", _NO_FINDINGS, _HEIGHT, self)
        self.list.setAccessibleName("Findings")
        self.column.addWidget(self.list)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene."""
        found = findings_of(prepared)
        self.list.show_notes([note_of(finding) for finding in found])
        self.set_heading(f"Findings, {len(found)}" if found else "Findings")


class MessagesPanel(Panel):
    """Lists them, the newest on top."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Messages", "messages-panel", parent)
        self.list = NoteList("messages-list", _NO_MESSAGES, _HEIGHT, self)
        self.list.setAccessibleName("Messages, the newest first")
        self.column.addWidget(self.list)

    def add(self, text: str, fault: bool) -> None:
        """The window said ``text`` now; ``fault`` where something failed."""
        kind = "Error" if fault else "Message"
        self.list.put_first(Note(f"{kind}, {QTime.currentTime().toString('HH:mm:ss')}", text, fault), most=_MOST)
