"""What all panels look like: a heading, content under it, space instead of frames."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSlider, QVBoxLayout, QWidget


class Panel(QWidget):
    """A heading and a column."""

    def __init__(self, heading: str, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setAccessibleName(heading)
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(12, 12, 12, 4)
        self.column.setSpacing(8)
        title = QLabel(heading, self)
        title.setProperty("role", "heading")
        self.column.addWidget(title)

    def caption(self, text: str = "") -> QLabel:
        """A quiet line of small text at the end of the column."""
        label = QLabel(text, self)
        label.setProperty("role", "caption")
        label.setWordWrap(True)
        self.column.addWidget(label)
        return label

    def grid(self) -> QGridLayout:
        """A grid for rows of facts at the end of the column."""
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(4)
        self.column.addLayout(grid)
        return grid


def fact(text: str, parent: QWidget, *, right: bool = False) -> QLabel:
    """A label for a changing fact."""
    label = QLabel(text, parent)
    side = Qt.AlignmentFlag.AlignRight if right else Qt.AlignmentFlag.AlignLeft
    label.setAlignment(side | Qt.AlignmentFlag.AlignVCenter)
    return label


class LabelledSlider(QWidget):
    """A name, a slider over a range, and the value with its unit."""

    value_changed = Signal(float)

    def __init__(
        self, text: str, unit: str, low: float, high: float, step: float, tip: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._unit, self._low, self._high, self._step = unit, low, high, step
        self._number = low
        self._name, self._value = QLabel(text, self), fact("", self, right=True)
        self._slider = QSlider(Qt.Orientation.Horizontal, self)
        self._slider.setRange(0, round((high - low) / step))
        self._slider.setAccessibleName(text)
        self._slider.setToolTip(tip)
        self._slider.valueChanged.connect(self._on_slider_moved)
        top = QHBoxLayout()
        top.addWidget(self._name)
        top.addWidget(self._value)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addLayout(top)
        column.addWidget(self._slider)
        self._show()

    @property
    def value(self) -> float:
        """In the unit shown."""
        return self._number

    def set_value(self, value: float) -> None:
        """Show a value without emitting; outside the range the handle waits at the end, and the number is true."""
        self._number = value
        near = min(max(value, self._low), self._high)
        blocked = self._slider.blockSignals(True)
        self._slider.setValue(round((near - self._low) / self._step))
        self._slider.blockSignals(blocked)
        self._show()

    def _on_slider_moved(self, position: int) -> None:
        self._number = self._low + self._step * position
        self._show()
        self.value_changed.emit(self.value)

    def _show(self) -> None:
        decimals = max(0, len(f"{self._step:.3f}".rstrip("0").split(".")[1]))
        number = f"{self._number:.{decimals}f}" if math.isfinite(self._number) else "∞"
        self._value.setText(f"{number}\u2009{self._unit}" if self._unit else number)
        self._slider.setAccessibleDescription(self._value.text())
