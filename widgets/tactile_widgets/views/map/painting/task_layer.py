"""The controller's task over the map: reference path in violet, target, contact path in white and fading; its legend.

Path and legend seldom change, so their pixels are kept (``PaintCache``).
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QTransform

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.points import cumulative_lengths, points_along
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.interaction.polyline import simplify_polyline
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.paint_cache import PaintCache
from tactile_widgets.views.overlays.painting import RIM, WHITE, draw_cross, draw_strokes, make_pen, polygon
from tactile_widgets.views.overlays.task_overlay import TRAIL_SECONDS, TaskOverlay

_HALO = QColor(255, 255, 255, 215)
_FADES = 5
"""Number of shades between a new and an old part of the contact path."""
_ARROW_EVERY = 110.0
_FIRST_ARROW = 36.0
_ARROW = 7.0
"""Distance between arrowheads along the path, distance of the first, and length of one [px]."""
_CLEAR = 11.0
_REACH = 20.0
"""Distances from the target at which its strokes begin and end [px]."""
_ROOM = 16.0
"""Margin around the path for its width and arrowheads [px]."""
_FLAT = Qt.PenCapStyle.FlatCap


class TaskPainter:
    """Paints a task; keeps the pixels of the path until path, view or patches change."""

    def __init__(self) -> None:
        self._path_cache = PaintCache(at_once=True)

    def paint(
        self,
        painter: QPainter,
        task: TaskOverlay,
        target: QPointF | None,
        shapes: MapShapes,
        still: MapShapes,
        view: QTransform,
        theme: Theme,
    ) -> None:
        """Paint path, contact path and target; path and contact path move with patches that are being dragged.

        Args:
            painter: Painter of the viewport.
            task: Task to paint.
            target: Its target [px]; None if that is not visible.
            shapes: Shapes of the map that is shown.
            still: Shapes of the map of the task, before a drag.
            view: Conversion of scene units to pixels.
            theme: Its intent is the controller's colour.
        """

        def pixels(places: FloatArray, patch: int) -> FloatArray:
            scene = shapes.frame.to_scene(places)
            if shapes is not still:
                scene = shapes.patches[patch].to_scene(still.patches[patch].to_chart(scene))
            return scene * [view.m11(), view.m22()] + [view.dx(), view.dy()]

        path = task.path
        lines = [pixels(line.on_map, line.patch) for line in path.lines if shapes.patches[line.patch].shown]
        jumps = zip(path.crossings, path.crossed, strict=True) if path else ()
        hops = [np.stack([pixels(*end) for end in zip(ends, patches, strict=True)]) for ends, patches in jumps]
        if lines or hops:
            low, high = (f(np.concatenate([*lines, *hops]), axis=0) for f in (np.min, np.max))
            bounds = QRectF(*low, *(high - low)).adjusted(-_ROOM, -_ROOM, _ROOM, _ROOM)
            key = (task.path, shapes, view.m11(), view.dx(), view.dy(), theme.intent)
            self._path_cache.paint(painter, key, bounds, partial(_paint_path, lines, hops, QColor(theme.intent)))
        for part in task.tail.lines:
            patch = int(task.tail.patch[part.start])
            if shapes.patches[patch].shown:
                _paint_tail(painter, pixels(task.tail.on_map[part], patch), task.tail.age[part])
        if target is not None:
            # Outside of the target, because the touch is mostly at the target already.
            draw_cross(painter, target, _CLEAR, _REACH, (make_pen(_HALO, 5.0), make_pen(theme.intent, 2.2)))


def _paint_path(lines: list[FloatArray], hops: list[FloatArray], ink: QColor, painter: QPainter) -> None:
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    lines = [simplify_polyline(line, 0.3) for line in lines]
    join = Qt.PenJoinStyle.RoundJoin
    draw_strokes(painter, map(polygon, lines), (make_pen(_HALO, 5.4, join=join), make_pen(ink, 2.6, join=join)))
    draw_strokes(painter, map(polygon, hops), [make_pen(ink, 2.0, dashes=[0.1, 3.0])])
    painter.setPen(make_pen(_HALO, 1.2, Qt.PenCapStyle.SquareCap))
    painter.setBrush(ink)
    for line in lines:
        for arrow in _arrows(line):
            painter.drawPolygon(polygon(arrow))
    painter.setBrush(Qt.BrushStyle.NoBrush)


def _arrows(line: FloatArray) -> list[FloatArray]:
    """(3, 2) arrowheads along a line (k, 2) [px]; none on a line shorter than an arrowhead."""
    way = cumulative_lengths(line)
    found = []
    for at in np.arange(min(_FIRST_ARROW, way[-1] / 2), way[-1] - _ARROW, _ARROW_EVERY):
        back, tip = points_along(line, way, np.array([at, at + _ARROW]))
        along = tip - back
        if np.linalg.norm(along) > _ARROW / 2:  # not where the line turns back
            along *= _ARROW / np.linalg.norm(along)
            aside = 0.75 * np.array([-along[1], along[0]])
            found.append(np.stack([back + 1.3 * along, back + aside, back - aside]))
    return found


def _paint_tail(painter: QPainter, places: FloatArray, age: FloatArray) -> None:
    """Paint a part of the contact path; the newest part is widest and opaque."""
    shade = np.minimum((age * _FADES).astype(int), _FADES - 1)
    cuts = [0, *(np.flatnonzero(np.diff(shade)) + 1).tolist(), len(places) - 1]
    parts = [(polygon(places[a : b + 1]), 1 - int(shade[a]) / _FADES) for a, b in pairwise(cuts) if b > a]
    for base, extra in ((RIM, 2.4), (WHITE, 0.0)):
        for line, fresh in parts:
            colour = QColor(base)
            colour.setAlphaF(fresh)
            draw_strokes(painter, [line], [make_pen(colour, 1.6 + 1.8 * fresh + extra, _FLAT)])


REFERENCE = "Reference path"
TARGET = "Target"
ACTUAL = f"Contact path, last {TRAIL_SECONDS:g}\u202fs"
_GLYPH = 18.0


def task_legend_entries(task: TaskOverlay) -> tuple[str, ...]:
    """Return the texts for the kinds of marks that a task has."""
    marks = {REFERENCE: bool(task.path), TARGET: task.target is not None, ACTUAL: bool(task.tail.lines)}
    return tuple(text for text, there in marks.items() if there)


def task_legend(entries: tuple[str, ...]) -> MarkLegend:
    """Make the legend of a task; ``entries`` are at least one."""
    return MarkLegend(tuple((partial(_draw_glyph, text), text) for text in entries), _GLYPH, spacing=3.0)


def _draw_glyph(text: str, painter: QPainter, middle: QPointF, theme: Theme) -> None:
    if text == TARGET:
        draw_cross(painter, middle, 3, 6.5, [make_pen(theme.intent, 2.0)])
        return
    reach = QPointF(_GLYPH / 2, 0)
    pens = [make_pen(RIM, 5.0, _FLAT), make_pen(WHITE, 2.8, _FLAT)]
    for pen in [make_pen(theme.intent, 2.6, _FLAT)] if text == REFERENCE else pens:
        painter.setPen(pen)
        painter.drawLine(middle - reach, middle + reach)
