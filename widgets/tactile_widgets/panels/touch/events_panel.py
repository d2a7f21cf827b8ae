"""The log of contact events in words, the newest on top."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from PySide6.QtCore import QModelIndex, QRect, Qt, Signal
from PySide6.QtGui import QPainter, QPalette
from PySide6.QtWidgets import QListView, QStyleOptionViewItem, QWidget

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.lists import ModelIndex, RowDelegate, SequenceModel, read_only_list
from tactile_widgets.common.make import small_font
from tactile_widgets.common.panel import Panel
from tactile_widgets.common.sentence import capitalized

ROW = 18
_MAX_ROWS = 8
_EMPTY = "Touches, presses, strokes and grasps are listed here: press the skin in a view."
_ONGOING = int(Qt.ItemDataRole.UserRole)
_TIME = _ONGOING + 1
_BEGAN = _ONGOING + 2
_LASTING = ("press", "stroke", "grasp", "self-touch", "slip")


class EventLine(NamedTuple):
    """A line of the log.

    Attributes:
        time: Time of the event, as text.
        text: Description of the event.
        ongoing: Whether it continues.
        began: Time of its beginning [s].
    """

    time: str
    text: str
    ongoing: bool
    began: float


def event_lines(recent: Sequence[ContactEvent]) -> list[EventLine]:
    """Return a line for each event, newest first; an ended event has one line, with its force and duration."""
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
        lasted = event.duration if event.phase == "ended" else 0.0
        lines.append(EventLine(f"{event.time:.1f}\u202fs", capitalized(event.words), ongoing, event.time - lasted))
    return lines


class EventListModel(SequenceModel):
    """Item model of the log: one row per line, newest first."""

    recent: tuple[ContactEvent, ...] = ()

    def show(self, recent: tuple[ContactEvent, ...]) -> bool:
        """List these events; return whether that changed anything."""
        if recent == self.recent:
            return False
        self.recent = recent
        self.show_items(event_lines(recent))
        return True

    def value(self, row: int, role: int) -> object:
        line = self.items[row]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return line.text
            case Qt.ItemDataRole.AccessibleTextRole | Qt.ItemDataRole.ToolTipRole:
                return f"{line.text}, {'since' if line.ongoing else 'at'} {line.time}"
        return {_ONGOING: line.ongoing, _TIME: line.time, _BEGAN: line.began}.get(role)


class _EventDelegate(RowDelegate):
    """Draws the time in a quiet column, and a mark at the left of an ongoing event."""

    def draw(self, painter: QPainter, option: QStyleOptionViewItem, index: ModelIndex) -> None:
        rect = option.rect
        role = QPalette.ColorRole
        painter.setFont(small_font(option.font))
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


class EventsPanel(Panel):
    """Recent events of the frame shown, whether it is live, replayed, or chosen on the timeline."""

    event_clicked = Signal(float)
    """Time at which the clicked event began [s]."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Contact events", "events-panel", parent)
        self._note = self.caption(_EMPTY)
        self._note.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.list = read_only_list(QListView(self), "events-list", "Contact events, the newest first")
        self.events = EventListModel(self)
        self.list.setModel(self.events)
        self.list.setItemDelegate(_EventDelegate(ROW, self.list))
        self.list.setToolTip("In a recording, click an event to go to its time")
        self.list.clicked.connect(self._on_clicked)
        self.column.addWidget(self.list)
        for part in (self._note, self.list):
            part.setFixedHeight(ROW * _MAX_ROWS)  # equal heights: nothing below moves
        self.clear()

    def clear(self) -> None:
        """Remove all events."""
        self._show(())

    def show_prepared(self, prepared: PreparedScene) -> None:
        self.clear()

    def show_frame(self, frame: Frame) -> None:
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
