"""Painting over a view with a QPainter: pens, captions, pins, lines, areas, the brush, path handles.

Marks have a dark or light rim, so that they contrast with the skin in any colour.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF
from shiboken6 import VoidPtr

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import MarkRole

RIM = QColor(29, 33, 38)
WHITE = QColor(255, 255, 255)
PIN_PX = 5.0
LARGE_PIN_PX = 7.0
"""Half the diagonal of a pin."""
EDGE = 12.0
"""Distance of captions from the view's edge [px]."""
_LOWER_CAPTIONS = 52.0
"""Height of scale bar and slider along the lower edge [px]."""
_DASHES = [4.0, 2.5]
_CAPTION_PX = 11


def polygon(places: FloatArray) -> QPolygonF:
    """Return points (n, 2) as a polygon, written directly to Qt's memory: one by one they cost 0.7 ms per thousand."""
    made = QPolygonF()
    made.resize(len(places))
    if len(places):
        pointer: Any = VoidPtr  # its type stub lacks all arguments
        np.frombuffer(pointer(made.data(), 16 * len(places), True), np.float64)[:] = np.asarray(
            places, np.float64
        ).ravel()
    return made


def faint(colour: QColor | str, alpha: int) -> QColor:
    """Return a colour with this alpha, 0 to 255."""
    made = QColor(colour)
    made.setAlpha(alpha)
    return made


def make_pen(
    colour: QColor | str,
    width: float,
    cap: Qt.PenCapStyle = Qt.PenCapStyle.RoundCap,
    *,
    join: Qt.PenJoinStyle = Qt.PenJoinStyle.BevelJoin,
    dashes: Sequence[float] = (),
) -> QPen:
    """Return a pen of this width [px]; ``dashes`` are lengths of dashes and gaps in units of the width."""
    pen = QPen(QColor(colour), width, Qt.PenStyle.SolidLine, cap, join)
    if dashes:
        pen.setDashPattern(dashes)
    return pen


def rubber_pens(theme: Theme) -> tuple[QPen, QPen]:
    """Pens for outlines of gestures, a dark solid one and a dashed one on top."""
    return QPen(faint(RIM, 170), 1.5), QPen(QColor(theme.accent), 1.5, Qt.PenStyle.DashLine)


# Captions.


def caption_fonts(font: QFont) -> tuple[QFont, QFont]:
    """Derive the fonts of captions and of figures such as forces from the window's font."""
    caption = QFont(font)
    caption.setPixelSize(_CAPTION_PX)
    caption.setWeight(QFont.Weight.Normal)
    figure = QFont(font)
    figure.setPixelSize(13)
    figure.setWeight(QFont.Weight.DemiBold)
    return caption, figure


def paint_box(painter: QPainter, box: QRectF, colour: str, *, alpha: int = 225) -> None:
    """Paint the background of a caption: nearly opaque, so that what is behind does not mix with the text."""
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(faint(colour, alpha))
    painter.drawRoundedRect(box, 4, 4)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def chip_size(text: str, font: QFont) -> QSizeF:
    """Size of a chip with this text [px]."""
    metrics = QFontMetricsF(font)
    pad = 8.0 if font.pixelSize() > 11 else 6.0
    return QSizeF(metrics.horizontalAdvance(text) + 2 * pad, metrics.height() + pad - 2)


def paint_chip(
    painter: QPainter, box: QRectF, text: str, font: QFont, ink: str, background: str, *, alpha: int = 225
) -> None:
    """Paint a text in a rounded box."""
    paint_box(painter, box, background, alpha=alpha)
    painter.setFont(font)
    painter.setPen(QColor(ink))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


@dataclass(frozen=True)
class ViewState:
    """State of a view that does not show the present.

    Attributes:
        text: The state; empty if the view shows the present.
        edge: Name of the theme's colour around the view; empty for none.
    """

    text: str = ""
    edge: Literal["", "accent", "warning"] = ""


PRESENT = ViewState()
PAUSED = ViewState("Paused")
REPLAYING = ViewState("Replaying", "accent")


def state_chips(font: QFont, state: ViewState, counts: Sequence[str] = ()) -> list[tuple[QRectF, str, QFont]]:
    """Return the chips at the upper left of a view: its state, then ``counts``."""
    if not (state.text or counts):
        return []
    caption, figure = caption_fonts(font)
    mode = [state.text] if state.text else []
    chips = []
    left = EDGE
    for text, own in (*((word, figure) for word in mode), *((word, caption) for word in counts)):
        size = chip_size(text, own)
        chips.append((QRectF(QPointF(left, EDGE), size), text, own))
        left += size.width() + 6
    return chips


def paint_state(painter: QPainter, room: QRectF, theme: Theme, state: ViewState, counts: Sequence[str] = ()) -> None:
    """Paint the coloured edge and the ``state_chips`` of a view."""
    if state.edge:
        pen = QPen(QColor(getattr(theme, state.edge)), 3)
        pen.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
        painter.setPen(pen)
        painter.drawRect(room.adjusted(1.5, 1.5, -1.5, -1.5))
    for box, text, font in state_chips(painter.font(), state, counts):
        quiet = font.pixelSize() <= _CAPTION_PX
        paint_chip(painter, box, text, font, theme.quiet if quiet else theme.text, theme.panel)


def draw_label(painter: QPainter, text: str, theme: Theme, *, at: QPointF | None = None) -> None:
    """Draw a chip with a text next to a place [px], or centred above the lower captions; kept within the view."""
    font = QFont(painter.font())
    font.setPixelSize(13 if at is None else 11)
    metrics = QFontMetricsF(font)
    room = QRectF(painter.window())
    width = metrics.horizontalAdvance(text) + 16
    height = metrics.height() + 6
    foot = QPointF((room.width() - width) / 2, room.height() - height - _LOWER_CAPTIONS)
    corner = foot if at is None else at + QPointF(12, -height - 4)
    left, top = (
        min(max(start, EDGE), max(whole - own - EDGE, EDGE))
        for start, whole, own in ((corner.x(), room.width(), width), (corner.y(), room.height(), height))
    )
    paint_chip(painter, QRectF(left, top, width, height), text, font, theme.text, theme.panel, alpha=235)


# Marks.


def draw_strokes(painter: QPainter, lines: Iterable[QPolygonF], pens: Iterable[QPen]) -> None:
    """Draw all polylines with each of the pens."""
    shapes = list(lines)
    for pen in pens:
        painter.setPen(pen)
        for shape in shapes:
            painter.drawPolyline(shape)


def draw_cross(painter: QPainter, at: QPointF, near: float, far: float, pens: Iterable[QPen]) -> None:
    """Draw four strokes around a place, from distance ``near`` to ``far`` [px], so that the place itself stays free."""
    for pen in pens:
        painter.setPen(pen)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            painter.drawLine(at + QPointF(near * dx, near * dy), at + QPointF(far * dx, far * dy))


def draw_lines(painter: QPainter, lines: Iterable[FloatArray], role: MarkRole, theme: Theme) -> None:
    """Draw lines (k, 2) [px] of one role."""
    dashed = role.dashed
    cap = Qt.PenCapStyle.FlatCap if dashed else Qt.PenCapStyle.RoundCap
    join = Qt.PenJoinStyle.RoundJoin
    pens = (
        make_pen(faint(RIM, 200), 4.5, join=join),
        make_pen(role.ink(theme), 2.0, cap, join=join, dashes=_DASHES if dashed else ()),
    )
    draw_strokes(painter, map(polygon, lines), pens)


def draw_pin(painter: QPainter, at: QPointF, colour: QColor, *, large: bool) -> None:
    """Draw a diamond."""
    half = LARGE_PIN_PX if large else PIN_PX
    corners = [QPointF(at.x() + x * half, at.y() + y * half) for x, y in ((0, -1), (1, 0), (0, 1), (-1, 0))]
    painter.setPen(QPen(RIM, 1.5))
    painter.setBrush(colour)
    painter.drawPolygon(QPolygonF(corners))
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_vertex(painter: QPainter, at: FloatArray, theme: Theme, *, fixed: bool) -> None:
    """Draw a small disc at a vertex of a seam, or a ring at a vertex that can become one."""
    painter.setPen(QPen(RIM, 1.5))
    painter.setBrush(QColor(theme.accent) if fixed else Qt.BrushStyle.NoBrush)
    painter.drawEllipse(QPointF(*at.tolist()), 4.5, 4.5)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if not fixed:
        painter.setPen(QPen(QColor(theme.accent), 1.5))
        painter.drawEllipse(QPointF(*at.tolist()), 6, 6)


def draw_area(painter: QPainter, loops: Iterable[FloatArray], theme: Theme) -> None:
    """Draw the translucent area inside loops (k, 2) [px], without its holes."""
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.OddEvenFill)
    for loop in loops:
        path.addPolygon(polygon(loop))
        path.closeSubpath()
    painter.fillPath(path, faint(theme.accent, 70))
    for colour, width in ((faint(RIM, 150), 2.5), (QColor(theme.accent), 1.2)):
        painter.strokePath(path, QPen(colour, width))


def draw_brush(painter: QPainter, middle: QPointF, radius: float, theme: Theme, *, erases: bool) -> None:
    """Draw the circle of the brush, with a minus sign while it erases."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in rubber_pens(theme):
        painter.setPen(pen)
        painter.drawEllipse(middle, radius, radius)
        if erases:
            painter.drawLine(middle - QPointF(5, 0), middle + QPointF(5, 0))


HANDLE_PX = 9.0
LARGE_HANDLE_PX = 12.0
_LEAST_ROOM = 14.0
"""Least distance of a side's middle from a corner [px]: closer, the corner's handle would hide it."""
_HALO = QColor(255, 255, 255, 210)
_HANDLE_RIM = QColor(29, 33, 38, 170)


def draw_handles(
    painter: QPainter, corners: FloatArray, theme: Theme, *, hovered: int | None, chosen: int | None
) -> None:
    """Draw a square at each corner (h, 2) [px], larger under the pointer, filled where chosen."""
    for number, (x, y) in enumerate(corners.tolist()):
        size = LARGE_HANDLE_PX if number == hovered else HANDLE_PX
        box = QRectF(x - size / 2, y - size / 2, size, size)
        painter.setBrush(QColor(theme.intent) if number == chosen else WHITE)
        for pen in (QPen(_HANDLE_RIM, 3.5), QPen(QColor(theme.intent), 1.8)):
            painter.setPen(pen)
            painter.drawRect(box)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_middles(
    painter: QPainter, middles: FloatArray, corners: FloatArray, theme: Theme, *, hovered: int | None
) -> None:
    """Draw a small disc with a plus at each middle of a side (s, 2) [px] with room between the corners (h, 2) [px]."""
    room = np.linalg.norm(middles[:, None] - corners, axis=2).min(axis=1, initial=np.inf)
    for number in np.flatnonzero(room > _LEAST_ROOM).tolist():
        centre = QPointF(*middles[number].tolist())
        radius = 6.5 if number == hovered else 4.5
        painter.setPen(QPen(_HANDLE_RIM, 1.0))
        painter.setBrush(_HALO)
        painter.drawEllipse(centre, radius, radius)
        painter.setPen(QPen(QColor(theme.intent), 1.6))
        for step in (QPointF(radius - 2, 0), QPointF(0, radius - 2)):
            painter.drawLine(centre - step, centre + step)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_sketch(painter: QPainter, line: FloatArray, theme: Theme) -> None:
    """Draw a preview of a path (k, 2) [px], dashed."""
    join = Qt.PenJoinStyle.RoundJoin
    dashes = make_pen(theme.intent, 2.2, Qt.PenCapStyle.FlatCap, join=join, dashes=_DASHES)
    draw_strokes(painter, [polygon(line)], (make_pen(_HALO, 4.6, join=join), dashes))
