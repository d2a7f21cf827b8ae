"""Taxels that do not read what touches them, marked at every zoom: dead crossed out, stuck boxed, saturated hatched.

Which taxels have which fault and the strokes of each mark (no Qt), the graphics item, and the legend: as many lines as
there are kinds of faults, none where there are none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.core.arrays import BoolArray, FloatArray
from app.scene.effects import Effects
from app.session.prepare import PreparedScene
from app.skin.skin import NO_IDENTITY, TaxelIdentity, number_ranges
from app.tactile.sensor_chain import SensorChain
from app.tactile.sensor_effects import SensorEffects
from widgets.common.colours import Theme
from widgets.map_view.background import paint_legend_box
from widgets.map_view.map_items import ZOrder, cosmetic_pen, padded_bounds, to_lines
from widgets.map_view.map_shapes import MapShapes

_ROUNDING = 1e-6
"""A reading this share below the limit is at it."""


class Fault(Enum):
    """What is wrong with a taxel; the value is how it is called after a number."""

    DEAD = "dead"
    STUCK = "stuck"
    SATURATED = "saturated"


_CROSS = [[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]
_SQUARE = [[[-1, -1], [1, -1]], [[1, -1], [1, 1]], [[1, 1], [-1, 1]], [[-1, 1], [-1, -1]]]
_HATCH = [[[-1, 0.1], [-0.1, -0.8]], [[-1, 1], [1, -1]], [[0.1, 0.8], [1, -0.1]]]
STROKES: dict[Fault, FloatArray] = {
    Fault.DEAD: np.array(_CROSS, float),
    Fault.STUCK: np.array(_SQUARE, float),
    Fault.SATURATED: np.array(_HATCH, float),
}
"""(s, 2, 2) lines of a mark that reaches from -1 to 1; y runs downwards."""


@dataclass(frozen=True, eq=False)
class TaxelFaults:
    """What the sensor's effects do to single taxels.

    Attributes:
        broken: (taxels,) 0 alive, 1 dead, 2 stuck.
        most: The highest reading there is [Pa]; infinite without saturation.
    """

    broken: NDArray[np.int8] = field(default_factory=lambda: np.zeros(0, np.int8))
    most: float = np.inf

    @property
    def any(self) -> bool:
        """Whether there may be any at all."""
        return bool(np.isfinite(self.most)) or bool(np.any(self.broken))

    def of(self, pressures: FloatArray) -> dict[Fault, BoolArray]:
        """(taxels,) which have which fault at these readings [Pa]; what is broken is not called saturated."""
        broken = self.broken if len(self.broken) == len(pressures) else np.zeros(len(pressures), np.int8)
        full = (pressures >= self.most * (1 - _ROUNDING)) & (broken == 0)
        return {Fault.DEAD: broken == 1, Fault.STUCK: broken == 2, Fault.SATURATED: full}


NO_FAULTS = TaxelFaults()


def faults_of(prepared: PreparedScene, effects: Effects) -> TaxelFaults:
    """What these effects do to the taxels of a scene. Cost: 0.2 ms for 1000 taxels."""
    sensor, scene = effects.sensor, prepared.scene
    if sensor.dead_taxels is None and sensor.saturation is None:
        return NO_FAULTS
    made = partial(SensorChain, prepared.skin, tick=scene.tick, seed=scene.seed)
    most = np.inf
    if sensor.saturation is not None and len(prepared.skin):
        limited = SensorEffects(saturation=sensor.saturation, quantisation=sensor.quantisation)
        most = float(made(limited).read(np.full(len(prepared.skin), sensor.saturation.at))[0])
    return TaxelFaults(made(SensorEffects(dead_taxels=sensor.dead_taxels)).dead, most)


_DARK, _LIGHT = QColor(29, 33, 38), QColor(255, 255, 255)
FAULT_COLOURS = {Fault.DEAD: (_LIGHT, _DARK), Fault.STUCK: (_LIGHT, _DARK), Fault.SATURATED: (_DARK, _LIGHT)}
"""Rim and ink of each mark: saturated taxels are deep red, the others light."""
_SMALLEST, _LARGEST = 2.5, 7.0
"""Half a mark [px]."""


class FaultsItem(QGraphicsItem):
    """Marks on single taxels. Mutable: ``place`` after an edit, ``mark`` with each frame."""

    def __init__(self) -> None:
        super().__init__()
        self._places: FloatArray = np.zeros((0, 2))
        self._drawn: BoolArray = np.zeros(0, bool)
        self._pitch = 0.0
        self._faults: Mapping[Fault, BoolArray] = {}
        self._bounds = QRectF()
        self.setZValue(ZOrder.FAULTS)

    def place(self, shapes: MapShapes) -> None:
        """Put them where the map has its taxels now."""
        self.prepareGeometryChange()
        self._places, self._pitch, self._drawn = shapes.taxels, shapes.pitch, shapes.on_shown()
        self._bounds = padded_bounds(shapes.taxels)

    def mark(self, faults: Mapping[Fault, BoolArray]) -> None:
        """Mark these (taxels,) each."""
        self._faults = faults

    def boundingRect(self) -> QRectF:
        """Qt: around all taxels."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the marks."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pixels_per_unit = option.levelOfDetailFromTransform(painter.worldTransform())
        half = min(max(0.3 * self._pitch * pixels_per_unit, _SMALLEST), _LARGEST)
        for fault, those in self._faults.items():
            places = self._places[those & self._drawn]
            if len(places):
                strokes = to_lines(_strokes_at(places, STROKES[fault] * half / pixels_per_unit))
                for ink, width in zip(FAULT_COLOURS[fault], (3.0, 1.4), strict=True):
                    painter.setPen(cosmetic_pen(painter, ink, width))
                    painter.drawLines(strokes)


def _strokes_at(places: FloatArray, strokes: FloatArray) -> FloatArray:
    """(k s, 2, 2) the strokes (s, 2, 2) at each place (k, 2)."""
    return (places[:, None, None] + strokes).reshape(-1, 2, 2)


_PAD, _GLYPH = 8.0, 4.0
_INDENT = 2 * _GLYPH + 8
FaultLegend = tuple[tuple[Fault, str], ...]
"""What each mark means, in words."""


_NAMED_MODULES = 2
_BROKEN = (Fault.DEAD, Fault.STUCK)
"""What is a channel's fault, and not that of the touch: it is named by module."""


def fault_legend(faults: Mapping[Fault, BoolArray], identity: TaxelIdentity = NO_IDENTITY) -> FaultLegend:
    """A line for each kind that there is; what is broken is named by module and channel, as far as they are known.

    Args:
        faults: (taxels,) which have each fault.
        identity: Of all taxels.
    """
    lines = []
    for fault, those in faults.items():
        count = int(those.sum())
        if count:
            where = broken_channels(those, identity) if fault in _BROKEN else ""
            text = f"{count} {'taxel' if count == 1 else 'taxels'} {fault.value}"
            lines.append((fault, f"{text}: {where}" if where else text))
    return tuple(lines)


def broken_channels(those: BoolArray, identity: TaxelIdentity) -> str:
    """``module 14 (channels 0-2, 5), module 15 (channel 3), 4 more modules``; empty where no module is known."""
    if identity.modules is None:
        return ""
    taxels = np.flatnonzero(those)
    modules = identity.modules[taxels]
    different = np.unique(modules)
    parts = []
    for module in different[:_NAMED_MODULES].tolist():
        on_module = taxels[modules == module]
        if identity.channels is None:
            parts.append(f"module {module}")
        else:
            word = "channel" if len(on_module) == 1 else "channels"
            parts.append(f"module {module} ({word} {number_ranges(identity.channels[on_module], most=4)})")
    left = len(different) - _NAMED_MODULES
    if left > 0:
        parts.append(f"{left} more {'module' if left == 1 else 'modules'}")
    return ", ".join(parts)


def fault_legend_size(keys: FaultLegend, font: QFont) -> QSizeF:
    """What they take in ``font``, the caption's [px]; at least one."""
    metrics = QFontMetricsF(font)
    width = max(metrics.horizontalAdvance(text) for _, text in keys) + _INDENT
    return QSizeF(width + 2 * _PAD, (metrics.height() + 2) * len(keys) + 2 * _PAD - 2)


def paint_fault_legend(painter: QPainter, keys: FaultLegend, box: QRectF, font: QFont, theme: Theme) -> None:
    """Draw them in ``box``, of their ``fault_legend_size``; ``font`` is the caption's."""
    line = QFontMetricsF(font).height() + 2
    paint_legend_box(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, box.width() - 2 * _PAD, line)
    for fault, text in keys:
        painter.setPen(QPen(QColor(theme.text), 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        middle = (row.left() + _GLYPH, row.center().y())
        painter.drawLines(to_lines(STROKES[fault] * _GLYPH + middle))
        painter.setPen(QColor(theme.quiet))
        painter.drawText(
            row.adjusted(_INDENT, 0, 0, 0), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text
        )
        row.translate(0, line)
