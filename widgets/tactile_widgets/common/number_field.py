"""A number that can be typed: with its unit, within limits, without a frame."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDoubleSpinBox, QWidget

from tactile_widgets.common.wheel_guard import guard_wheel

_ROOM = 14
"""Beside the longest number [px]."""


def decimals_of(step: float) -> int:
    """How many digits after the point a step of this size needs, up to three."""
    return max(0, len(f"{step:.3f}".rstrip("0").split(".")[1]))


class NumberField(QDoubleSpinBox):
    """Tells ``valueChanged`` once, when the number is complete; the arrow keys turn it by a step.

    Args:
        name: For people and screen readers.
        unit: Behind the number; empty for none.
        low: Least that can be typed.
        high: Most that can be typed.
        step: Of the arrow keys; it also gives the digits.
        tip: What the number is; the limits are added.
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
        self.setSuffix(f"\u202f{unit}" if unit else "")
        longest = max((f"{end:.{self.decimals()}f}{self.suffix()}" for end in (low, high)), key=len)
        self.setFixedWidth(self.fontMetrics().horizontalAdvance(longest) + _ROOM)
        self.setFrame(False)
        guard_wheel(self)

    def show_number(self, number: float) -> None:
        """Show a number without telling; one beyond the limits is shown as it is, and can only be typed back within."""
        self._words = "" if math.isfinite(number) else "∞"
        blocked = self.blockSignals(True)
        shown = number if math.isfinite(number) else self._high
        self.setRange(min(self._low, shown), max(self._high, shown))
        self.setValue(shown)
        self.blockSignals(blocked)
        self._say()

    def show_words(self, words: str) -> None:
        """Show words instead, where there is no one number."""
        self._words = words
        self._say()

    def textFromValue(self, value: float) -> str:
        """Qt: the number, or the words that stand for it."""
        return self._words or super().textFromValue(value)

    def stepBy(self, steps: int) -> None:
        """Qt: what is turned is a number again."""
        self._words = ""
        super().stepBy(steps)

    def _say(self) -> None:
        edit = self.lineEdit()
        if not (self.hasFocus() and edit.isModified()):  # else a person is typing
            edit.setText(f"{self.prefix()}{self.textFromValue(self.value())}{self.suffix() if not self._words else ''}")
