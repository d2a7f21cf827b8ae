"""The line that says why the controller is limited: a shape, the words for it, and what only just ended."""

from __future__ import annotations

from enum import Enum
from html import escape

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QWidget

from widgets.colours import DARK
from widgets.panels.limit_memory import Limit

_SIZE = 14
_LINES = 2
"""Room that is kept, so that nothing below moves when limits come and go."""


class State(Enum):
    """How free the controller is."""

    FREE = "Not limited"
    ENDED = "Was limited"
    LIMITED = "Limited"
    STOPPED = "Stopped"


class WhyLine(QWidget):
    """Shows limits as ``LimitMemory.told`` has them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("why-limited")
        self._sign, self._words = _Sign(self), QLabel(self)
        self._words.setWordWrap(True)
        self._words.setTextFormat(Qt.TextFormat.RichText)
        self._words.setAlignment(Qt.AlignmentFlag.AlignTop)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self._sign, 0, Qt.AlignmentFlag.AlignTop)
        row.addWidget(self._words, 1)
        self._words.setMinimumHeight(_LINES * (self._words.fontMetrics().lineSpacing() + 1))
        self.show_limits(())

    @property
    def state(self) -> State:
        """How free the controller is."""
        return self._sign.state

    @property
    def words(self) -> str:
        """All that is said, as plain text."""
        return self.accessibleName()

    def show_limits(self, limits: tuple[Limit, ...]) -> None:
        """Say these."""
        now = [limit.words for limit in limits if limit.active]
        ended = [limit.words for limit in limits if not limit.active]
        self._say(_state(now, ended), now, ended)

    def say_no_joints(self) -> None:
        """There is nothing to limit."""
        self._say(State.FREE, [], [], head="This robot has no joints to move")

    def _say(self, state: State, now: list[str], ended: list[str], *, head: str = "") -> None:
        stopped = state is State.STOPPED
        head = head or ("" if stopped else state.value + (": " if now or ended else ""))
        told = [escape(words[:1].upper() + words[1:] if stopped else words) for words in now]
        quiet = self.palette().color(QPalette.ColorRole.PlaceholderText).name()
        faded = [f'<span style="color:{quiet}">{escape(words)}</span>' for words in ended]
        rich = f"{head}{'; '.join(told + faded)}"
        if rich != self._words.text():
            self._words.setText(rich)
            self.setAccessibleName(f"{head}{'; '.join([*now, *ended])}")
        self._sign.set_state(state)


class _Sign(QWidget):
    """A ring while free, a triangle while limited (hollow where it only was), a square when stopped."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.state = State.FREE
        self.setFixedSize(_SIZE, _SIZE + 4)

    def set_state(self, state: State) -> None:
        if state is not self.state:
            self.state = state
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(1.5, 3.5, _SIZE - 3, _SIZE - 3)
        colour = {
            State.FREE: self.palette().color(QPalette.ColorRole.PlaceholderText),
            State.STOPPED: QColor(DARK.fault),
        }.get(self.state, QColor(DARK.warning))
        painter.setPen(QPen(colour, 1.6))
        painter.setBrush(colour if self.state in (State.LIMITED, State.STOPPED) else Qt.BrushStyle.NoBrush)
        if self.state is State.FREE:
            painter.drawEllipse(box.adjusted(1, 1, -1, -1))
        elif self.state is State.STOPPED:
            painter.drawRect(box)
        else:
            painter.drawPolygon(QPolygonF([box.bottomLeft(), QPointF(box.center().x(), box.top()), box.bottomRight()]))


def _state(now: list[str], ended: list[str]) -> State:
    if any(words.startswith("stopped") for words in now):
        return State.STOPPED
    return State.LIMITED if now else State.ENDED if ended else State.FREE
