"""Time spans of limits and events: a row per kind over the time axis of the plots, with a bar per span.

``LimitStrip`` shows when each limit bounded the controller, ``EventStrip`` when contact events occurred. A click on a
bar emits its beginning.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from itertools import accumulate
from typing import ClassVar, Generic, NamedTuple, TypeVar

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.control.motion.limits import Severity
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.make import column_layout, small_font
from tactile_widgets.plots.traces.history import EventHistory, LimitHistory
from tactile_widgets.plots.traces.trace_plots import (
    AXIS_END,
    AXIS_HEIGHT,
    AXIS_START,
    PLOT_SECONDS,
    TIME_TICKS,
    PlotSeries,
)

_ROW = 21.0
"""Height of a row with a name of one line [px]."""
_LINE = 13.0
"""Height of a further line of the name [px]."""
_BAR = 4.0
_THINNEST = 2.0
_NEAR = 8.0
"""Maximum distance from a bar at which a click selects it [px]."""


class SpanRow(NamedTuple):
    """Row with the spans of one kind.

    Attributes:
        name: Name shown to the user.
        spans: Start and end as ages [s]: 0 for now and negative before; a span that is still active ends at 0.
        severity: Consequence, shown by the colour; None for events.
    """

    name: str
    spans: tuple[tuple[float, float], ...]
    severity: Severity | None = None

    @property
    def current(self) -> bool:
        """Whether the last span is still active."""
        return self.spans[-1][1] >= 0


def severity_colour(severity: Severity | None, theme: Theme) -> str:
    """Return the colour of a limit: grey if the goal is still reached, amber if not, red after a stop."""
    colours = {Severity.ADAPTED: theme.quiet, Severity.UNMET: theme.warning, Severity.STOPPED: theme.fault}
    return theme.accent if severity is None else colours[severity]


M = TypeVar("M")


class SpanStrip(QWidget, Generic[M]):
    """Widget with heading, rows and axis. Mutable: ``draw`` of the subclasses.

    Args:
        memory: The history.
        marks: Returns the ages of changed settings [s].
        theme: Colours.
        parent: Qt parent.
        only: Kinds that are shown; None for all.
    """

    name: ClassVar[str]
    clicked = Signal(float)
    """A bar that began at this age [s] was clicked."""

    def __init__(
        self,
        memory: M,
        marks: Callable[[], Sequence[float]],
        theme: Theme,
        parent: QWidget,
        *,
        only: Collection[str] | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName(self.name)
        self._memory = memory
        self._marks = marks
        self._only = only
        caption = small_font(self.font())
        self._heading, self._rows = QLabel(self), _Rows(theme, caption, self)
        self._heading.setFont(caption)
        self._heading.setWordWrap(True)
        column_layout(self._heading, self._rows, parent=self, spacing=4, stretch=self._rows)
        self.set_theme(theme)

    @property
    def heading(self) -> str:
        """Text of the heading."""
        return self._heading.text()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._heading.setStyleSheet(f"color: {theme.quiet}")
        self._rows.theme = theme
        self._rows.update()

    @property
    def rows(self) -> list[SpanRow]:
        """Stored rows of the shown kinds."""
        raise NotImplementedError

    def series(self) -> list[PlotSeries]:
        """Return a series per row: 1 from the beginning to the end of each span."""
        return [PlotSeries.of_spans(row.name, row.spans) for row in self.rows]

    def _is_shown(self, kind: str) -> bool:
        return self._only is None or kind in self._only

    def _show(self, title: str, rows: Sequence[SpanRow], active: int) -> None:
        """Show these rows, ``active`` of which are active now, and marks of changed settings."""
        words = title if rows else f"{title}: none in the last {PLOT_SECONDS:g}\u202fs"
        self._heading.setText(f"{words}, {active} now" if active else words)
        names = ", ".join(row.name for row in rows)
        self.setAccessibleName(f"{title} in the last {PLOT_SECONDS:g} seconds: {names or 'none'}")
        self.setToolTip("\n".join(row.name.capitalize() for row in rows))
        self._rows.show_rows(tuple(rows), self._marks())

    def click(self, place: QPointF) -> None:
        """Emit ``clicked`` if there is a bar at a position of this widget."""
        began = self._rows.began_at(QPointF(self._rows.mapFrom(self, place.toPoint())))
        if began is not None:
            self.clicked.emit(began)


class _Rows(QWidget):
    """Rows with a name above their bars; rows that do not fit are counted."""

    def __init__(self, theme: Theme, caption: QFont, parent: QWidget) -> None:
        super().__init__(parent)
        self.theme = theme
        self._caption = caption
        self._shown: tuple[SpanRow, ...] = ()
        self._marks: tuple[float, ...] = ()

    def show_rows(self, rows: tuple[SpanRow, ...], marks: Sequence[float]) -> None:
        """Draw these rows, with marks at these ages [s]."""
        self._shown = rows
        self._marks = tuple(marks)
        self.update()

    def began_at(self, place: QPointF) -> float | None:
        """Return the age [s] at which the bar at a position began; None without a bar there."""
        row = next((row for row, top, lines in self._placed() if top <= place.y() < top + _height(lines)), None)
        if row is None:
            return None
        near = [(self._away(place.x(), span), span[0]) for span in row.spans]
        away, began = min(near, default=(_NEAR + 1, 0.0))
        return began if away <= _NEAR else None

    def _away(self, x: float, span: tuple[float, float]) -> float:
        return max(self._x(span[0]) - x, x - self._x(span[1]), 0.0)

    def _with_room(self) -> tuple[SpanRow, ...]:
        """Return the rows that fit, in their order; if not all do, current ones come before those that ended."""
        room = max(int((self.height() - AXIS_HEIGHT) // _ROW), 1)
        if len(self._shown) <= room:
            return self._shown
        current_first = sorted(range(len(self._shown)), key=lambda number: not self._shown[number].current)
        return tuple(self._shown[number] for number in sorted(current_first[: room - 1]))

    def _placed(self) -> list[tuple[SpanRow, float, list[str]]]:
        """Return the rows that fit with their top and the lines of their names, which are elided without room."""
        rows = self._with_room()
        lines = [self._wrapped(row.name) for row in rows]
        if len(rows) < len(self._shown) or sum(map(_height, lines)) > self.height() - AXIS_HEIGHT:
            lines = [[row.name] for row in rows]
        tops = accumulate(map(_height, lines), initial=0.0)
        return list(zip(rows, tops, lines, strict=False))

    def _wrapped(self, name: str) -> list[str]:
        metrics = QFontMetricsF(self._caption)
        first, *rest = name.split(" ")
        lines = [first]
        for word in rest:
            longer = f"{lines[-1]} {word}"
            if metrics.horizontalAdvance(longer) <= self.width() - 4:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setFont(self._caption)
        floor = self.height() - AXIS_HEIGHT
        painter.setPen(QPen(QColor(self.theme.line), 1))
        painter.drawLine(QPointF(0, floor), QPointF(self.width(), floor))
        self._draw_times(painter, floor)
        painter.setPen(QPen(QColor(self.theme.quiet), 1, Qt.PenStyle.DotLine))
        for age in self._marks:
            painter.drawLine(QPointF(self._x(age), 0), QPointF(self._x(age), floor))
        shown = self._placed()
        for row, top, lines in shown:
            self._draw_row(painter, top, row, lines)
        if len(shown) < len(self._shown):
            painter.setPen(QColor(self.theme.quiet))
            painter.drawText(QPointF(2, len(shown) * _ROW + 12), f"and {len(self._shown) - len(shown)} more")

    def _draw_row(self, painter: QPainter, top: float, row: SpanRow, lines: Sequence[str]) -> None:
        painter.setPen(QColor(self.theme.text if row.current else self.theme.quiet))
        metrics = QFontMetricsF(self._caption)
        for number, line in enumerate(lines):
            words = metrics.elidedText(line, Qt.TextElideMode.ElideRight, self.width() - 4)
            painter.drawText(QPointF(2, top + 12 + number * _LINE), words)
        top += _height(lines) - _ROW
        painter.fillRect(QRectF(0, top + 15, self.width(), _BAR), QColor(mixed(self.theme.panel, self.theme.line, 0.5)))
        ink = QColor(severity_colour(row.severity, self.theme))
        for start, end in row.spans:
            left = self._x(start)
            width = max(self._x(end) - left, _THINNEST)
            painter.fillRect(QRectF(left, top + 15, width, _BAR), ink)

    def _draw_times(self, painter: QPainter, floor: float) -> None:
        painter.setPen(QColor(self.theme.quiet))
        for age, words in TIME_TICKS:
            wide = QFontMetricsF(self._caption).horizontalAdvance(words)
            left = min(max(self._x(age) - wide / 2, 0.0), self.width() - wide)
            painter.drawText(QPointF(left, floor + 14), words)

    def _x(self, age: float) -> float:
        """Return the x of an age [s]: now is near the right edge, as in the plots."""
        return self.width() * (age - AXIS_START) / (AXIS_END - AXIS_START)


def _height(lines: Sequence[str]) -> float:
    """Return the height of a row with a name of these lines [px]."""
    return _ROW + (len(lines) - 1) * _LINE


class LimitStrip(SpanStrip[LimitHistory]):
    """Strip with the limits that bounded the controller; ``only`` contains values of their kinds."""

    name = "limit-strip"

    def draw(self) -> None:
        """Draw the stored spans."""
        active = sum(limit.active and self._is_shown(limit.limit.kind.value) for limit in self._memory.recent)
        self._show("Limits", self.rows, active)

    @property
    def rows(self) -> list[SpanRow]:
        """Limits by name."""
        rows = self._memory.rows
        return [SpanRow(kind.title, spans, kind.severity) for kind, spans in rows if self._is_shown(kind.value)]


class EventStrip(SpanStrip[EventHistory]):
    """Strip with the contact events."""

    name = "event-strip"

    def draw(self) -> None:
        """Draw the stored spans."""
        rows = self.rows
        active = sum(end >= 0 and start < end for row in rows for start, end in row.spans)
        self._show("Contact events", rows, active)

    @property
    def rows(self) -> list[SpanRow]:
        """Events by kind."""
        return [SpanRow(kind, spans) for kind, spans in self._memory.rows if self._is_shown(kind)]
