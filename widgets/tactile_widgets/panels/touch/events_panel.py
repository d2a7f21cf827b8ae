"""The log of contact events: what touch meant, in words, the newest on top."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from PySide6.QtCore import QAbstractListModel, QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt, Signal
from PySide6.QtGui import QFont, QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QListView, QStyledItemDelegate, QStyleOptionViewItem, QWidget

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel

ROW = 18
_TEXT_PX = 11
_MAX_ROWS = 8
_EMPTY = "Touches, presses, strokes and grasps are listed here: press the skin in a view."
_ONGOING = int(Qt.ItemDataRole.UserRole)
_TIME = _ONGOING + 1
_BEGAN = _ONGOING + 2
_LASTING = ("press", "stroke", "grasp", "self-touch")
_NOWHERE = QModelIndex()


class EventLine(NamedTuple):
    """One line of the log.

    Attributes:
        time: In words.
        text: What happened.
        ongoing: Whether it still goes on.
        began: When it began [s].
    """

    time: str
    text: str
    ongoing: bool
    began: float


def event_lines(recent: Sequence[ContactEvent]) -> list[EventLine]:
    """A line for each event, newest first; what has ended is told once, with its force and duration."""
    lines = []
    ended = set()
    for event in recent:
        key = event.kind, event.contacts
        if event.phase == "ended":
            ended.add(key)
        elif event.kind in _LASTING and key in ended:
            ended.discard(key)
            continue
        ongoing = event.phase == "began" and event.kind in _LASTING
        text = event.words[:1].upper() + event.words[1:]
        lines.append(EventLine(f"{event.time:.1f}\u202fs", text, ongoing, event.time - _lasted(event)))
    return lines


def _lasted(event: ContactEvent) -> float:
    """How long before it was noticed it began [s]."""
    return event.duration if event.phase == "ended" else 0.0


class EventListModel(QAbstractListModel):
    """One row a line, newest first."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._recent: tuple[ContactEvent, ...] = ()
        self._lines: list[EventLine] = []

    def show(self, recent: tuple[ContactEvent, ...]) -> bool:
        """List these; whether that changed anything."""
        if recent is self._recent or recent == self._recent:
            return False
        self.beginResetModel()
        self._recent = recent
        self._lines = event_lines(recent)
        self.endResetModel()
        return True

    def rowCount(self, parent: QModelIndex | QPersistentModelIndex = _NOWHERE) -> int:
        """Qt."""
        return 0 if parent.isValid() else len(self._lines)

    def data(self, index: QModelIndex | QPersistentModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Qt."""
        if not index.isValid():
            return None
        line = self._lines[index.row()]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return line.text
            case Qt.ItemDataRole.AccessibleTextRole | Qt.ItemDataRole.ToolTipRole:
                return f"{line.text}, {'since' if line.ongoing else 'at'} {line.time}"
        return {_ONGOING: line.ongoing, _TIME: line.time, _BEGAN: line.began}.get(role)


class _EventDelegate(QStyledItemDelegate):
    """Time in a quiet column of its own; a mark beside what goes on."""

    def sizeHint(self, _option: QStyleOptionViewItem, _index: QModelIndex | QPersistentModelIndex) -> QSize:
        """Qt."""
        return QSize(120, ROW)

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        """Qt."""
        painter.save()
        rect = option.rect
        role = QPalette.ColorRole
        font = QFont(option.font)
        font.setPixelSize(_TEXT_PX)
        painter.setFont(font)
        metrics = painter.fontMetrics()
        if index.data(_ONGOING):
            painter.fillRect(QRect(rect.left(), rect.top() + 3, 3, rect.height() - 6), option.palette.color(role.Link))
        centred = Qt.AlignmentFlag.AlignVCenter
        time = QRect(rect.left() + 4, rect.top(), metrics.horizontalAdvance("000.0\u202fs"), rect.height())
        painter.setPen(option.palette.color(role.PlaceholderText))
        painter.drawText(time, Qt.AlignmentFlag.AlignRight | centred, str(index.data(_TIME)))
        words = QRect(time.right() + 8, rect.top(), rect.right() - time.right() - 8, rect.height())
        painter.setPen(option.palette.color(role.Text))
        text = metrics.elidedText(str(index.data()), Qt.TextElideMode.ElideRight, words.width())
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | centred, text)
        painter.restore()


class EventsPanel(Panel):
    """Shows a frame's recent events, so it is right live, in replay and wherever a user drags the timeline."""

    event_clicked = Signal(float)
    """An event that began at this time [s] was clicked."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contact events", "events-panel", parent)
        self._note = self.caption(_EMPTY)
        self._note.setFixedHeight(ROW * _MAX_ROWS)  # as the list: what is below stands still
        self._note.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.list, self.events = QListView(self), EventListModel(self)
        self.list.setObjectName("events-list")
        self.list.setAccessibleName("Contact events, the newest first")
        self.list.setFrameShape(QListView.Shape.NoFrame)
        self.list.setUniformItemSizes(True)
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.list.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
        self.list.setModel(self.events)
        self.list.setItemDelegate(_EventDelegate(self.list))
        self.list.setFixedHeight(ROW * _MAX_ROWS)
        self.list.setToolTip("In a recording, a click on an event goes there")
        self.list.clicked.connect(self._on_clicked)
        self.column.addWidget(self.list)
        self.clear()

    def clear(self) -> None:
        """Nothing has happened."""
        self._show(())

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene: what was shown is over."""
        self.clear()

    def show_frame(self, frame: Frame) -> None:
        """What has happened up to a frame."""
        self._show(frame.recent)

    def _on_clicked(self, index: QModelIndex) -> None:
        self.event_clicked.emit(float(index.data(_BEGAN)))

    def _show(self, recent: tuple[ContactEvent, ...]) -> None:
        bar = self.list.verticalScrollBar()
        resting = bar.value() == bar.minimum()
        if self.events.show(recent) and resting:
            self.list.scrollToTop()
        self._note.setVisible(not recent)
        self.list.setVisible(bool(recent))
