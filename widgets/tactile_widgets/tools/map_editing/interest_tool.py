"""Tool for areas of interest: a brush on map or body that marks where no seam may go."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QPainter

from tactile_maps.core.arrays import BoolArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.seams import INTEREST_WEIGHT, paint_areas
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.tool_kinds import BRUSH
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.map_edit_tool import MapEditTool, seam_lines
from tactile_widgets.tools.map_editing.mesh_picking import vertices_under_brush
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels
from tactile_widgets.views.overlays.body_overlays import AreaMark, ToolMarks, area_outlines
from tactile_widgets.views.overlays.painting import draw_area, draw_brush


class InterestTool(MapEditTool):
    """Brush for areas of interest: a stroke paints, or erases with Alt, and is one undo step."""

    hint = "Paint where no seam may go. Alt erases, [ and ] change the brush."

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(editor, parent)
        self._radius = BRUSH
        self._pointer: QPointF | None = None
        self._on_body = self._erases = False
        self._before: PointerHit | None = None
        self._stroke: dict[int, BoolArray] = {}
        self._stroke_erases = False

    def set_radius(self, radius: float) -> None:
        """Set the radius of the brush [px]."""
        self._radius = radius
        self.drawn.emit()

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Start a stroke if the brush touches skin."""
        document = self._document
        self._point(place, event)
        if document is None or not vertices_under_brush(document, place, place, self._radius):
            return False
        if not self._can_request():
            return False
        self._stroke = {}
        self._stroke_erases = self._erases
        self._sweep(document, place, place)
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Continue the stroke, or show the brush."""
        document = self._document
        self._point(place, event)
        if self._before is not None and document is not None:
            self._sweep(document, self._before, place)
        else:
            self.drawn.emit()

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """End the stroke as a step and request the map for it."""
        document = self._document
        before = self._before
        self._before = None
        if before is not None and document is not None:
            painted = {number: np.flatnonzero(mask) for number, mask in self._changes(document).items()}
            importance = 0.0 if self._stroke_erases else INTEREST_WEIGHT
            if not painted or not self._request(partial(paint_areas, painted=painted, importance=importance)):
                self._stroke = {}
        if not self._editor.busy:
            self._stroke = {}
        self._redraw()

    def cancel(self) -> bool:
        """Discard the stroke."""
        going = self._before is not None
        self._before = None
        if going:
            self._stroke = {}
            self._redraw()
        return going

    def leave(self) -> None:
        """Hide the brush."""
        self._pointer = None
        self.drawn.emit()

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return a cross at the centre of the brush."""
        return Qt.CursorShape.CrossCursor

    def _point(self, place: PointerHit, event: QMouseEvent) -> None:
        self._pointer = event.position()
        self._on_body = place.point is None
        self._erases = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)

    def _sweep(self, document: MapDocument, before: PointerHit, place: PointerHit) -> None:
        self._before = place
        for number, vertices in vertices_under_brush(document, before, place, self._radius).items():
            mask = self._stroke.get(number)
            if mask is None:
                mask = self._stroke[number] = np.zeros(len(document.skin.patches[number].surface.vertices), bool)
            mask[vertices] = True
        self._redraw()

    def _changes(self, document: MapDocument) -> dict[int, BoolArray]:
        """Return the vertices that the stroke changes, by patch."""
        found = {}
        for number, mask in self._stroke.items():
            changed = mask & (_painted(document, number) == self._stroke_erases)
            if changed.any():
                found[number] = changed
        return found

    # Display.

    def _areas(self, document: MapDocument) -> dict[int, BoolArray]:
        """Return masks (n,) of the vertices of interest including the stroke, by patch; empty ones are omitted."""
        areas = {number: _painted(document, number) for number in range(len(document.patches))}
        for number, mask in self._stroke.items():
            areas[number] = areas[number] & ~mask if self._stroke_erases else areas[number] | mask
        return {number: marked for number, marked in areas.items() if marked.any()}

    def _mark_body(self, document: MapDocument) -> ToolMarks:
        areas = self._areas(document)
        tints = tuple(AreaMark(number, np.flatnonzero(marked)) for number, marked in areas.items())
        return ToolMarks(document.skin, lines=seam_lines(document), tints=tints)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the areas, and the brush while it is over the map."""
        document = self._document  # in a replay, another map is shown than the one that is edited
        if document is None:
            return
        for number, marked in self._areas(document).items():
            chart = document.charts[number]
            if document.patches[number].visible:
                loops = area_outlines(chart.faces, marked[chart.vertex_of], document.map.uv[number])
                draw_area(painter, [to_pixels(loop) for loop in loops], theme)
        self._paint_brush(painter, theme, on_body=False)

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw the brush while it is over the body."""
        self._paint_brush(painter, theme, on_body=True)

    def _paint_brush(self, painter: QPainter, theme: Theme, *, on_body: bool) -> None:
        if self._pointer is not None and on_body == self._on_body:
            draw_brush(painter, self._pointer, self._radius, theme, erases=self._erases)

    def _forget(self) -> None:
        self._before = None
        self._stroke = {}

    def _on_rested(self) -> None:
        if self._before is None:
            self._stroke = {}
        super()._on_rested()


def _painted(document: MapDocument, number: int) -> BoolArray:
    """Return the mask (n,) of the vertices of interest of a patch."""
    importance = document.patches[number].seams.importance
    if importance is None:
        return np.zeros(len(document.skin.patches[number].surface.vertices), bool)
    return np.asarray(importance > 0)
