"""The slider that lays the skin flat: body at its left end, map at its right."""

from __future__ import annotations

from PySide6.QtCore import QPropertyAnimation, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSlider, QWidget

STEPS = 100
EASE_MS = 150
_WIDTH, _HEIGHT = 190, 24


class MorphSlider(QWidget):
    """A small slider between two words; ``toggle`` goes from one end to the other so that the eye can follow."""

    moved = Signal(float)
    """The share of flatness asked for, from 0 to 1."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("morph")
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.slider.setRange(0, STEPS)
        self.slider.setAccessibleName("From body to map")
        self.slider.setToolTip("Lay the skin flat, with the touch on it: each place goes straight to the map (M)")
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.slider.valueChanged.connect(self._on_value_changed)
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 0, 6, 0)
        row.setSpacing(6)
        for part in (QLabel("Body", self), self.slider, QLabel("Map", self)):
            part.setProperty("role", "caption")
            row.addWidget(part)
        self._ease = QPropertyAnimation(self.slider, b"value", self)
        self._ease.setDuration(EASE_MS)
        self.resize(_WIDTH, _HEIGHT)
        self.hide()

    @property
    def share(self) -> float:
        """How flat: 0 on the body, 1 as on the map."""
        return self.slider.value() / STEPS

    def toggle(self) -> None:
        """To the other end, from wherever it is."""
        self._ease.stop()
        self._ease.setStartValue(self.slider.value())
        self._ease.setEndValue(STEPS if self.share < 0.5 else 0)
        self._ease.start()

    def reset(self) -> None:
        """On the body, at once."""
        self._ease.stop()
        self.slider.setValue(0)

    def _on_value_changed(self, _value: int) -> None:
        self.moved.emit(self.share)
