"""Metrics of all contenders: one row per metric, one column per contender, the best value in bold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QFont, QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QFrame, QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from tactile_maps.studies.controller_comparison import ControllerMetrics, ControllerTrace, controller_metrics
from tactile_widgets.common.panel import SLIM_SCROLL_BAR

NONE = "—"
_FLAT = """
    QTableWidget, QTableCornerButton::section { background: transparent; border: 0; }
    QHeaderView { background: transparent; }
    QHeaderView::section { background: transparent; border: 0; padding: 2px 4px; }
"""
_ROW = 22
_PAD = 14
"""Height of a row of one line, and space next to the text of a cell [px]."""
_LEAST_TITLES = 150
_TITLE_PAD = 8
"""Width that the titles of the rows keep, and its part next to their texts [px]."""
_NEARLY = 1e-3
"""Relative difference below which values are equally good."""


class Row(NamedTuple):
    """A metric: its name in ``ControllerMetrics``, title, unit, displayed units per unit, whether less is better."""

    name: str
    words: str
    unit: str
    scale: float = 1.0
    better: bool = True


ROWS = (
    Row("map_rms_mm", "Position error on the map, rms", "mm"),
    Row("map_p95_mm", "Position error on the map, p95", "mm"),
    Row("body_rms_mm", "Position error on the body, rms", "mm"),
    Row("body_p95_mm", "Position error on the body, p95", "mm"),
    Row("force_rms_N", "Force error, rms", "N"),
    Row("force_std_N", "Force ripple, std", "N"),
    Row("force_max_N", "Max force", "N"),
    Row("lost", "Contact lost", "%", 100.0),
    Row("limited", "Limited", "%", 100.0),
    Row("limit", "Limited most by", ""),
    Row("joint_speed_max", "Max joint speed", "rad/s"),
    Row("energy_J", "Max net energy output", "J", 1.0, better=False),
    Row("control_ms", "Controller time, median", "ms"),
    Row("control_p95_ms", "Controller time, p95", "ms"),
)


class MetricsTable(QTableWidget):
    """Metrics of traces."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(len(ROWS), 0, parent)
        self._preferred = 0
        self.setObjectName("controller-figures")
        self.setAccessibleName("Metrics")
        self._name_rows("rad/s")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.setShowGrid(False)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setStyleSheet(_FLAT)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)  # the minimum width shows all
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
        self.verticalHeader().setDefaultSectionSize(_ROW)
        wrapped = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextWordWrap
        self.verticalHeader().setDefaultAlignment(Qt.AlignmentFlag(int(wrapped)))
        wrapped = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap
        self.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag(int(wrapped)))
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)

    def show_traces(self, traces: Sequence[ControllerTrace], titles: Sequence[str]) -> None:
        """Measure and show traces."""
        figures = [controller_metrics(trace) for trace in traces]
        if figures:
            self._name_rows(figures[0].speed_unit)
        self.setColumnCount(len(traces))
        self.setHorizontalHeaderLabels(list(titles))
        for number, row in enumerate(ROWS):
            values = [_value(figure, row.name) for figure in figures]
            known = [None if isinstance(value, str) else value for value in values]
            best = _best(known) if row.better and row.unit else None
            for column, value in enumerate(values):
                self.setItem(number, column, _cell(row, value, bold=column == best))
        self._fit()

    def _fit(self) -> None:
        """Make columns at least as wide as their numbers and the longest words, and rows as high as their texts."""
        metrics = QFontMetrics(_bold())
        header = self.horizontalHeader()
        titles = self._titles()
        texts = [self.text(row.name, column) for row in ROWS for column in range(self.columnCount())]
        widest = max(
            (metrics.horizontalAdvance(word) for text in (*titles, *texts) for word in text.split()), default=0
        )
        header.setMinimumSectionSize(widest + _PAD)
        self._preferred = max((metrics.horizontalAdvance(title) for title in titles), default=0) + _PAD
        self.setMinimumWidth(_LEAST_TITLES + self._least_columns)
        self._fit_titles()
        self._fit_heights()
        self.updateGeometry()

    @property
    def _least_columns(self) -> int:
        """Width of the narrowest columns with the scroll bar next to them [px]."""
        columns = self.columnCount() * self.horizontalHeader().minimumSectionSize()
        return columns + self.verticalScrollBar().sizeHint().width() + 4

    def _fit_titles(self) -> None:
        """Make the titles of the rows as wide as the columns allow."""
        self.verticalHeader().setMaximumWidth(max(self.width() - self._least_columns, _LEAST_TITLES))

    def _titles(self) -> list[str]:
        items = (self.horizontalHeaderItem(column) for column in range(self.columnCount()))
        return [item.text() for item in items if item is not None]

    def _fit_heights(self) -> None:
        column = self.horizontalHeader().sectionSize(0) - _PAD if self.columnCount() else 1
        titles = self.verticalHeader()
        title = min(titles.maximumWidth(), titles.sizeHint().width()) - _TITLE_PAD
        bold = QFontMetrics(_bold())

        def height(text: str, width: int, metrics: QFontMetrics = bold) -> int:
            flags = int(Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignHCenter)
            return metrics.boundingRect(QRect(0, 0, max(width, 1), 1000), flags, text).height()

        self.horizontalHeader().setFixedHeight(max((height(text, column) for text in self._titles()), default=0) + 6)
        for number, row in enumerate(ROWS):
            values = [height(self.text(row.name, k), column) for k in range(self.columnCount())]
            item = self.verticalHeaderItem(number)
            words = height(item.text(), title, titles.fontMetrics()) if item is not None else 0
            self.setRowHeight(number, max(_ROW, words + 4, *(value + 4 for value in values)))

    def sizeHint(self) -> QSize:
        """Return the size in which every title has one line, and nothing is elided."""
        columns = self.columnCount() * max(self._preferred, self.horizontalHeader().minimumSectionSize())
        scroll = self.verticalScrollBar().sizeHint().width()
        return QSize(self.verticalHeader().sizeHint().width() + columns + scroll + 4, super().sizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._fit_titles()
        super().resizeEvent(event)
        self._fit_heights()

    def _name_rows(self, speed_unit: str) -> None:
        units = {row.name: row.unit for row in ROWS} | {"joint_speed_max": speed_unit}
        for number, row in enumerate(ROWS):
            item = QTableWidgetItem(f"{row.words} ({units[row.name]})" if units[row.name] else row.words)
            self.setVerticalHeaderItem(number, item)

    def text(self, name: str, column: int) -> str:
        """Return the text of a cell."""
        item = self.item([row.name for row in ROWS].index(name), column)
        return item.text() if item is not None else ""


def format_metric(row: Row, value: float | str | None) -> str:
    """Return a value with three significant digits, a text unchanged, and a dash for None."""
    if value is None:
        return NONE
    if isinstance(value, str):
        return value
    shown = row.scale * value
    return f"{shown:.{max(2 - math.floor(math.log10(abs(shown))), 0)}f}" if 1e-3 <= abs(shown) < 1e3 else f"{shown:.3g}"


def _value(figures: ControllerMetrics, name: str) -> float | str | None:
    if name == "limit":
        return None if figures.limit is None else figures.limit.title
    value: float | None = getattr(figures, name)
    return value


def _cell(row: Row, value: float | str | None, *, bold: bool) -> QTableWidgetItem:
    item = QTableWidgetItem(format_metric(row, value))
    item.setTextAlignment(Qt.AlignmentFlag.AlignCenter)
    if isinstance(value, str):
        item.setToolTip(value)
    item.setFont(_bold() if bold else QFont())
    return item


def _bold() -> QFont:
    font = QFont()
    font.setBold(True)
    return font


def _best(values: Sequence[float | None]) -> int | None:
    """Return the index of the least value; None if several are least."""
    known = sorted((value, number) for number, value in enumerate(values) if value is not None)
    if len(known) < 2 or known[1][0] - known[0][0] <= _NEARLY * abs(known[1][0]):
        return None
    return known[0][1]
