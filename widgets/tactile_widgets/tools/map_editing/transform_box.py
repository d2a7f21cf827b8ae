"""Box around selected patches: handles, geometry of dragging them, and painting.

Outlines, snapping guides, and the text of the gesture are painted with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from tactile_maps.core.arrays import FloatArray
from tactile_maps.editing.arrange import SNAP_ANGLE
from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.model.layout import LARGEST_SCALE, SMALLEST_SCALE
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.interaction.select_gesture import RubberBand, paint_rubber_band
from tactile_widgets.views.interaction.view_tool import ToPixels
from tactile_widgets.views.overlays.painting import draw_label, polygon

HANDLE_PX = 9.0
"""Side of a handle as drawn."""
PICK_RADIUS_PX = 8.0
"""Half the side of the square in which a press hits the handle."""
STEM_PX = 30.0
"""Distance from the upper side of the box to the rotation handle."""
ROTATION_HANDLE = 4
"""Index of the rotation handle; 0 to 3 are the corners."""


@dataclass(frozen=True, eq=False)
class TransformBox:
    """Rectangle, axis-aligned until it is rotated.

    Attributes:
        corners: (4, 2) counter-clockwise from the lower left [m].
    """

    corners: FloatArray

    @classmethod
    def around(cls, document: MapDocument, numbers: tuple[int, ...]) -> TransformBox | None:
        """Return the box around these patches; None without patches."""
        if not numbers:
            return None
        lines = np.concatenate([patch_outline(document, number) for number in numbers])
        (left, low), (right, high) = lines.min(axis=0), lines.max(axis=0)
        return cls(np.array([[left, low], [right, low], [right, high], [left, high]]))

    @property
    def middle(self) -> FloatArray:
        """Centre (2,) [m]."""
        return np.asarray(self.corners.mean(axis=0))

    def handles(self, pixel: float) -> FloatArray:
        """Return the corners and the rotation handle (5, 2) [m]; ``pixel`` is the size of a pixel [m]."""
        top = self.corners[2:].mean(axis=0)
        up = self.corners[3] - self.corners[0]
        length = float(np.linalg.norm(up))
        along = up / length if length > 0 else np.array([0.0, 1.0])
        return np.vstack([self.corners, top + STEM_PX * pixel * along])

    def handle_at(self, point: FloatArray, pixel: float) -> int | None:
        """Return the nearest handle within reach of a map point; None if there is none."""
        away = np.abs(self.handles(pixel) - point).max(axis=1)
        nearest = int(away.argmin())
        return nearest if away[nearest] <= PICK_RADIUS_PX * pixel else None

    def moved(self, by: tuple[float, float]) -> TransformBox:
        """Return the moved box."""
        return TransformBox(self.corners + np.asarray(by))

    def scaled(self, factor: float, about: FloatArray) -> TransformBox:
        """Return the box scaled about a point."""
        return TransformBox(about + factor * (self.corners - about))

    def rotated(self, angle: float) -> TransformBox:
        """Return the box rotated about its centre, counter-clockwise [rad]."""
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        return TransformBox(self.middle + (self.corners - self.middle) @ turn)

    def scaling_of_drag(self, corner: int, by: FloatArray, *, from_middle: bool) -> tuple[float, FloatArray]:
        """Return scale factor and fixed point for a corner dragged by (2,) [m]."""
        about = self.middle if from_middle else self.corners[(corner + 2) % 4]
        arm = self.corners[corner] - about
        square = float(arm @ arm)
        return (1.0 + float(by @ arm) / square if square > 0 else 1.0), about

    def rotation_of_drag(self, start: FloatArray, point: FloatArray) -> float:
        """Return the rotation [rad] about the centre of a pointer moved from ``start`` to ``point``."""
        (x0, y0), (x1, y1) = start - self.middle, point - self.middle
        return math.remainder(math.atan2(y1, x1) - math.atan2(y0, x0), math.tau)


def patch_outline(document: MapDocument, number: int) -> FloatArray:
    """Return the closed border (b, 2) of a patch on the map [m], from its chart."""
    chart = document.charts[number]
    return document.layout.placements[number].apply(chart.plane[chart.border])


def clamped_scale(document: MapDocument, numbers: tuple[int, ...], factor: float) -> float:
    """Return the factor nearest to ``factor`` by which all these patches may be scaled."""
    scales = [document.layout.placements[number].scale for number in numbers]
    # Slightly inside, so that rounding does not exceed the limits.
    return min(max(factor, SMALLEST_SCALE / min(scales) * (1 + 1e-9)), LARGEST_SCALE / max(scales) * (1 - 1e-9))


def snapped_rotation(document: MapDocument, numbers: tuple[int, ...], angle: float) -> float:
    """Return the rotation nearest to ``angle`` in steps of 15°; a single patch ends at a multiple of the step."""
    start = document.layout.placements[numbers[0]].angle if len(numbers) == 1 else 0.0
    return SNAP_ANGLE * round((start + angle) / SNAP_ANGLE) - start


_RIM = QColor(29, 33, 38, 170)
_FAINT = QColor(29, 33, 38, 90)


@dataclass(frozen=True, eq=False)
class ArrangeMarks:
    """Marks that a gesture shows.

    Attributes:
        frame: Box while it is dragged; None for the box around the selected patches.
        x: Vertical guides, by their x on the map [m].
        y: Horizontal guides, by their y on the map [m].
        box: (4, 2) selection box [m].
        words: Effect of the gesture, or action of a handle.
        pointer: Pointer position, next to which the words are drawn [px].
    """

    frame: TransformBox | None = None
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()
    box: FloatArray | None = None
    words: str = ""
    pointer: QPointF | None = None

    def at(self, pointer: QPointF) -> ArrangeMarks:
        """Return the marks with this pointer position."""
        return replace(self, pointer=pointer)


def paint_arrange(
    painter: QPainter,
    to_pixels: ToPixels,
    theme: Theme,
    marks: ArrangeMarks,
    frame: TransformBox | None,
    selected: Sequence[FloatArray],
    hovered: FloatArray | None,
) -> None:
    """Draw box, outlines, guides and text.

    Args:
        painter: Painter of the viewport.
        to_pixels: Converts map points to pixels.
        theme: Theme, whose accent marks the selection.
        marks: Marks of the gesture.
        frame: Box around the selected patches; None if there is none.
        selected: Outlines (b, 2) of the selected patches [m].
        hovered: Outline of the patch under the pointer unless it is selected.
    """
    accent = QColor(theme.accent)
    lighter = QColor(theme.accent).lighter(130)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if hovered is not None:
        _stroke(painter, polygon(to_pixels(hovered)), lighter, 1.5)
    for line in selected:
        _stroke(painter, polygon(to_pixels(line)), accent, 2.5)
    _paint_guides(painter, to_pixels, marks, accent)
    if frame is not None:
        _paint_frame(painter, to_pixels, frame, accent)
    if marks.box is not None:
        paint_rubber_band(painter, RubberBand(to_pixels(marks.box)), theme)
    if marks.words and marks.pointer is not None:
        draw_label(painter, marks.words, theme, at=marks.pointer + QPointF(6, -2))


def _stroke(painter: QPainter, shape: QPolygonF, ink: QColor, width: float) -> None:
    """Draw an outline over a wider dark line, because the accent alone would have too little contrast on light skin."""
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


def _paint_frame(painter: QPainter, to_pixels: ToPixels, frame: TransformBox, accent: QColor) -> None:
    corners = to_pixels(frame.corners)
    up = corners[3] - corners[0]
    top = corners[2:].mean(axis=0)
    length = float(np.linalg.norm(up))
    turn = top + STEM_PX * (up / length if length > 0 else np.array([0.0, -1.0]))
    for colour, width in ((_FAINT, 2.5), (accent, 1.0)):
        painter.setPen(QPen(colour, width))
        painter.drawPolygon(polygon(corners))
    painter.setBrush(QColor(255, 255, 255))
    for pen in (QPen(_RIM, 3.5), QPen(accent, 1.6)):
        painter.setPen(pen)
        for number, at in enumerate([*corners.tolist(), turn.tolist()]):
            box = QRectF(at[0] - HANDLE_PX / 2, at[1] - HANDLE_PX / 2, HANDLE_PX, HANDLE_PX)
            if number == ROTATION_HANDLE:
                painter.drawEllipse(box.adjusted(-0.5, -0.5, 0.5, 0.5))
            else:
                painter.drawRect(box)
    painter.setBrush(Qt.BrushStyle.NoBrush)
