"""How the tool that arranges patches looks: outlines, a frame with handles, guides, and the gesture in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from app.arrays import FloatArray
from widgets.chooser import Rubber, paint_rubber
from widgets.colours import Theme
from widgets.edit_tool import ToPixels
from widgets.edit_tools.drawing import draw_words, polygon
from widgets.map_view.arrange_frame import HANDLE_PX, STEM_PX, TURN, ArrangeFrame

_RIM, _FAINT = QColor(29, 33, 38, 170), QColor(29, 33, 38, 90)


@dataclass(frozen=True, eq=False)
class ArrangeMarks:
    """What a gesture shows.

    Attributes:
        frame: As it is pulled; None for that around the selected patches.
        x: Upright guides, by their x on the map [m].
        y: Level guides.
        box: (4, 2) in which patches are selected [m].
        words: What the gesture has done, or what a handle would do.
        pointer: Beside which the words are [px].
    """

    frame: ArrangeFrame | None = None
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()
    box: FloatArray | None = None
    words: str = ""
    pointer: QPointF | None = None

    def at(self, pointer: QPointF) -> ArrangeMarks:
        """The same beside the pointer."""
        return replace(self, pointer=pointer)


def paint_arrange(
    painter: QPainter,
    to_pixels: ToPixels,
    theme: Theme,
    marks: ArrangeMarks,
    frame: ArrangeFrame | None,
    selected: Sequence[FloatArray],
    hovered: FloatArray | None,
) -> None:
    """Draw it all.

    Args:
        painter: Of the viewport.
        to_pixels: From the map.
        theme: Its accent is for what is held.
        marks: The gesture's.
        frame: Around the selected patches; None for none.
        selected: Their outlines (b, 2) [m].
        hovered: That of the patch under the pointer, unless it is selected.
    """
    accent, lighter = QColor(theme.accent), QColor(theme.accent).lighter(130)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if hovered is not None:
        _stroke(painter, polygon(to_pixels(hovered)), lighter, 1.5)
    for line in selected:
        _stroke(painter, polygon(to_pixels(line)), accent, 2.5)
    _paint_guides(painter, to_pixels, marks, accent)
    if frame is not None:
        _paint_frame(painter, to_pixels, frame, accent)
    if marks.box is not None:
        paint_rubber(painter, Rubber(to_pixels(marks.box)), theme)
    if marks.words and marks.pointer is not None:
        draw_words(painter, marks.words, theme, at=marks.pointer + QPointF(6, -2))


def _stroke(painter: QPainter, shape: QPolygonF, ink: QColor, width: float) -> None:
    """The accent alone would drown in light skin, so it is drawn over a wider dark line."""
    for colour, wide in ((_RIM, width + 2.0), (ink, width)):
        pen = QPen(colour, wide)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.drawPolygon(shape)


def _paint_guides(painter: QPainter, to_pixels: ToPixels, marks: ArrangeMarks, accent: QColor) -> None:
    room = QRectF(painter.window())
    ends = [
        *((QPointF(x, room.top()), QPointF(x, room.bottom())) for x in to_pixels(_points(marks.x, 0))[:, 0].tolist()),
        *((QPointF(room.left(), y), QPointF(room.right(), y)) for y in to_pixels(_points(marks.y, 1))[:, 1].tolist()),
    ]
    for colour, width, style in ((_RIM, 2.5, Qt.PenStyle.SolidLine), (accent, 1.2, Qt.PenStyle.DashLine)):
        painter.setPen(QPen(colour, width, style))
        for start, end in ends:
            painter.drawLine(start, end)


def _points(values: tuple[float, ...], axis: int) -> FloatArray:
    points = np.zeros((len(values), 2))
    points[:, axis] = values
    return points


def _paint_frame(painter: QPainter, to_pixels: ToPixels, frame: ArrangeFrame, accent: QColor) -> None:
    corners = to_pixels(frame.corners)
    up = corners[3] - corners[0]
    top, length = corners[2:].mean(axis=0), float(np.linalg.norm(up))
    turn = top + STEM_PX * (up / length if length > 0 else np.array([0.0, -1.0]))
    for colour, width in ((_FAINT, 2.5), (accent, 1.0)):
        painter.setPen(QPen(colour, width))
        painter.drawPolygon(polygon(corners))
    painter.setBrush(QColor(255, 255, 255))
    for pen in (QPen(_RIM, 3.5), QPen(accent, 1.6)):
        painter.setPen(pen)
        for number, at in enumerate([*corners.tolist(), turn.tolist()]):
            box = QRectF(at[0] - HANDLE_PX / 2, at[1] - HANDLE_PX / 2, HANDLE_PX, HANDLE_PX)
            if number == TURN:
                painter.drawEllipse(box.adjusted(-0.5, -0.5, 0.5, 0.5))
            else:
                painter.drawRect(box)
    painter.setBrush(Qt.BrushStyle.NoBrush)
