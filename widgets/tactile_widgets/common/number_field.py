"""Number field with unit and limits, and a filter of the wheel for controls without focus."""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QDoubleSpinBox, QSlider, QWidget

_ROOM = 14
"""Space next to the longest number [px]."""
_USE_THE_WHEEL = (QComboBox, QSlider, QAbstractSpinBox)


def decimals_of(step: float) -> int:
    """Return the number of decimals that a step of this size needs, up to three."""
    return max(0, len(f"{step:.3f}".rstrip("0").split(".")[1]))


class NumberField(QDoubleSpinBox):
    """Number field that emits ``valueChanged`` once the number is complete; the arrow keys change it by a step.

    Args:
        name: Name for screen readers.
        unit: Unit after the number; empty if there is none.
        low: Smallest number that can be typed.
        high: Largest number that can be typed.
        step: Step of the arrow keys; it also sets the number of decimals.
        tip: Tool tip; the limits are appended.
        parent: Qt parent.
    """

    def __init__(
        self, name: str, unit: str, low: float, high: float, step: float, tip: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._low = low
        self._high = high
        self._words = ""
        self.setAccessibleName(name)
        self.setToolTip(f"{tip}\nFrom {low:g} to {high:g}{chr(0x2009)}{unit}; click to type".rstrip())
        self.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.setKeyboardTracking(False)
        self.setDecimals(decimals_of(step))
        self.setSingleStep(step)
        self.setRange(low, high)
        self._unit = f"\u202f{unit}" if unit else ""
        self.setSuffix(self._unit)
        longest = max((f"{end:.{self.decimals()}f}{self.suffix()}" for end in (low, high)), key=len)
        self.setFixedWidth(self.fontMetrics().horizontalAdvance(longest) + _ROOM)
        self.setFrame(False)
        guard_wheel(self)

    def show_number(self, number: float) -> None:
        """Show a number without emitting; one outside the limits is shown unchanged, but cannot be typed."""
        self._words = "" if math.isfinite(number) else "∞"
        shown = number if math.isfinite(number) else self._high
        with QSignalBlocker(self):
            self.setRange(min(self._low, shown), max(self._high, shown))
            self.setValue(shown)
        self._say()

    def show_words(self, words: str) -> None:
        """Show text instead of a number, such as for several values."""
        self._words = words
        self._say()

    def textFromValue(self, value: float) -> str:
        return self._words or super().textFromValue(value)

    def stepBy(self, steps: int) -> None:
        if self._words:
            self._words = ""
            self.setSuffix(self._unit)
        super().stepBy(steps)

    def _say(self) -> None:
        edit = self.lineEdit()
        if not (self.hasFocus() and edit.isModified()):  # the user is not typing
            unit = "" if self._words else self._unit
            if unit != self.suffix():
                self.setSuffix(unit)  # Qt adds it whenever it writes the text again
            edit.setText(f"{self.prefix()}{self.textFromValue(self.value())}{unit}")


class _WheelGuard(QObject):
    """Event filter: over a control without focus, the wheel scrolls the panel and does not change the value."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()
            return True
        return False


def guard_wheel(root: QWidget) -> None:
    """Let combo boxes, sliders and number fields in ``root``, and ``root`` itself, use the wheel only with the focus.

    Controls created later need another call; a second call for the same control changes nothing.
    """
    inside = [control for kind in _USE_THE_WHEEL for control in root.findChildren(kind)]
    for control in (*([root] if isinstance(root, _USE_THE_WHEEL) else []), *inside):
        if control.findChild(_WheelGuard, options=Qt.FindChildOption.FindDirectChildrenOnly) is None:
            control.installEventFilter(_WheelGuard(control))
            if control.focusPolicy() == Qt.FocusPolicy.WheelFocus:
                control.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
