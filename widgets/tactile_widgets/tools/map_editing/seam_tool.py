"""The tool for seams: drawn from vertex to vertex along edges, erased a run at a time, proposed and accepted."""

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
from tactile_widgets.views.overlays.painting import draw_label, draw_lines, draw_vertex

_REACH = 0.003
"""A seam this near to a place that is pointed at is meant [m]."""
_ONE_PATCH = "A seam stays on one patch: finish this one with Enter, or discard it with Escape."


@dataclass(frozen=True, eq=False)
class _Line:
    """A line of vertices of one patch: what is drawn, erased or being computed."""

    patch: int
    vertices: IntArray
    role: MarkRole


class SeamTool(MapEditTool):
    """Seams under the pointer, in both views: a drag draws one, clicks draw one through many places, Alt erases."""

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
        """Have a further seam proposed, for the selected patch or the worst of them."""
        document = self._document
        if document is not None and document.patches:
            self._drop()
            patch = _worst(document, self._editor.selected or tuple(range(len(document.patches))))
            self._ask(partial(propose_seam, number=patch), propose=True)

    def finish(self) -> None:
        """Cut along what is drawn; a refused line stays, to be mended."""
        if len(self._through) < 2 or self._patch is None:
            self._editor.told.emit("A seam needs two places: click another one, or discard it with Escape")
            return
        pending = _Line(self._patch, self._path(), MarkRole.OFFERED)
        if self._ask(partial(draw_seam, number=self._patch, through=tuple(self._through))):
            self._drop()
            self._pending = pending if self._editor.busy else None
            self._redraw()

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """A vertex more, or with Alt the run under the pointer erased; twice quickly finishes."""
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
        """Show where the seam would go, or which one would be erased."""
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
        """A drag is a seam, or a line for Enter while another edit is computed; after a click the line waits."""
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
                self._drop()  # a refused drag is drawn anew, not mended
        else:
            if vertex is not None:
                self._editor.failed.emit(_ONE_PATCH)
            self._take_back()

    def key(self, event: QKeyEvent) -> bool:
        """Enter cuts or accepts, Backspace takes back the last vertex."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and (self._through or self._editor.proposal):
            if self._through:
                self.finish()
            else:
                self._editor.accept()
            return True
        if event.key() == Qt.Key.Key_Backspace and self._through:
            self._take_back()
            return True
        return False

    def overrides_shortcut(self, key: Qt.Key) -> bool:
        """Backspace starts the scene again, but not while a seam is drawn."""
        return bool(self._through) and key == Qt.Key.Key_Backspace

    def cancel(self) -> bool:
        """Drop what is drawn, or else what is proposed."""
        if self._through or self._pressed is not None:
            self._drop()
            return True
        waits = self._editor.proposal is not None
        self._editor.decline()
        return waits

    def leave(self) -> None:
        """Nothing is under the pointer."""
        if self._tip is not None or self._erasing is not None:
            self._tip = self._erasing = None
            self._redraw()

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """A cross where a press would mean a vertex."""
        document = self._document
        meant = document is not None and vertex_at(document, place) is not None
        return Qt.CursorShape.CrossCursor if meant else Qt.CursorShape.ArrowCursor

    def has_seam(self, at: SurfacePoint) -> bool:
        """Whether a seam runs past a place of the skin."""
        return self.seam_length(at) is not None

    def seam_length(self, at: SurfacePoint) -> float | None:
        """Length of the seam that runs past a place of the skin, from branch to branch [m]; None where none does."""
        if (found := self.seam(at)) is None:
            return None
        document, number, run = found
        steps = np.diff(document.skin.patches[number].surface.vertices[run], axis=0)
        return float(np.linalg.norm(steps, axis=1).sum())

    def seam(self, at: SurfacePoint) -> tuple[MapDocument, int, IntArray] | None:
        """The seam that runs past a place of the skin: document, patch, and vertices (k,) from branch to branch."""
        document = self._editor.document
        if document is None or not self._editor.enabled:  # a recording that is shown may wear another skin
            return None
        found = seam_at(document, _near(at))
        return None if found is None else (document, *found)

    def erase_at(self, at: SurfacePoint) -> None:
        """Erase the seam that runs past a place of the skin."""
        document = self._editor.document
        if document is not None:
            self._erase(document, _near(at))

    def _erase(self, document: MapDocument, place: PointerHit) -> bool:
        found = seam_at(document, place)
        if found is None:
            self._editor.told.emit("No seam to erase here")
            return False
        line = _Line(*found, MarkRole.ERASED)
        if self._ask(partial(erase_seams, number=line.patch, edges=as_edges(line.vertices))):
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

    def _take_back(self) -> None:
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

    # How it looks.

    def _path(self) -> IntArray:
        """(k,) vertices that the seam goes through so far, and on to the pointer."""
        assert self._paths is not None
        # The pointer may have come to another patch since it was last seen on one.
        tip = [self._tip[1]] if self._tip is not None and self._tip[0] == self._patch else []
        return self._paths.through([*self._through, *(vertex for vertex in tip if vertex != self._through[-1])])

    def _lines(self, document: MapDocument) -> list[_Line]:
        """All there is to show besides the seams that are there."""
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

    def _words(self) -> str:
        """What is said over the view; empty if nothing."""
        proposal = self._editor.proposal
        if proposal is None:
            return ""
        if proposal.gain is None:
            offer = "A further seam"
        elif proposal.gain >= 0.005:
            offer = f"{100 * proposal.gain:.0f}\u202f% less distortion"
        else:
            offer = "No less distortion"
        return f"{offer}  \u00b7  Enter accepts, Escape declines"

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
        """The seam as it would be cut, those offered and erased, and the vertex that a press would mean."""
        document = self._document  # in a replay, another map is shown than the one that is edited
        if document is None:
            return
        for line in self._lines(document):
            if not document.patches[line.patch].visible:
                continue  # shown on the body alone
            pieces = lines_on_map(document, line.patch, as_edges(line.vertices))
            draw_lines(painter, [to_pixels(piece) for piece in pieces], line.role, theme)
        for vertex in self._through:
            assert self._patch is not None
            for at in to_pixels(vertex_on_map(document, self._patch, vertex)):
                draw_vertex(painter, at, theme, fixed=True)
        if self._tip is not None:
            for at in to_pixels(vertex_on_map(document, *self._tip)):
                draw_vertex(painter, at, theme, fixed=False)
        self.paint_body(painter, theme)

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """What a proposal gains."""
        if self._words():
            draw_label(painter, self._words(), theme)

    def _forget(self) -> None:
        self._tip = self._erasing = self._pending = None
        self._drop()

    def _on_rested(self) -> None:
        self._pending = None
        super()._on_rested()


def _worst(document: MapDocument, numbers: tuple[int, ...]) -> int:
    """Of these patches the one with the most distortion on average."""
    measured = distortion(document.map)
    start = 0
    means = {}
    for number, chart in enumerate(document.charts):
        own = slice(start, start + len(chart.faces))
        means[number] = float(np.average(measured.energy[own], weights=measured.areas[own]))
        start = own.stop
    return max(numbers, key=lambda number: means[number])


def _near(at: SurfacePoint) -> PointerHit:
    """As the pointer hits a place of the skin, whichever the view."""
    return PointerHit(at, None, _REACH / PICK_RADIUS_PX)
