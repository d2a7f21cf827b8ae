"""Tool for taxel grids: two clicks set opposite corners, keys set rows and columns, Enter places the grid.

A grid becomes part of the scene; ``SkinSteps`` undoes and redoes it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.closest_point import barycentric
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface_grid import SurfaceGrid, surface_grid
from tactile_maps.skin.fitting.grid import MAX_GRID_SIDE, Corner, GridSpec
from tactile_widgets.common.colours import Theme
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels, ViewTool
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, MarkRole, PointMark, ToolMarks
from tactile_widgets.views.overlays.painting import draw_label, draw_vertex

_MOST_SHOWN = 1024
"""Maximum number of taxels in a preview; a larger grid shows every second row and column, or fewer."""
_STEPS = {
    Qt.Key.Key_Up: (1, 0),
    Qt.Key.Key_Down: (-1, 0),
    Qt.Key.Key_Right: (0, 1),
    Qt.Key.Key_Left: (0, -1),
}
_OFFERED = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_M, *_STEPS)


@dataclass(frozen=True, eq=False)
class _Preview:
    """Grid on a patch of ``document``, and the shown taxel locations ``places``."""

    document: MapDocument
    grid: SurfaceGrid
    places: tuple[SurfacePoint, ...]


class GridTool(ViewTool):
    """Tool that sets corners on body or map and previews the grid between them.

    Args:
        editor: Editor of the skin's map.
        parent: Qt parent.
    """

    hint = "Click two opposite corners. Arrows set rows and columns, M mirrors, Enter places, Backspace goes back."
    placed = Signal(GridSpec)
    """The user requested to place this taxel grid."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._rows = self._columns = 8
        self._mirrored = False
        self._corners: tuple[SurfacePoint, ...] = ()
        self._preview: _Preview | None = None
        self._marks: ToolMarks | None = None
        editor.shown.connect(self._on_shown)

    @property
    def spec(self) -> GridSpec | None:
        """Grid that Enter would place; None before both corners are set."""
        document = self._document
        if document is None or len(self._corners) < 2:
            return None
        first, last = (cast("Corner", tuple(document.skin.position(at).tolist())) for at in self._corners)
        link = document.skin.link(self._corners[0])
        return GridSpec(link, self._rows, self._columns, first, last, mirrored=self._mirrored)

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Set a corner; after two, the first of another grid."""
        document = self._document
        if document is None or place.at is None:
            return False
        if len(self._corners) == 1 and self._corners[0].patch != place.at.patch:
            self._editor.failed.emit("Both corners of a grid must be on one patch: click on that one, or press Escape.")
            return True
        self._corners = (*self._corners[: len(self._corners) % 2], place.at)
        self._update()
        return True

    def key(self, event: QKeyEvent) -> bool:
        """Handle arrows (rows and columns), M (mirror), Enter (place) and Backspace (remove a corner)."""
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_Backspace and self._corners:
            self._corners = self._corners[:-1]
        elif len(self._corners) < 2 or key not in _OFFERED:
            return False
        elif key in _STEPS:
            rows, columns = _STEPS[key]
            self._rows = min(max(self._rows + rows, 1), MAX_GRID_SIDE)
            self._columns = min(max(self._columns + columns, 2 if self._rows == 1 else 1), MAX_GRID_SIDE)
            self._rows = max(self._rows, 2 if self._columns == 1 else 1)
        elif key == Qt.Key.Key_M:
            self._mirrored = not self._mirrored
        else:
            self._place()
            return True
        self._update()
        return True

    def overrides_shortcut(self, key: Qt.Key) -> bool:
        """Override the window's shortcuts that this tool uses while there is a corner or a grid to change."""
        return bool(self._corners) and (key == Qt.Key.Key_Backspace or (len(self._corners) == 2 and key in _OFFERED))

    def cancel(self) -> bool:
        """Discard the grid."""
        drawing = bool(self._corners)
        self._corners = ()
        self._update()
        return drawing

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return a cross where a press would set a corner."""
        on_skin = self._document is not None and place.at is not None
        return Qt.CursorShape.CrossCursor if on_skin else Qt.CursorShape.ArrowCursor

    def body_marks(self) -> ToolMarks:
        """Return the corners and the previewed taxels."""
        document = self._document
        if document is None:
            return NO_MARKS
        if self._marks is None:
            offered = () if self._preview is None else self._preview.places
            spots = [PointMark(at, MarkRole.OFFERED) for at in offered]
            spots += [PointMark(at, MarkRole.HELD, large=True) for at in self._corners]
            self._marks = ToolMarks(document.skin, spots=tuple(spots))
        return self._marks

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the corners and the previewed taxels on the map."""
        document = self._document
        if document is None:
            return
        offered = () if self._preview is None else self._preview.places
        pixels, corners = (
            to_pixels(np.array([document.map.to_map(at) for at in places]).reshape(-1, 2))
            for places in (offered, self._corners)
        )
        if self._corners and document.patches[self._corners[0].patch].visible:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(theme.accent))
            for x, y in pixels.tolist():
                painter.drawEllipse(QPointF(x, y), 1.5, 1.5)
            for pixel in corners:
                draw_vertex(painter, pixel, theme, fixed=True)
        self.paint_body(painter, theme)

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw the number of rows and columns, and the pitch."""
        if self.words:
            draw_label(painter, self.words, theme)

    @property
    def words(self) -> str:
        """Text over the view; empty before there is a corner."""
        if self._preview is None:
            return "Click the opposite corner" if self._corners else ""
        off = int((~self._preview.grid.on).sum())
        outside = f"  \u00b7  {off} off the skin" if off else ""
        pitch = 1e3 * float(self._preview.grid.pitch[0])
        return f"{self._rows} rows × {self._columns} columns, {pitch:.2f}\u202fmm apart{outside}  \u00b7  Enter places"

    @property
    def _document(self) -> MapDocument | None:
        return self._editor.document if self._editor.enabled else None

    def _place(self) -> None:
        try:
            spec = self.spec
        except TactileMapsError as error:
            self._editor.failed.emit(str(error))
            return
        if spec is not None and self._preview is not None:
            self._corners = ()
            self._update()
            self.placed.emit(spec)

    def _update(self) -> None:
        """Update the preview; if it cannot be computed, the corners stay."""
        self._marks = None
        self._preview = None
        document = self._document
        if document is not None and len(self._corners) == 2:
            try:
                self._preview = _preview(document, self._corners, (self._rows, self._columns), self._mirrored)
            except TactileMapsError as error:
                self._editor.failed.emit(str(error))
        self.drawn.emit()

    def _on_shown(self, document: MapDocument) -> None:
        """Update the preview after a map edit; another skin discards the corners."""
        if self._corners and (self._preview is None or self._preview.document.skin is not document.skin):
            self._corners = ()
        if self._preview is not None:
            self._preview = replace(self._preview, document=document) if self._corners else None
        self._marks = None


def _preview(
    document: MapDocument, corners: tuple[SurfacePoint, ...], shape: tuple[int, int], mirrored: bool
) -> _Preview:
    """Return the grid on the patch with its taxel locations.

    Raises:
        MeshError: No grid fits between the corners.
    """
    number = corners[0].patch
    surface = document.skin.patches[number].surface
    first, last = (document.skin.position(at) for at in corners)
    grid = surface_grid(surface, first, last, *shape, mirrored=mirrored)
    every = int(np.ceil(np.sqrt(grid.on.size / _MOST_SHOWN)))
    shown = grid.on[::every, ::every]
    faces = grid.faces[::every, ::every][shown]
    points = grid.points[::every, ::every][shown]
    weights: FloatArray = barycentric(surface.vertices[surface.faces[faces]], points)
    places = (
        SurfacePoint(number, int(face), (float(a), float(b), float(c)))
        for face, (a, b, c) in zip(faces, weights, strict=True)
    )
    return _Preview(document, grid, tuple(places))
