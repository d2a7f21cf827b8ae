"""Dialog for the content, size and resolution of a figure, with a sketch of its size on a page."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDoubleSpinBox,
    QFormLayout,
    QSpinBox,
    QWidget,
)

from tactile_maps.core.errors import DisplayError
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import (
    STYLE_SPACING,
    accept_buttons,
    add_items,
    caption_label,
    column_layout,
    make,
    select_data,
)
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigurePart, FigureSpec

_PARTS = {
    FigurePart.VIEWS: "Robot and map",
    FigurePart.ROBOT: "Robot",
    FigurePart.MAP: "Map",
    FigurePart.PLOTS: "Plots",
}
_SCALE_BARS = {
    FigurePart.VIEWS: " Robot and map have scale bars.",
    FigurePart.ROBOT: " The robot has a scale bar.",
    FigurePart.MAP: " The map has a scale bar.",
    FigurePart.PLOTS: "",
}
_COLOURS = {
    FigureColours.PAPER: "On white",
    FigureColours.LIGHT: "Light theme",
    FigureColours.DARK: "Dark theme",
}
_WIDTHS = {"One column, 85\u202fmm": 85.0, "Two columns, 170\u202fmm": 170.0}
_A4 = 210.0, 297.0
_MOST = 99_999
"""Largest number that can be typed: the dialog states why a size or resolution is too small or too large."""


class PageSketch(QWidget):
    """The figure on a page of A4, to scale."""

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAccessibleName("The figure on a page of A4")
        self._theme = theme
        self._size = (170.0, 85.0)
        self.setMinimumSize(QSize(120, 170))

    def show_size(self, width: float, height: float) -> None:
        """Show the size of the figure [mm]."""
        self._size = width, height
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        scale = min((self.width() - 2) / max(_A4[0], self._size[0]), (self.height() - 8) / max(_A4[1], self._size[1]))
        painter.translate((self.width() - 2 - max(_A4[0], self._size[0]) * scale) / 2, 0)
        painter.setPen(QPen(QColor(self._theme.line), 1))
        painter.drawRect(QRectF(1, 1, _A4[0] * scale, _A4[1] * scale))
        width, height = self._size
        left = max((_A4[0] - width) / 2, 0.0)
        figure = QRectF(
            1 + left * scale, 1 + min(20.0, max(_A4[1] - height, 0.0)) * scale, width * scale, height * scale
        )
        fill = QColor(self._theme.accent)
        fill.setAlphaF(0.2)
        painter.setPen(QPen(QColor(self._theme.accent), 1.5))
        painter.fillRect(figure, fill)
        painter.drawRect(figure)


class FigureDialog(QDialog):
    """Part, size, resolution and colours of a figure.

    Args:
        theme: Theme of the sketch.
        check: Raises ``DisplayError`` if a figure is too small for its content.
        parent: The window.
    """

    requested = Signal(FigurePart, FigureSpec)
    """Part of the window and settings of the figure."""

    def __init__(self, theme: Theme, check: Callable[[FigurePart, FigureSpec], None], parent: QWidget) -> None:
        super().__init__(parent)
        self._check = check
        self.setObjectName("figure-dialog")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Save figure")
        self.part, self.colours, self.column = QComboBox(self), QComboBox(self), QComboBox(self)
        add_items(self.part, ((words, part, "") for part, words in _PARTS.items()))
        add_items(self.colours, ((words, colours, "") for colours, words in _COLOURS.items()))
        self.column.addItems([*_WIDTHS, "Other width"])
        self.width_mm, self.height_mm = (
            make(QDoubleSpinBox, self, maximum=_MOST, suffix="\u202fmm", decimals=1, valueChanged=self._on_changed)
            for _side in range(2)
        )
        self.dpi = make(
            QSpinBox,
            self,
            maximum=_MOST,
            suffix="\u202fdpi",
            toolTip="Resolution of PNG, and of robot and touch within SVG and PDF; everything else there is vectors",
            valueChanged=self._on_changed,
        )
        self.column.activated.connect(self._on_column_chosen)
        self.part.currentIndexChanged.connect(self._on_changed)
        self.note = caption_label(self)
        self.sketch = PageSketch(theme, self)
        self._lay_out()

    def _lay_out(self) -> None:
        form = QFormLayout()
        rows = {
            "What": self.part,
            "Fits": self.column,
            "Width": self.width_mm,
            "Height": self.height_mm,
            "Resolution": self.dpi,
            "Colours": self.colours,
        }
        for words, control in rows.items():
            control.setAccessibleName(words)
            form.addRow(words, control)
        buttons, self.save = accept_buttons(self, "Save…", self._on_accepted)
        parts = (form, self.sketch, self.note, buttons)
        column_layout(*parts, parent=self, spacing=STYLE_SPACING, stretch=self.sketch, margins=None)

    def show_choice(self, part: FigurePart, spec: FigureSpec) -> None:
        """Show initial settings."""
        select_data(self.part, part)
        select_data(self.colours, spec.colours)
        self.width_mm.setValue(spec.width)
        self.height_mm.setValue(spec.height)
        self.dpi.setValue(spec.dpi)
        self._on_changed()

    def _spec(self) -> FigureSpec:
        colours = FigureColours(self.colours.currentData())
        return FigureSpec(self.width_mm.value(), self.height_mm.value(), self.dpi.value(), colours)

    def _on_column_chosen(self, _index: int) -> None:
        width = _WIDTHS.get(self.column.currentText())
        if width is not None:
            self.width_mm.setValue(width)

    def _on_changed(self, _value: float = 0.0) -> None:
        width = self.width_mm.value()
        known = [words for words, one in _WIDTHS.items() if one == width]
        self.column.setCurrentText(known[0] if known else "Other width")
        self.sketch.show_size(width, self.height_mm.value())
        part = FigurePart(self.part.currentData())
        try:
            spec = self._spec()
            self._check(part, spec)
        except DisplayError as error:
            self.note.setText(as_sentence(str(error)))
            self.save.setEnabled(False)
        else:
            self.save.setEnabled(True)
            width_px, height_px = spec.pixels
            self.note.setText(f"PNG: {width_px} × {height_px} pixels.{_SCALE_BARS[part]}")

    def _on_accepted(self) -> None:
        part = FigurePart(self.part.currentData())
        spec = self._spec()
        self.accept()
        self.requested.emit(part, spec)
