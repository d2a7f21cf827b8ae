"""Path tool: clicks and strokes draw a path; its corners, sides or all of it can be dragged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, QRectF, Qt
from PySide6.QtGui import QFont, QKeyEvent, QMouseEvent, QPainter

from tactile_maps.core.arrays import FloatArray
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.controller_settings import SETTING_CHOICES
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.control_tool import REACH_PX, ControlTool
from tactile_widgets.tools.control.drawn_path import FREE, DrawnPath, HandleKind, PathHandle, PathSketch, as_points
from tactile_widgets.views.interaction.arrow_keys import nudge_of
from tactile_widgets.views.interaction.select_gesture import CLICK_PX
from tactile_widgets.views.interaction.view_tool import NO_BOXES, PointerHit, ToolBoxes, ToPixels
from tactile_widgets.views.overlays.body_overlays import MarkRole, PointMark, PolylineMark, ToolMarks
from tactile_widgets.views.overlays.painting import LARGE_HANDLE_PX, draw_handles, draw_label, draw_middles, draw_sketch
from tactile_widgets.views.overlays.task_overlay import lines_on_skin

_DRAW = "Click corners, or draw in one stroke; Enter ends, Backspace removes the last one. Drag parts to edit."
_STARTS = "A path must start on the skin"
_NAMES = {HandleKind.CORNER: "move a corner", HandleKind.MIDDLE: "add a corner", HandleKind.LINE: "move the path"}


class PathTool(ControlTool):
    """Tool that draws a path or edits the current one, on the map or on the body.

    Handles are identified by their index. A dragged path is requested on release, so that the arm does not restart the
    path at every move.
    """

    def __init__(self, settings_editor: ControlSettingsEditor, parent: QObject | None = None) -> None:
        super().__init__(settings_editor, parent)
        self._sketch: PathSketch | None = None
        self._hovered: PathHandle | None = None
        self._chosen: int | None = None
        self._held: PathHandle | None = None
        self._from: tuple[FloatArray, QPointF] = np.zeros(2), QPointF()
        self._dragged: DrawnPath | None = None

    @property
    def hint(self) -> str:
        """Text for the shape of the next path."""
        kind = self._settings_editor.settings.path_kind
        if kind in FREE:
            return _DRAW
        shape = SETTING_CHOICES["path_kind"][1][kind].lower()
        return f"Drag from end to end of a {shape}. Choose Polyline in the panel Controller to draw freely."

    @property
    def drawing(self) -> bool:
        """Whether a path is being drawn."""
        return self._sketch is not None

    # Gestures.

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Start a drag of the force or of a part of the path; else start or continue drawing a path."""
        self._hover(place, event)
        point = self._point(place)
        if self._map is None or point is None:
            return False
        if self._sketch is None and self._on_plate(place, event.position()):
            return self._plate.press(event)
        if self._sketch is not None:
            if event.type() == QEvent.Type.MouseButtonDblClick:
                self.finish()
            else:
                self._sketch.press(point, REACH_PX * place.pixel)
                self._redraw()
            return True
        self._held = self._part_at(place)
        self._from = (point, event.position())
        if self._held is None:
            if self._at(place) is None:
                return False
            self._sketch = PathSketch(self._settings_editor.settings.path_kind, point)
        self._chosen = self._held.number if self._held is not None and self._held.grip is HandleKind.CORNER else None
        self._redraw()
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Draw, drag, or highlight the part that a press would drag."""
        self._hover(place, event)
        point = self._point(place)
        path = self._settings_editor.path
        if self._plate.held:
            self._plate.drag(event)
        elif self._sketch is not None and point is not None:
            self._sketch.move(point, CLICK_PX * place.pixel)
            self._redraw()
        elif self._held is not None and path is not None and point is not None:
            start, pixel = self._from
            away = event.position() - pixel
            if self._dragged is not None or np.hypot(away.x(), away.y()) > CLICK_PX:
                self._dragged = path.dragged(self._held, point - start)
                self._redraw()
        else:
            self._point_at(self._part_at(place))

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """Complete a path drawn in one stroke, continue after a click, or request a dragged path."""
        if self._plate.held:
            self._plate.release()
        elif self._sketch is not None:
            if self._sketch.release(max(place.pixel, 1e-3), REACH_PX * place.pixel):
                self.finish()
            self._redraw()
        elif self._held is not None:
            held = self._held
            dragged = self._dragged
            self._held = self._dragged = None
            if dragged is not None:
                self._request(_NAMES[held.grip], dragged)
                self._chosen = held.number + 1 if held.grip is HandleKind.MIDDLE else self._chosen
            self._point_at(self._part_at(place))
            self._redraw()

    def start_at(self, point: FloatArray) -> None:
        """Start another path at a map point (2,); clicks add its corners."""
        self.cancel()
        self._sketch = PathSketch(self._settings_editor.settings.path_kind, point)
        self._sketch.release(1e-3, 0.0)
        self._redraw()

    def finish(self) -> None:
        """Request the drawn path; does nothing with a single corner."""
        if self._sketch is not None and self._sketch.can_end:
            shape = self._sketch.shape
            self._sketch = None
            self._request("draw a path", shape)
            self._redraw()

    def cancel(self) -> bool:
        """Discard the drawn or dragged path."""
        busy = self._sketch is not None or self._held is not None
        self._sketch = self._held = self._dragged = None
        self._redraw()
        return super().cancel() or busy

    def remove_last(self) -> None:
        """Remove the last drawn corner; removing the first discards the path."""
        if self._sketch is not None and not self._sketch.remove_last():
            self._sketch = None
        self._redraw()

    # Keys.

    def overrides_shortcut(self, key: Qt.Key) -> bool:
        """Override Backspace, which restarts the scene, while a path is drawn."""
        return self.drawing and key == Qt.Key.Key_Backspace

    def key(self, event: QKeyEvent) -> bool:
        """Handle Enter (finish), Backspace (undo corner), Delete (remove corner) and arrows (move a corner or all)."""
        key = Qt.Key(event.key())
        if self.drawing:
            if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
                self.finish()
            elif key == Qt.Key.Key_Backspace:
                self.remove_last()
            return key in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Backspace)
        path = self._settings_editor.path
        by = nudge_of(event)
        if self._map is None or self._held is not None or path is None:
            return super().key(event)
        if key == Qt.Key.Key_Delete:
            self._remove(path)
        elif by is not None:
            held = PathHandle(HandleKind.LINE) if self._chosen is None else PathHandle(HandleKind.CORNER, self._chosen)
            self._request(_NAMES[held.grip], path.dragged(held, by), extend=True)
        else:
            return super().key(event)
        return True

    def _remove(self, path: DrawnPath) -> None:
        """Remove the chosen corner, or the one under the pointer; otherwise explain how to choose one."""
        corner = self._hovered.number if self._hovered is not None and self._hovered.grip is HandleKind.CORNER else None
        number = corner if self._chosen is None else self._chosen
        left = None if number is None else path.without(number)
        if number is None:
            self._settings_editor.notified.emit("Click a corner to choose it, then Delete removes it")
        elif left is None:
            self._settings_editor.notified.emit("This path has the fewest corners already")
        else:
            self._chosen = self._hovered = None
            self._request("remove a corner", left)

    def _request(self, name: str, shape: DrawnPath, *, extend: bool = False) -> None:
        """Request to follow a path; a path that starts off the skin is rejected."""
        if self._map is None or self._map.to_body(shape.line[0]) is None:
            self._settings_editor.notified.emit(_STARTS)
        else:
            points = as_points(np.array(shape.points))
            self._settings_editor.do(name, extend=extend, task="follow_path", path_kind=shape.kind, path=points)

    # Picking and painting.

    def _part_at(self, place: PointerHit) -> PathHandle | None:
        path = self._settings_editor.path
        point = self._point(place)
        if path is None or point is None or self._map is None:
            return None
        return path.held_at(point, REACH_PX * place.pixel)

    def _point_at(self, held: PathHandle | None) -> None:
        if held != self._hovered:
            self._hovered = held
            self._redraw()
        else:
            self.drawn.emit()

    def leave(self) -> None:
        """Clear the highlighted part."""
        self._hovered = None
        super().leave()

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return the cursor for what a press there would do."""
        if self._plate.held or (not self.drawing and self._on_plate(place, self._pixel)):
            return Qt.CursorShape.SizeVerCursor
        if self._held is not None:
            return Qt.CursorShape.ClosedHandCursor
        if not self.drawing and (held := self._part_at(place)) is not None:
            return Qt.CursorShape.SizeAllCursor if held.grip is HandleKind.LINE else Qt.CursorShape.OpenHandCursor
        on_skin = self._at(place) is not None or (self.drawing and place.point is not None)
        return Qt.CursorShape.CrossCursor if on_skin else Qt.CursorShape.ArrowCursor

    def _shown(self) -> DrawnPath | None:
        """Return the path that gestures act on: drawn, dragged, or current."""
        if self._sketch is not None:
            return self._sketch.preview
        return self._settings_editor.path if self._dragged is None else self._dragged

    def _mark_body(self, map_: TactileMap) -> ToolMarks:
        shape = self._shown()
        if shape is None:
            return ToolMarks()
        corner = self._hovered.number if self._hovered is not None and self._hovered.grip is HandleKind.CORNER else None
        places = [(number, map_.to_body(at)) for number, at in enumerate(shape.handles)]
        spots = tuple(PointMark(at, MarkRole.REFERENCE, number == corner) for number, at in places if at is not None)
        under_hand = self.drawing or self._dragged is not None
        lines = lines_on_skin(shape.line, map_) if under_hand and len(shape.points) > 1 else ()
        return ToolMarks(map_.skin, spots=spots, strokes=tuple(PolylineMark(line, MarkRole.SKETCHED) for line in lines))

    @property
    def _plate_at(self) -> FloatArray | None:
        """Upper right corner of the path: next to its handles, not over them."""
        shape = self._shown()
        return None if shape is None or self.drawing or self._dragged is not None else shape.line.max(axis=0)

    def boxes(self, to_pixels: ToPixels, font: QFont) -> ToolBoxes:
        """Return the boxes of the plate and of the handles."""
        if (shape := self._shown()) is None:
            return NO_BOXES
        corners = to_pixels(shape.handles) - LARGE_HANDLE_PX / 2
        handles = [QRectF(x, y, LARGE_HANDLE_PX, LARGE_HANDLE_PX) for x, y in corners.tolist()]
        return replace(super().boxes(to_pixels, font), handles=handles)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the handles, the line being drawn or dragged with its length, and the force."""
        shape = self._shown()
        hovered = self._hovered
        self._paint_plate(painter, to_pixels, theme)
        if shape is None:
            return
        if self.drawing or self._dragged is not None:
            draw_sketch(painter, to_pixels(shape.line), theme)
        elif hovered is not None:
            number = hovered.number if hovered.grip is HandleKind.MIDDLE else None
            draw_middles(painter, to_pixels(shape.middles), to_pixels(shape.handles), theme, hovered=number)
        corner = hovered.number if hovered is not None and hovered.grip is HandleKind.CORNER else None
        draw_handles(painter, to_pixels(shape.handles), theme, hovered=corner, chosen=self._chosen)
        if (self.drawing or self._dragged is not None) and self._pixel is not None and self._place.point is not None:
            length = np.linalg.norm(np.diff(shape.line, axis=0), axis=1).sum()
            draw_label(painter, f"{1e3 * length:.0f}\u202fmm", theme, at=self._pixel)
