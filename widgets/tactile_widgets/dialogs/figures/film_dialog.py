"""Dialog for a film of a recording: size, pictures per second, range and colours."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QFormLayout,
    QSpinBox,
    QWidget,
)

from tactile_widgets.common.make import (
    STYLE_SPACING,
    accept_buttons,
    add_items,
    caption_label,
    column_layout,
    make,
    select_data,
)
from tactile_widgets.dialogs.figures.span_fields import SpanFields

_EVERY_SIZE = ((1280, 640), (1920, 960), (1920, 1080), (3840, 1920))
_SIZES = {f"{width} × {height}": (width, height) for width, height in _EVERY_SIZE}
_SECONDS_A_PICTURE = 0.1
"""Time to draw a picture of 1280 × 640 pixels without a graphics card [s]."""


class FilmDialog(QDialog):
    """Settings of the film of a recording.

    Args:
        duration: Duration of the recording [s].
        span: Selected range [s]; None if there is none.
        theme: Initial theme, ``dark`` or ``light``.
        parent: The window.
    """

    requested = Signal(object, float, object, str)
    """Settings of the film: size (width, height) [px], pictures per second, start and end [s], theme."""

    def __init__(self, duration: float, span: tuple[float, float] | None, theme: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("film-dialog")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Film")
        self.size_px = QComboBox(self)
        add_items(self.size_px, ((words, size, "") for words, size in _SIZES.items()))
        self.rate = make(QSpinBox, self, minimum=1, maximum=120, value=25, suffix="\u202fa second")
        self.theme = QComboBox(self)
        add_items(self.theme, (("Dark theme", "dark", ""), ("Light theme", "light", "")))
        select_data(self.theme, theme)
        self.part = SpanFields(duration, span, self)
        self.part.changed.connect(self._on_changed)
        self.rate.valueChanged.connect(self._on_changed)
        self.size_px.currentIndexChanged.connect(self._on_changed)
        self.note = caption_label(self)
        self._lay_out()
        self._on_changed()

    def _lay_out(self) -> None:
        form = QFormLayout()
        for words, control in (("Size", self.size_px), ("Pictures", self.rate), ("Colours", self.theme)):
            control.setAccessibleName(words)
            form.addRow(words, control)
        self.part.add_to(form)
        buttons, self.film = accept_buttons(self, "Film…", self._on_accepted)
        column_layout(form, self.note, buttons, parent=self, spacing=STYLE_SPACING, margins=None)

    def _on_changed(self, _value: float = 0.0) -> None:
        seconds = self.part.seconds
        self.film.setEnabled(seconds > 0)
        if seconds <= 0:
            self.note.setText("The end must be after the beginning.")
            return
        pictures = int(seconds * self.rate.value()) + 1
        width, height = self.size_px.currentData()
        minutes = pictures * _SECONDS_A_PICTURE * width * height / (1280 * 640) / 60
        duration = f"about {minutes:.0f} min" if minutes > 1.5 else "a minute or less"
        self.note.setText(f"{pictures} pictures; without a graphics card {duration}. The window can be used meanwhile.")

    def _on_accepted(self) -> None:
        size = tuple(self.size_px.currentData())
        rate = float(self.rate.value())
        span = self.part.span
        theme = str(self.theme.currentData())
        self.accept()
        self.requested.emit(size, rate, span, theme)
