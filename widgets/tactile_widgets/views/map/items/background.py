"""What bare skin looks like under an overlay (stretch of angles or areas, checkerboard, circles), and its legend.

The background is pixels and numbers without Qt; the legend says what the colours mean, and how bad it is in numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QImage, QPainter, QPen

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import THIN
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.evaluation.distortion import DistortionMeasure, Stretch, TissotCircles, checkerboard, stretch
from tactile_maps.maps.image_atlas import ImageAtlas
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import PressureScale, StretchScale, Theme, words32
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.views.map.items.bijectivity import Flaws
from tactile_widgets.views.map.items.map_coordinates import format_three_digits, nice_floor

STRETCH_SCALE = StretchScale()
_LIGHT = PressureScale().table[0].astype(np.float64)
_SHADE = np.array([172.0, 181.0, 191.0])
"""Of the textures: the bare skin's own neutral, and one darker."""
FLIPPED = (224, 49, 49)
_PATTERNS_ACROSS = 20.0


@dataclass(frozen=True, eq=False)
class Background:
    """The ground of one map.

    Attributes:
        kind: Which.
        pixels: (h, w) 0xffRRGGBB; only those on the skin mean anything.
        stretch: What is shown, where it is stretch.
        note: What the legend says about it.
    """

    kind: BaseLayer
    pixels: NDArray[np.uint32]
    note: str
    stretch: Stretch | None = None

    def tell(self, map_: TactileMap, at: SurfacePoint) -> str:
        """The stretch of the face at a place, in words; empty for a texture."""
        if self.stretch is None:
            return ""
        face = at.face + sum(len(chart.faces) for chart in map_.charts[: at.patch])
        return f"{self.stretch.measure}s ×{format_three_digits(float(self.stretch.faces[face]))}"


def make_background(kind: BaseLayer, map_: TactileMap, image: ImageAtlas) -> Background | None:
    """Make the ground of ``map_`` on its ``image``; None for pressure, whose ground is plain. Cost: 20 to 80 ms.

    Textures are those of the patches at their true size; stretch is that of the map as it is arranged.
    """
    if kind is BaseLayer.PRESSURE:
        return None
    if kind is BaseLayer.ANGLE:
        return _stretch_background(kind, map_, image, "angle")
    if kind is BaseLayer.AREA:
        return _stretch_background(kind, map_, image, "area")
    size = pattern_size(map_)
    length = f"{1e3 * size:g}{THIN}mm"
    if kind is BaseLayer.CHECKER:
        dark = checkerboard(image.centres(), side=size, blur=image.resolution)
        return Background(kind, _textured(dark, image), f"Squares of {length}, on the map")
    if kind is BaseLayer.CIRCLES:
        circles = TissotCircles(map_.skin.patches, radius=size / 2, spacing=1.5 * size)
        dark = circles.cover(*image.places, blur=image.resolution)
        return Background(kind, _textured(dark, image), f"Circles {length} in diameter, on the body")
    assert_never(kind)


def pattern_size(map_: TactileMap) -> float:
    """Side of a square, or width of a circle [m]: a round number, about a twentieth of the map."""
    area = sum(patch.surface.area for patch in map_.skin.patches)
    most = float(np.sqrt(area)) / _PATTERNS_ACROSS
    return 1e-3 * nice_floor(1e3 * most)


def _stretch_background(kind: BaseLayer, map_: TactileMap, image: ImageAtlas, measure: DistortionMeasure) -> Background:
    found = stretch(map_, measure)
    patch, face, _ = image.places
    first = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    palette = STRETCH_SCALE.rgb(found.faces)
    palette[found.flipped] = FLIPPED
    colours = words32(palette)[np.maximum(first[patch] + face, 0)]
    spread = found.spread
    numbers = f"Median ×{spread.median:.2f}   95{THIN}% ×{spread.p95:.2f}   max ×{format_three_digits(spread.max)}"
    return Background(kind, _extended_to_border(colours, image), numbers, found)


def _textured(dark: FloatArray, image: ImageAtlas) -> NDArray[np.uint32]:
    colours = _LIGHT + dark[:, None] * (_SHADE - _LIGHT)
    return _extended_to_border(words32(colours.round().astype(np.uint8)), image)


def _extended_to_border(colours: NDArray[np.uint32], image: ImageAtlas) -> NDArray[np.uint32]:
    """(h, w): border pixels whose centre is beside the skin take the colour of a neighbour on it."""
    grid = colours.reshape(image.shape).copy()
    bare = image.shown & ~image.inside
    rows, columns = np.nonzero(bare)
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        y = np.clip(rows + dy, 0, image.shape[0] - 1)
        x = np.clip(columns + dx, 0, image.shape[1] - 1)
        found = image.inside[y, x] & bare[rows, columns]
        grid[rows[found], columns[found]] = grid[y[found], x[found]]
        bare[rows[found], columns[found]] = False
    return grid


_PAD = 8.0
_STRIP = 10.0
_LEAST_WIDTH = 150.0


@dataclass(frozen=True)
class Legend:
    """What it says.

    Attributes:
        title: What is shown.
        lines: Facts below it.
        strip: Whether the stretch scale is drawn.
        one_sided: Whether only its upper half can occur.
        faulty: Whether the last line tells of flaws.
    """

    title: str
    lines: tuple[str, ...]
    strip: bool = False
    one_sided: bool = False
    faulty: bool = False


def legend_of(ground: Background | None, flaws: Flaws) -> Legend | None:
    """The legend of a ground; None where there is nothing to say: bare pressure, and no flaws."""
    flips = len(flaws.flips)
    overlaps = len(flaws.overlaps)
    faulty = bool(flips or overlaps)
    counts = f"{flips} {'triangle' if flips == 1 else 'triangles'} flipped, {overlaps} overlapping"
    if ground is None:
        return Legend("Not bijective", (counts,), faulty=True) if faulty else None
    strip = ground.stretch is not None
    lines = (ground.note, counts) if strip or faulty else (ground.note,)
    one_sided = ground.stretch is not None and ground.stretch.measure != "area"
    return Legend(ground.kind.title, lines, strip, one_sided, faulty)


def paint_legend_box(painter: QPainter, box: QRectF, theme: Theme) -> None:
    """What a legend stands on: nearly opaque, so that the map behind does not mix with its words."""
    panel = QColor(theme.panel)
    panel.setAlpha(225)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(panel)
    painter.drawRoundedRect(box, 4, 4)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def legend_size(legend: Legend, font: QFont) -> QSizeF:
    """What it takes in ``font``, the caption's [px]."""
    metrics = QFontMetricsF(font)
    line = metrics.height() + 2
    width = max(_LEAST_WIDTH, *(metrics.horizontalAdvance(text) for text in (legend.title, *legend.lines)))
    tall = line * (1 + len(legend.lines)) + (_STRIP + line + 4 if legend.strip else 0)
    return QSizeF(width + 2 * _PAD, tall + 2 * _PAD - 2)


def paint_legend(painter: QPainter, legend: Legend, box: QRectF, font: QFont, theme: Theme) -> None:
    """Draw it in ``box``, of its ``legend_size``; ``font`` is the caption's."""
    line = QFontMetricsF(font).height() + 2
    paint_legend_box(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, box.width() - 2 * _PAD, line)
    painter.setPen(QColor(theme.text))
    painter.drawText(row, Qt.AlignmentFlag.AlignLeft, legend.title)
    if legend.strip:
        row.translate(0, line + 2)
        _paint_strip(painter, legend, row, line, theme)
        row.translate(0, _STRIP + line + 2)
    else:
        row.translate(0, line)
    for number, text in enumerate(legend.lines, start=1):
        loud = legend.faulty and number == len(legend.lines)
        painter.setPen(QColor(theme.fault if loud else theme.quiet))
        painter.drawText(row, Qt.AlignmentFlag.AlignLeft, text)
        row.translate(0, line)


def _paint_strip(painter: QPainter, legend: Legend, row: QRectF, line: float, theme: Theme) -> None:
    table = STRETCH_SCALE.table[127:] if legend.one_sided else STRETCH_SCALE.table
    words = np.ascontiguousarray(words32(table)[None])
    strip = QRectF(row.left(), row.top(), row.width(), _STRIP)
    painter.drawImage(strip, QImage(words.data, len(table), 1, 4 * len(table), QImage.Format.Format_RGB32))
    painter.setPen(QPen(QColor(theme.line), 1))
    painter.drawRect(strip)
    painter.setPen(QColor(theme.quiet))
    below = QRectF(row.left(), strip.bottom() + 1, row.width(), line)
    most = f"×{STRETCH_SCALE.most:g} or more"
    ends = ("kept", "", most) if legend.one_sided else (f"×{1 / STRETCH_SCALE.most:g}", "kept", most)
    sides = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter, Qt.AlignmentFlag.AlignRight)
    for text, side in zip(ends, sides, strict=True):
        painter.drawText(below, side, text)
