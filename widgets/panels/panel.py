"""What all panels look like: a heading that folds, content under it, space instead of frames."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QKeySequence, QMouseEvent, QShortcut
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSlider, QVBoxLayout, QWidget

from widgets.panels.fold_heading import FoldHeading

_QUIET_MS = 300
"""Keys and the wheel have come to rest after this long."""


SLIM = """
    QScrollBar:vertical { width: 8px; margin: 0; background: transparent; border: 0; }
    QScrollBar::handle:vertical { background: palette(mid); border-radius: 4px; min-height: 32px; }
    QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical { height: 0; }
    QScrollBar::add-page:vertical, QScrollBar::sub-page:vertical { background: transparent; }
"""
"""Scroll bars that take little room."""
MIXED = "—"
"""What stands for values that differ."""


class Panel(QWidget):
    """A heading and a column; a click on the heading folds the column away.

    Args:
        heading: In words.
        name: Of the object, in settings and tests.
    """

    folded_changed = Signal(bool)
    """The hand folded or unfolded it."""

    def __init__(self, heading: str, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setAccessibleName(heading)
        self._heading, self._body = FoldHeading(heading, self), QWidget(self)
        self._heading.setObjectName(f"{name}-heading")
        self._heading.toggled.connect(self._body.setHidden)
        self._heading.clicked.connect(self.folded_changed)
        self.column = QVBoxLayout(self._body)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(8)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(12, 12, 12, 4)
        whole.setSpacing(8)
        whole.addWidget(self._heading)
        whole.addWidget(self._body)

    @property
    def folded(self) -> bool:
        """Whether only the heading is shown."""
        return self._heading.isChecked()

    def set_folded(self, folded: bool) -> None:
        """Fold or unfold it without emitting."""
        self._heading.setChecked(folded)

    def caption(self, text: str = "") -> QLabel:
        """A quiet line of small text at the end of the column."""
        label = QLabel(text, self)
        label.setProperty("role", "caption")
        label.setWordWrap(True)
        label.setMinimumWidth(1)  # a long path in it is cut, and does not widen the panel
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


class _Name(QLabel):
    """A name that may be double-clicked."""

    double_clicked = Signal()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt."""
        event.accept()
        self.double_clicked.emit()


class LabelledSlider(QWidget):
    """A name, a slider over a range, and the value with its unit."""

    value_changed = Signal(float)
    rested = Signal(float)
    """The hand let go of a value other than before, for what is too slow to follow it."""
    default_wanted = Signal()
    """Its name was double-clicked, or Delete was pressed on the slider: for whoever knows a value to go back to."""

    def __init__(
        self, text: str, unit: str, low: float, high: float, step: float, tip: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._unit, self._low, self._high, self._step = unit, low, high, step
        self._number = self._rest = low
        self._name, self._value = _Name(text, self), fact("", self, right=True)
        self._slider = QSlider(Qt.Orientation.Horizontal, self)
        self._slider.setRange(0, round((high - low) / step))
        self._slider.setAccessibleName(text)
        self._slider.setToolTip(tip)
        self._slider.valueChanged.connect(self._on_slider_moved)
        self._slider.sliderReleased.connect(self._on_rested)
        self._name.double_clicked.connect(self.default_wanted)
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self._slider)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        delete.activated.connect(self.default_wanted)
        self._quiet = QTimer(self)
        self._quiet.setSingleShot(True)
        self._quiet.setInterval(_QUIET_MS)
        self._quiet.timeout.connect(self._on_rested)
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
        self._number = self._rest = value
        self._quiet.stop()
        near = min(max(value, self._low), self._high)
        blocked = self._slider.blockSignals(True)
        self._slider.setValue(round((near - self._low) / self._step))
        self._slider.blockSignals(blocked)
        self._show()

    @property
    def held(self) -> bool:
        """Whether the hand has it, so that it must not be set from elsewhere."""
        return self._slider.isSliderDown() or self._quiet.isActive()

    def set_mixed(self) -> None:
        """Show that there is no one value; the handle waits in the middle."""
        self.set_value(0.5 * (self._low + self._high))
        self._rest = math.nan
        self._value.setText(MIXED)
        self._slider.setAccessibleDescription("several values")

    def set_default_tip(self, words: str) -> None:
        """Say on its name what going back means."""
        self._name.setToolTip(f"Double-click for {words}, or press Delete on the slider")

    def set_tip(self, tip: str) -> None:
        """Say something else about it, such as why it is disabled."""
        self._slider.setToolTip(tip)
        self.setToolTip(tip)

    def _on_slider_moved(self, position: int) -> None:
        self._number = self._low + self._step * position
        self._show()
        self.value_changed.emit(self.value)
        if not self._slider.isSliderDown():
            self._quiet.start()

    def _on_rested(self) -> None:
        self._quiet.stop()
        if self._number != self._rest:
            self._rest = self._number
            self.rested.emit(self._number)

    def _show(self) -> None:
        decimals = max(0, len(f"{self._step:.3f}".rstrip("0").split(".")[1]))
        number = f"{self._number:.{decimals}f}" if math.isfinite(self._number) else "∞"
        self._value.setText(f"{number}\u2009{self._unit}" if self._unit else number)
        self._slider.setAccessibleDescription(self._value.text())
