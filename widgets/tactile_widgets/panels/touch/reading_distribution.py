"""Distribution of the readings of all taxels with the contact threshold drawn in it, and the choice of the threshold.

Each taxel has its own noise and thus its own threshold. A reading is therefore shown as a multiple of its taxel's
threshold, so that the threshold is one line; the axis is labelled in multiples of the noise or, for a fixed threshold,
in the unit of the readings.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QComboBox, QSizePolicy, QWidget

from tactile_maps.contacts.pipeline import NOISE_FACTORS, THRESHOLDS, CloseContacts, ReadingSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.session.measured_session import ReadingLevels
from tactile_widgets.common.colours import DARK, Theme
from tactile_widgets.common.make import (
    STYLE_SPACING,
    caption_label,
    column_layout,
    make,
    row_layout,
    show_text,
    small_font,
)
from tactile_widgets.common.number_field import NumberField

_BINS = 64
_LOW = -10.0
_HIGH = 100.0
"""Lowest and highest multiple of the threshold on the axis; readings beyond are in the first and last bar."""
_LABELLED = (-10, -1, 0, 1, 10, 100)
"""Labelled multiples of the threshold."""
_LINE = 15.0
_HEIGHT = 92
_FIELD = 118
"""Height of a line of text, of the picture, and width of the number [px]."""
_BY_NOISE = "Times the noise"
_FIXED = "Fixed value"
_CLOSE: dict[CloseContacts, str] = {"separate": "Separate contacts side by side", "joined": "Join connected taxels"}
_CLOSE_TIP = (
    "Contacts whose taxels are connected, after a tare: separated by the dip of the readings between them,\n"
    "or one contact. Choose the latter for large objects with an uneven surface."
)
_TIP = (
    "Taxels by reading above the baseline. The height of a bar is the square root of their number.\n"
    "Bars at or above the threshold are taxels in contact. Below: median and 95 % of the taxels' noise."
)


def axis_place(multiples: FloatArray) -> FloatArray:
    """Return the places (n,) from 0 to 1 of multiples (n,) of the threshold: linear near 0, logarithmic far away."""
    ends = np.arcsinh([_LOW, _HIGH])
    return np.clip((np.arcsinh(multiples) - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)


class DistributionView(QWidget):
    """Histogram of the readings as multiples of their thresholds."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("reading-distribution")
        self.setAccessibleName("Distribution of the readings")
        self.setToolTip(_TIP)
        self.setFont(small_font(self.font()))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.theme = DARK
        self.counts = np.zeros(_BINS, dtype=np.int64)
        self._labels: tuple[str, ...] = ()

    def sizeHint(self) -> QSize:
        return QSize(160, _HEIGHT)

    def show_multiples(self, multiples: FloatArray, labels: tuple[str, ...]) -> None:
        """Show readings as multiples (n,) of their thresholds, and texts for the labelled multiples."""
        places = np.minimum((axis_place(multiples) * _BINS).astype(np.int64), _BINS - 1)
        self.counts = np.bincount(places, minlength=_BINS)
        self._labels = labels
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        area = QRectF(0.5, _LINE, self.width() - 1.0, self.height() - 2 * _LINE)
        threshold = area.left() + area.width() * float(axis_place(np.array([1.0]))[0])
        step = area.width() / _BINS
        tallest = max(float(np.sqrt(self.counts.max())), 1.0)
        painter.setPen(Qt.PenStyle.NoPen)
        for number in self.counts.nonzero()[0].tolist():
            left = area.left() + number * step
            height = max(area.height() * float(np.sqrt(self.counts[number])) / tallest, 2.0)
            painter.setBrush(QColor(self.theme.accent if left + step / 2 >= threshold else self.theme.quiet))
            painter.drawRect(QRectF(left, area.bottom() - height, max(step - 1.0, 1.0), height))
        painter.setPen(QPen(QColor(self.theme.line), 1.0))
        painter.drawLine(area.bottomLeft(), area.bottomRight())
        painter.setPen(QPen(QColor(self.theme.text), 1.0, Qt.PenStyle.DashLine))
        painter.drawLine(QPointF(threshold, area.top()), QPointF(threshold, area.bottom()))
        self._paint_labels(painter, area, threshold)

    def _paint_labels(self, painter: QPainter, area: QRectF, threshold: float) -> None:
        metrics = QFontMetricsF(self.font())
        painter.setPen(QColor(self.theme.text))
        words = "Threshold"
        left = min(threshold + 4, area.right() - metrics.horizontalAdvance(words))
        painter.drawText(QPointF(left, metrics.ascent()), words)
        painter.setPen(QColor(self.theme.quiet))
        end = -np.inf
        for multiple, label in zip(_LABELLED, self._labels, strict=False):
            width = metrics.horizontalAdvance(label)
            middle = area.left() + area.width() * float(axis_place(np.array([float(multiple)]))[0])
            left = min(max(middle - width / 2, area.left()), area.right() - width)
            if left > end + 4:
                painter.drawText(QPointF(left, self.height() - 3.0), label)
                end = left + width


class ReadingDistribution(QWidget):
    """Distribution, threshold and its choice.

    Attributes:
        view: The picture.
        kind: Choice between multiples of the noise and a fixed value.
        factor: Multiple of the noise.
        level: Fixed value, in the unit of the readings.
        close_contacts: Choice between separating and joining contacts side by side.
    """

    reading_edited = Signal(ReadingSettings)
    """Contact settings entered by the user."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._settings = ReadingSettings()
        self._usual = 1e3
        self._units = ReadingUnits.COUNTS
        self.view = DistributionView(self)
        self.kind = make(
            QComboBox, self, objectName="threshold-kind", accessibleName="Contact threshold", activated=self._on_kind
        )
        self.kind.addItems([_BY_NOISE, _FIXED])
        tip = "Contact threshold of each taxel in standard deviations of its noise, but at least 1 count or 1 kPa"
        self.factor = NumberField("Threshold, times the noise", "×", *NOISE_FACTORS, 0.1, tip, self)
        tip = "Contact threshold of all taxels, in the unit of the readings"
        low, high = (1e-3 * limit for limit in THRESHOLDS)
        self.level = NumberField("Threshold, fixed value", self._units.unit, low, high, 0.001, tip, self)
        for name, field in (("threshold-factor", self.factor), ("threshold-level", self.level)):
            field.setObjectName(name)
            field.setFixedWidth(_FIELD)
        self.factor.valueChanged.connect(self._on_factor)
        self.level.valueChanged.connect(self._on_level)
        self.close_contacts = make(
            QComboBox,
            self,
            objectName="close-contacts",
            accessibleName="Contacts side by side",
            toolTip=_CLOSE_TIP,
            activated=self._on_close,
        )
        self.close_contacts.addItems(list(_CLOSE.values()))
        self._caption = caption_label(self, "distribution-caption")
        self._caption.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._caption.setFixedHeight(2 * self._caption.fontMetrics().lineSpacing())
        row = row_layout(self.kind, self.factor, self.level, spacing=STYLE_SPACING, stretch=self.kind)
        parts = (self.view, self._caption, row, self.close_contacts)
        column_layout(*parts, parent=self, spacing=STYLE_SPACING)
        self.show_reading(self._settings)

    @property
    def caption(self) -> str:
        """Text below the picture."""
        return self._caption.text()

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self.view.theme = theme
        self.view.update()

    def show_reading(self, settings: ReadingSettings) -> None:
        """Show the current settings."""
        self._settings = settings
        fixed = settings.threshold is not None
        self.kind.setCurrentText(_FIXED if fixed else _BY_NOISE)
        self.factor.setVisible(not fixed)
        self.level.setVisible(fixed)
        self.factor.show_number(settings.above_noise)
        self.level.show_number(1e-3 * (settings.threshold or self._usual))
        self.close_contacts.setCurrentIndex(list(_CLOSE).index(settings.close_contacts))

    def show_levels(self, levels: ReadingLevels, units: ReadingUnits) -> None:
        """Show readings, thresholds and noise of the taxels."""
        heard = np.isfinite(levels.readings)
        thresholds = levels.thresholds[heard]
        if not len(thresholds):
            self.view.show_multiples(np.zeros(0), ())
            show_text(self._caption, "No reading yet.")
            return
        multiples = levels.readings[heard] / thresholds
        if units is not self._units:
            self._units = units
            self.level.setSuffix(f"\u202f{units.unit}")
        self._usual = float(np.median(thresholds))
        by_noise = self._settings.threshold is None and levels.noise is not None
        one = self._settings.above_noise if by_noise else 1e-3 * self._usual
        unit = "×" if by_noise else ""
        self.view.show_multiples(multiples, tuple(f"{one * multiple:,.3g}{unit}" for multiple in _LABELLED))
        above = int((multiples >= 1).sum())
        words = f"{above} of {len(multiples)} taxels at or above the threshold."
        if levels.noise is None:
            noise = "Noise unknown: tare the skin."
        else:
            middle, most = 1e-3 * np.quantile(levels.noise[heard], [0.5, 0.95])
            noise = f"Noise {middle:.3g} (median), {most:.3g}\u202f{units.unit} (95\u202f%)."
        show_text(self._caption, f"{words}\n{noise}")

    def _on_kind(self, index: int) -> None:
        fixed = index == 1
        if fixed is not (self._settings.threshold is not None):
            level = float(np.clip(self._usual, *THRESHOLDS))
            self._edit(replace(self._settings, threshold=level if fixed else None))

    def _on_factor(self, value: float) -> None:
        self._edit(replace(self._settings, above_noise=value))

    def _on_level(self, value: float) -> None:
        self._edit(replace(self._settings, threshold=1e3 * value))

    def _on_close(self, index: int) -> None:
        self._edit(replace(self._settings, close_contacts=list(_CLOSE)[index]))

    def _edit(self, settings: ReadingSettings) -> None:
        if settings != self._settings:
            self.show_reading(settings)
            self.reading_edited.emit(settings)
