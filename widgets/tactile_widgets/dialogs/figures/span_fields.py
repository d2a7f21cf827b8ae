"""Number fields for the start and end of a part of a recording."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QFormLayout, QWidget

from tactile_widgets.common.make import make


class SpanFields(QObject):
    """Two fields, *From* and *To*.

    Args:
        duration: Duration of the recording [s].
        span: Initial start and end [s]; None for the whole recording.
        parent: Widget that contains the fields.

    Attributes:
        first: Field of the start.
        last: Field of the end.
    """

    changed = Signal()

    def __init__(self, duration: float, span: tuple[float, float] | None, parent: QWidget) -> None:
        super().__init__(parent)
        self._duration = duration
        self.first, self.last = (
            make(
                QDoubleSpinBox,
                parent,
                decimals=2,
                maximum=duration,
                suffix="\u202fs",
                value=value,
                valueChanged=self.changed,
            )
            for value in span or (0.0, duration)
        )

    def add_to(self, form: QFormLayout) -> None:
        """Add both fields as rows."""
        for words, field in (("From", self.first), ("To", self.last)):
            field.setAccessibleName(words)
            form.addRow(words, field)

    @property
    def seconds(self) -> float:
        """Length of the part [s]; negative if the end is before the start."""
        return self.last.value() - self.first.value()

    @property
    def span(self) -> tuple[float, float]:
        """Start and end [s]."""
        return self.first.value(), self.last.value()

    @property
    def whole(self) -> bool:
        """Whether the part is the whole recording, to the digits that the fields show."""
        return self.first.value() == self.first.minimum() and self.last.value() == self.last.maximum()
