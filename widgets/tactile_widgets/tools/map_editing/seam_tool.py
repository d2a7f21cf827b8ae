"""Seam tool: seams are drawn from vertex to vertex along edges, erased run by run, or proposed and accepted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter

from tactile_maps.core.arrays import IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.seams import draw_seam, erase_seams, propose_seam
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.evaluation.distortion import distortion
from tactile_widgets.common.colours import Theme
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.map_edit_tool import MapEditTool, seam_lines
from tactile_widgets.tools.map_editing.mesh_picking import (
    PICK_RADIUS_PX,
    EdgePaths,
    Vertex,
    as_edges,
    lines_on_map,
    present_seams,
    seam_at,
    seam_runs,
    vertex_at,
    vertex_on_map,
    vertex_point,
)
from tactile_widgets.views.interaction.select_gesture import CLICK_PX
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels
from tactile_widgets.views.overlays.body_overlays import EdgeMark, MarkRole, PointMark, ToolMarks
from tactile_widgets.views.overlays.painting import draw_lines, draw_vertex

_REACH = 0.003
"""Distance within which a seam belongs to a skin location [m]."""
_ONE_PATCH = "A seam must stay on one patch: finish this one with Enter, or discard it with Escape."


@dataclass(frozen=True, eq=False)
class _Line:
    """Line of vertices of one patch that is drawn, erased or being computed."""

    patch: int
    vertices: IntArray
    role: MarkRole


class SeamTool(MapEditTool):
    """Tool that draws seams by a drag or by clicks in both views, and erases them with Alt."""

    hint = "Drag along the skin, or click corners and press Enter; Backspace removes the last one. Alt erases a seam."

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(editor, parent)
        self._patch: int | None = None
        self._through: list[int] = []
        self._tip: Vertex | None = None
        self._pressed: QPointF | None = None
        self._dragging = False
        self._erasing: _Line | None = None
        self._pending: _Line | None = None
        self._paths: EdgePaths | None = None

    # Gestures and keys.

    def propose(self) -> None:
        """Request a proposal for another seam in the most distorted of the selected patches, or of all."""
        document = self._document
        if document is not None and document.patches:
            self._drop()
            patch = _worst(document, self._editor.selected or tuple(range(len(document.patches))))
            self._request(partial(propose_seam, number=patch), propose=True)

    def finish(self) -> None:
        """Cut along the drawn line; a rejected line stays so that it can be corrected."""
        if len(self._through) < 2 or self._patch is None:
            self._editor.notified.emit("A seam needs two places: click another one, or discard it with Escape")
            return
        pending = _Line(self._patch, self._path(), MarkRole.OFFERED)
        if self._request(partial(draw_seam, number=self._patch, through=tuple(self._through))):
            self._drop()
            self._pending = pending if self._editor.busy else None
            self._redraw()

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Add a vertex, or with Alt erase the run under the pointer; a double-click finishes the seam."""
        document = self._document
        if document is None:
            return False
        if event.modifiers() & Qt.KeyboardModifier.AltModifier:
            return self._erase(document, place)
        vertex = vertex_at(document, place)
        if vertex is None:
            return False
        if event.type() == QEvent.Type.MouseButtonDblClick and self._through:
            self.finish()
        elif self._through and vertex[0] != self._patch:
            self._editor.failed.emit(_ONE_PATCH)
        else:
            self._editor.decline()
            self._add(document, vertex)
            self._pressed = event.position()
            self._dragging = False
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Show the path of the seam, or the run that would be erased."""
        document = self._document
        if document is None:
            return
        erases = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier) and self._pressed is None
        found = seam_at(document, place) if erases else None
        tip = None if erases else vertex_at(document, place)
        if tip is not None and self._through and tip[0] != self._patch:
            tip = None
        if self._pressed is not None:
            away = event.position() - self._pressed
            self._dragging |= bool(np.hypot(away.x(), away.y()) > CLICK_PX)
        before = None if self._erasing is None else (self._erasing.patch, self._erasing.vertices.tolist())
        now = None if found is None else (found[0], found[1].tolist())
        if tip != self._tip or now != before:
            self._tip = tip
            self._erasing = None if found is None else _Line(*found, MarkRole.ERASED)
            self._redraw()

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """Cut after a drag; after a click, or while another edit is computed, the line waits for Enter."""
        document = self._document
        pressed = self._pressed
        self._pressed = None
        if document is None or pressed is None or not self._dragging:
            return
        vertex = vertex_at(document, place)
        self._dragging = False
        if vertex is not None and vertex[0] == self._patch:
            clicked = len(self._through) > 1
            free = self._free
            self._add(document, vertex)
            if len(self._through) > 1:
                self.finish()
            if not clicked and free:
                self._drop()  # a rejected drag is drawn again, not corrected
        else:
            if vertex is not None:
                self._editor.failed.emit(_ONE_PATCH)
            self._remove_last()

    def key(self, event: QKeyEvent) -> bool:
        """Handle Enter (cut) and Backspace (remove the last vertex)."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self._through:
            self.finish()
            return True
        if event.key() == Qt.Key.Key_Backspace and self._through:
            self._remove_last()
            return True
        return False

    def overrides_shortcut(self, key: Qt.Key) -> bool:
        """Override Backspace, which restarts the scene, while a seam is drawn."""
        return bool(self._through) and key == Qt.Key.Key_Backspace

    def cancel(self) -> bool:
        """Discard the drawn line."""
        if self._through or self._pressed is not None:
            self._drop()
            return True
        return False

    def leave(self) -> None:
        """Clear the highlighted vertex and run."""
        if self._tip is not None or self._erasing is not None:
            self._tip = self._erasing = None
            self._redraw()

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return a cross where a press would add a vertex."""
        document = self._document
        on_vertex = document is not None and vertex_at(document, place) is not None
        return Qt.CursorShape.CrossCursor if on_vertex else Qt.CursorShape.ArrowCursor

    def has_seam(self, at: SurfacePoint) -> bool:
        """Whether a seam passes a skin location."""
        return self.seam_length(at) is not None

    def seam_length(self, at: SurfacePoint) -> float | None:
        """Return the length, from branch to branch, of the seam at a skin location [m]; None without a seam."""
        if (found := self.seam(at)) is None:
            return None
        document, number, run = found
        steps = np.diff(document.skin.patches[number].surface.vertices[run], axis=0)
        return float(np.linalg.norm(steps, axis=1).sum())

    def seam(self, at: SurfacePoint) -> tuple[MapDocument, int, IntArray] | None:
        """Return the seam at a skin location: document, patch, and vertices (k,) from branch to branch."""
        document = self._editor.document
        if document is None or not self._editor.enabled:  # a shown recording may have another skin
            return None
        found = seam_at(document, _near(at))
        return None if found is None else (document, *found)

    def erase_at(self, at: SurfacePoint) -> None:
        """Erase the seam at a skin location."""
        document = self._editor.document
        if document is not None:
            self._erase(document, _near(at))

    def _erase(self, document: MapDocument, place: PointerHit) -> bool:
        found = seam_at(document, place)
        if found is None:
            self._editor.notified.emit("No seam to erase here")
            return False
        line = _Line(*found, MarkRole.ERASED)
        if self._request(partial(erase_seams, number=line.patch, edges=as_edges(line.vertices))):
            self._pending = line if self._editor.busy else None
        self._erasing = None
        self._redraw()
        return True

    def _add(self, document: MapDocument, vertex: Vertex) -> None:
        number, corner = vertex
        if not self._through:
            patch = document.skin.patches[number]
            self._patch = number
            self._paths = EdgePaths(patch.surface, document.patches[number].seams.importance)
        if self._through[-1:] != [corner]:
            self._through.append(corner)
        self._redraw()

    def _remove_last(self) -> None:
        self._through = self._through[:-1]
        if not self._through:
            self._drop()
        self._redraw()

    def _drop(self) -> None:
        self._patch = None
        self._through = []
        self._paths = None
        self._pressed = None
        self._dragging = False
        self._redraw()

    # Display.

    def _path(self) -> IntArray:
        """Return the vertices (k,) of the seam up to the pointer."""
        assert self._paths is not None
        # The pointer may be on another patch now.
        tip = [self._tip[1]] if self._tip is not None and self._tip[0] == self._patch else []
        return self._paths.through([*self._through, *(vertex for vertex in tip if vertex != self._through[-1])])

    def _lines(self, document: MapDocument) -> list[_Line]:
        """Return all lines to show in addition to existing seams."""
        lines = [line for line in (self._pending, self._erasing) if line is not None]
        proposal = self._editor.proposal
        if proposal is not None:
            (job, *_), (chart, *_) = proposal.result.request.jobs, proposal.result.charts
            there = {tuple(edge) for edge in present_seams(document, job.number).tolist()}
            new = [edge for edge in np.sort(chart.seams, axis=1).tolist() if tuple(edge) not in there]
            lines += [_Line(job.number, run, MarkRole.OFFERED) for run in seam_runs(np.array(new, int).reshape(-1, 2))]
        if self._patch is not None and self._through:
            lines.append(_Line(self._patch, self._path(), MarkRole.HELD))
        return lines

    def _mark_body(self, document: MapDocument) -> ToolMarks:
        lines = tuple(EdgeMark(line.patch, line.vertices, line.role) for line in self._lines(document))
        spots = [
            PointMark(vertex_point(document, self._patch, v), MarkRole.HELD)
            for v in self._through
            if self._patch is not None
        ]
        if self._tip is not None:
            spots.append(PointMark(vertex_point(document, *self._tip), MarkRole.PIN))
        return ToolMarks(document.skin, lines=(*seam_lines(document), *lines), spots=tuple(spots))

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the seam being drawn, proposed and erased seams, and the vertex that a press would add."""
        document = self._document  # in a replay, another map is shown than the one that is edited
        if document is None:
            return
        for line in self._lines(document):
            if not document.patches[line.patch].visible:
                continue  # shown only on the body
            pieces = lines_on_map(document, line.patch, as_edges(line.vertices))
            draw_lines(painter, [to_pixels(piece) for piece in pieces], line.role, theme)
        for vertex in self._through:
            assert self._patch is not None
            for at in to_pixels(vertex_on_map(document, self._patch, vertex)):
                draw_vertex(painter, at, theme, fixed=True)
        if self._tip is not None:
            for at in to_pixels(vertex_on_map(document, *self._tip)):
                draw_vertex(painter, at, theme, fixed=False)

    def _forget(self) -> None:
        self._tip = self._erasing = self._pending = None
        self._drop()

    def _on_rested(self) -> None:
        self._pending = None
        super()._on_rested()


def _worst(document: MapDocument, numbers: tuple[int, ...]) -> int:
    """Return the patch with the largest mean distortion."""
    measured = distortion(document.map)
    start = 0
    means = {}
    for number, chart in enumerate(document.charts):
        own = slice(start, start + len(chart.faces))
        means[number] = float(np.average(measured.energy[own], weights=measured.areas[own]))
        start = own.stop
    return max(numbers, key=lambda number: means[number])


def _near(at: SurfacePoint) -> PointerHit:
    """Return a pointer hit at a skin location, independent of the view."""
    return PointerHit(at, None, _REACH / PICK_RADIUS_PX)
