"""Background of the map under the touch: stretch of angles or areas, checkerboard, or circles; and its legend.

The background itself is pixels and numbers without Qt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QImage, QPainter, QPen

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import counted
from tactile_maps.core.reading_units import THIN
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.evaluation.distortion import Stretch, TissotCircles, checkerboard, stretch
from tactile_maps.maps.image_atlas import ImageAtlas
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import PressureScale, StretchScale, Theme, words32
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.views.map.items.bijectivity import Flaws
from tactile_widgets.views.map.items.map_coordinates import format_three_digits, nice_floor
from tactile_widgets.views.overlays.legend import PAD, Legend

STRETCH_SCALE = StretchScale()
_LIGHT = PressureScale().table[0].astype(np.float64)
_SHADE = np.array([172.0, 181.0, 191.0])
"""Colours of the textures: neutral of the bare skin, and a darker one."""
FLIPPED = (224, 49, 49)
_PATTERNS_ACROSS = 20.0
_FACTS = "   "
"""Gap between the facts of a line."""


@dataclass(frozen=True, eq=False)
class Background:
    """Background of one map.

    Attributes:
        kind: Kind of background.
        pixels: (h, w) 0xffRRGGBB; pixels off the skin are undefined.
        note: Text for the legend.
        stretch: Stretch of the faces; None for a texture.
    """

    kind: BaseLayer
    pixels: NDArray[np.uint32]
    note: str
    stretch: Stretch | None = None

    def description(self, map_: TactileMap, at: SurfacePoint) -> str:
        """Describe the stretch of the face at a skin location; empty for a texture."""
        if self.stretch is None:
            return ""
        face = at.face + sum(len(chart.faces) for chart in map_.charts[: at.patch])
        return f"{self.stretch.measure}s ×{format_three_digits(float(self.stretch.faces[face]))}"


def make_background(kind: BaseLayer, map_: TactileMap, image: ImageAtlas) -> Background | None:
    """Make the background of a map on its image; None for pressure, which has a plain one. Cost: 20 to 80 ms.

    Textures show the patches at their true size; stretch is that of the arranged map.
    """
    if kind is BaseLayer.PRESSURE:
        return None
    if kind in (BaseLayer.ANGLE, BaseLayer.AREA):
        return _stretch_background(kind, map_, image)
    size = pattern_size(map_)
    length = f"{1e3 * size:g}{THIN}mm"
    if kind is BaseLayer.CHECKER:
        dark = checkerboard(image.centres(), side=size, blur=image.resolution)
        return Background(kind, _textured(dark, image), f"Squares of {length}, on the map")
    circles = TissotCircles(map_.skin.patches, radius=size / 2, spacing=1.5 * size)
    dark = circles.cover(*image.places, blur=image.resolution)
    return Background(kind, _textured(dark, image), f"Circles {length} in diameter, on the body")


def pattern_size(map_: TactileMap) -> float:
    """Side of a square, or diameter of a circle [m]: a round number, about a twentieth of the map's size."""
    area = sum(patch.surface.area for patch in map_.skin.patches)
    most = float(np.sqrt(area)) / _PATTERNS_ACROSS
    return 1e-3 * nice_floor(1e3 * most)


def _stretch_background(kind: BaseLayer, map_: TactileMap, image: ImageAtlas) -> Background:
    found = stretch(map_, "angle" if kind is BaseLayer.ANGLE else "area")
    patch, face, _ = image.places
    first = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    palette = STRETCH_SCALE.rgb(found.faces)
    palette[found.flipped] = FLIPPED
    colours = words32(palette)[np.maximum(first[patch] + face, 0)]
    spread = found.spread
    maximum = format_three_digits(spread.max)
    numbers = _FACTS.join((f"Median ×{spread.median:.2f}", f"95{THIN}% ×{spread.p95:.2f}", f"max ×{maximum}"))
    return Background(kind, _extended_to_border(colours, image), numbers, found)


def _textured(dark: FloatArray, image: ImageAtlas) -> NDArray[np.uint32]:
    colours = _LIGHT + dark[:, None] * (_SHADE - _LIGHT)
    return _extended_to_border(words32(colours.round().astype(np.uint8)), image)


def _extended_to_border(colours: NDArray[np.uint32], image: ImageAtlas) -> NDArray[np.uint32]:
    """(h, w) colours where border pixels with a centre off the skin have the colour of a neighbour on it."""
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


_STRIP = 10.0
_NAMED = 3
"""Number of overlapping patches that a legend names."""


@dataclass(frozen=True)
class BackgroundLegend(Legend):
    """Explains the background's colours and counts the flaws of the map.

    Attributes:
        title: Name of the background.
        lines: Facts below the title.
        flaws: Lines that count flaws, below the facts.
        strip: Whether the stretch scale is drawn.
        one_sided: Whether only the upper half of the scale can occur.
        faulty: Whether there are flaws.
    """

    title: str
    lines: tuple[str, ...]
    flaws: tuple[str, ...] = ()
    strip: bool = False
    one_sided: bool = False
    faulty: bool = False
    least_width: ClassVar[float] = 165.0

    @property
    def texts(self) -> tuple[str, ...]:
        return self.title, *self.lines, *self.flaws

    def fitted(self, width: float, font: QFont) -> BackgroundLegend:
        if self.size(font).width() <= width:
            return self
        metrics = QFontMetricsF(font)
        most = max(width - 2 * PAD, self.least_width)
        lines, flaws = (
            tuple(piece for line in texts for piece in _wrapped(line, most, metrics))
            for texts in (self.lines, self.flaws)
        )
        return replace(self, lines=lines, flaws=flaws)

    def extra_height(self, line: float) -> float:
        return _STRIP + line + 4 if self.strip else 0.0

    def paint_row(self, painter: QPainter, row: QRectF, number: int, theme: Theme) -> None:
        is_flaws = self.faulty and number > len(self.lines)
        painter.setPen(QColor(theme.fault if is_flaws else theme.quiet if number else theme.text))
        painter.drawText(row, Qt.AlignmentFlag.AlignLeft, self.texts[number])
        if self.strip and number == 0:
            self._paint_strip(painter, row.translated(0, row.height() + 2), theme)

    def _paint_strip(self, painter: QPainter, row: QRectF, theme: Theme) -> None:
        table = STRETCH_SCALE.table[127:] if self.one_sided else STRETCH_SCALE.table
        words = np.ascontiguousarray(words32(table)[None])
        strip = QRectF(row.left(), row.top(), row.width(), _STRIP)
        painter.drawImage(strip, QImage(words.data, len(table), 1, 4 * len(table), QImage.Format.Format_RGB32))
        painter.setPen(QPen(QColor(theme.line), 1))
        painter.drawRect(strip)
        painter.setPen(QColor(theme.quiet))
        below = QRectF(row.left(), strip.bottom() + 1, row.width(), row.height())
        most = f"×{STRETCH_SCALE.most:g} or more"
        ends = ("kept", "", most) if self.one_sided else (f"×{1 / STRETCH_SCALE.most:g}", "kept", most)
        sides = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter, Qt.AlignmentFlag.AlignRight)
        for text, side in zip(ends, sides, strict=True):
            painter.drawText(below, side, text)


def background_legend(
    background: Background | None, flaws: Flaws, overlapping: Sequence[str] = ()
) -> BackgroundLegend | None:
    """Make the legend of a background; None for bare pressure without flaws, which needs none.

    Args:
        background: The background.
        flaws: Flaws of the map, which are counted.
        overlapping: Names of the patches that overlap others.
    """
    flips = len(flaws.flips)
    overlaps = len(flaws.overlaps)
    faulty = bool(flips or overlaps)
    names = f" ({', '.join(overlapping[:_NAMED])}{', …' if len(overlapping) > _NAMED else ''})" if overlapping else ""
    text = f"{counted(flips, 'flipped triangle')}, {counted(overlaps, 'overlap')}{names}"
    if background is None:
        return BackgroundLegend("Not bijective", (), (text,), faulty=True) if faulty else None
    strip = background.stretch is not None
    texts = (text,) if strip or faulty else ()
    one_sided = background.stretch is not None and background.stretch.measure != "area"
    return BackgroundLegend(background.kind.title, (background.note,), texts, strip, one_sided, faulty)


def _wrapped(text: str, width: float, metrics: QFontMetricsF) -> list[str]:
    """Wrap a text at the gaps between its facts, else at commas, else between words, in lines of ``width`` [px]."""
    gap = next((gap for gap in (_FACTS, ", ") if gap in text), " ")
    first, *rest = text.split(gap)
    lines = [first]
    for part in rest:
        longer = f"{lines[-1]}{gap}{part}"
        if metrics.horizontalAdvance(longer) <= width:
            lines[-1] = longer
        else:
            lines[-1] += gap.rstrip()
            lines.append(part)
    return lines
