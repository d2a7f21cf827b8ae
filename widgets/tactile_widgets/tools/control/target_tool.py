"""Target tool: a click sets the contact point to hold, a drag moves it, keys move it in small steps."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter

from tactile_maps.control.controller_registry import has_task
from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.tools.control.control_tool import ControlTool
from tactile_widgets.tools.control.drawn_path import as_points
from tactile_widgets.views.interaction.arrow_keys import nudge_of
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels


class TargetTool(ControlTool):
    """Tool that sets the point to hold, on the map or on the body."""

    hint = "Click where to hold the contact; drag the target. Arrows move it, Page Up and Down change the force."
    _dragging = False

    @property
    def _plate_at(self) -> FloatArray | None:
        return self._target

    @property
    def _target(self) -> FloatArray | None:
        """Point to hold (2,) [m]; None if not set."""
        settings = self._settings_editor.settings
        held = has_task(settings.controller) and settings.task == "hold_point" and settings.path
        return np.array(settings.path[0]) if held else None

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Start a drag of the force on the plate, or set the target on the skin."""
        self._hover(place, event)
        if self._map is None:
            return False
        if self._on_plate(place, event.position()):
            return self._plate.press(event)
        point = self._point(place)
        if point is None or self._at(place) is None:
            return False
        self._dragging = True
        self._settings_editor.begin("set the target")
        self._hold(point)
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Move the target; off the skin it stays at its last location on the skin."""
        self._hover(place, event)
        point = self._point(place)
        if self._plate.held:
            self._plate.drag(event)
        elif self._dragging and point is not None and self._at(place) is not None:
            self._hold(point)
        self.drawn.emit()

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """End the gesture as one undo step."""
        if self._plate.held:
            self._plate.release()
        self._dragging = False
        self._settings_editor.end()

    def cancel(self) -> bool:
        """Restore the previous target."""
        leading = self._dragging
        self._dragging = False
        if leading:
            self._settings_editor.cancel()
        return super().cancel() or leading

    def key(self, event: QKeyEvent) -> bool:
        """Handle arrows (move the target) and Delete (remove it)."""
        if self._map is None or self._dragging:
            return False
        target = self._target
        by = nudge_of(event)
        if event.key() == Qt.Key.Key_Delete:
            self._settings_editor.clear_path()
            return True
        if target is None or by is None:
            return super().key(event)
        if self._map.to_body(target + by) is None:
            self._settings_editor.notified.emit("The target cannot leave the skin")
        else:
            self._settings_editor.do("move the target", extend=True, path=as_points((target + by)[None]))
        return True

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return the cursor for what a press there would do."""
        if self._plate.held or self._on_plate(place, self._pixel):
            return Qt.CursorShape.SizeVerCursor
        if self._dragging:
            return Qt.CursorShape.ClosedHandCursor
        return Qt.CursorShape.ArrowCursor if self._at(place) is None else Qt.CursorShape.CrossCursor

    def _hold(self, point: FloatArray) -> None:
        self._settings_editor.change(task="hold_point", path=as_points(point[None]))

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the force next to the target; the target itself is drawn with the task."""
        self._paint_plate(painter, to_pixels, theme)
