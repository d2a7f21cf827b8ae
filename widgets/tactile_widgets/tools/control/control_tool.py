"""Common base of the path and target tools: edited settings, force handle, and body locations as map points.

The force handle is a small plate with the force goal [N], changed by dragging up or down, by the wheel or by keys.
"""

from __future__ import annotations

from PySide6.QtCore import QObject, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QKeyEvent, QMouseEvent, QPainter, QPen, QWheelEvent

from tactile_maps.control.motion.command import RANGES
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import Theme
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.views.interaction.view_tool import NO_BOXES, PointerHit, ToolBoxes, ToPixels, ViewTool
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, ToolMarks
from tactile_widgets.views.overlays.painting import caption_fonts

FORCE_STEP = 0.5
"""Step of the force goal [N]."""
PIXELS_PER_STEP = 8.0
"""Drag distance for one step."""
FORCE_STEP_NAME = "set the force"
_NOTCH = 120
_KEYS = {Qt.Key.Key_PageUp: 1, Qt.Key.Key_PageDown: -1}
_OFFSET = QPointF(16.0, -34.0)
"""Offset of the plate's upper left corner from the point it belongs to [px]."""


class ForceHandle:
    """Plate with the force goal, located where it was last painted. Mutable.

    Args:
        settings_editor: Editor of the controller settings.

    Attributes:
        held: Whether it is being dragged.
    """

    def __init__(self, settings_editor: ControlSettingsEditor) -> None:
        self._settings_editor = settings_editor
        self._box = QRectF()
        self.held = False
        self._from = (0.0, 0.0)
        self._rolled = 0

    def holds(self, pixel: QPointF) -> bool:
        """Whether a pixel of the map view is on the plate."""
        return self._box.contains(pixel)

    def press(self, event: QMouseEvent) -> bool:
        """Start a drag if the press is on the plate; return whether it is."""
        self.held = self.holds(event.position())
        if self.held:
            self._from = event.position().y(), self._settings_editor.settings.force_goal
            self._settings_editor.begin(FORCE_STEP_NAME)
        return self.held

    def drag(self, event: QMouseEvent) -> None:
        """Set the force of the drag; up increases it."""
        y, force = self._from
        self._settings_editor.change(force_goal=_stepped(force, round((y - event.position().y()) / PIXELS_PER_STEP)))

    def release(self) -> None:
        """End the drag as one step."""
        self.held = False
        self._settings_editor.end()

    def cancel(self) -> bool:
        """Cancel the drag; return whether there was one."""
        held = self.held
        self.held = False
        if held:
            self._settings_editor.cancel()
        return held

    def turn(self, steps: int) -> None:
        """Change the force by ``steps``; consecutive changes form one undo step."""
        self._settings_editor.do(
            FORCE_STEP_NAME, extend=True, force_goal=_stepped(self._settings_editor.settings.force_goal, steps)
        )

    def roll(self, eighths: int) -> None:
        """Handle wheel rotation in eighths of a degree; fractions of a notch accumulate."""
        self._rolled += eighths
        notches = int(self._rolled / _NOTCH)
        self._rolled -= notches * _NOTCH
        if notches:
            self.turn(notches)

    def key(self, key: Qt.Key) -> bool:
        """Handle Page Up and Page Down; return whether it was one of them."""
        if key in _KEYS and not self.held:
            self.turn(_KEYS[key])
        return key in _KEYS

    def hide(self) -> None:
        """Hide the plate."""
        self._box = QRectF()

    @staticmethod
    def box(at: QPointF, font: QFont) -> QRectF:
        """Return the box of the plate next to ``at`` [px], with the figures in the font of ``caption_fonts``."""
        width = QFontMetricsF(caption_fonts(font)[1]).horizontalAdvance("00.0\u202fN") + 26
        return QRectF(at + _OFFSET, at + _OFFSET + QPointF(width, 24))

    def paint(self, painter: QPainter, at: QPointF, theme: Theme, *, hovered: bool) -> None:
        """Draw the plate next to ``at`` [px], with the force goal and arrows up and down."""
        text = f"{self._settings_editor.settings.force_goal:.1f}\u202fN"
        self._box = self.box(at, painter.font())
        _, figure = caption_fonts(painter.font())
        ink = QColor(theme.intent)
        painter.setPen(QPen(ink, 2.0 if hovered or self.held else 1.2))
        painter.setBrush(QColor(theme.panel))
        painter.drawRoundedRect(self._box, 4, 4)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setFont(figure)
        painter.setPen(QColor(theme.text))
        painter.drawText(self._box.adjusted(6, 0, -16, 0), Qt.AlignmentFlag.AlignCenter, text)
        painter.setPen(QPen(ink, 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        x = self._box.right() - 11
        y = self._box.center().y()
        for way in (-1, 1):
            painter.drawPolyline([QPointF(x + dx, y + way * dy) for dx, dy in ((-3.5, 3), (0, 6.5), (3.5, 3))])


def _stepped(force: float, steps: int) -> float:
    """Return the force changed by whole steps, rounded to steps and clamped to the valid range."""
    low, high = RANGES["force_goal"]
    return min(max(FORCE_STEP * (round(force / FORCE_STEP) + steps), low), high)


REACH_PX = 8.0


class ControlTool(ViewTool):
    """Tool that edits controller settings on the map or on the body, where a skin location means its map point.

    Args:
        settings_editor: Editor of the controller settings.
        parent: Qt parent.
    """

    def __init__(self, settings_editor: ControlSettingsEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings_editor = settings_editor
        self._plate = ForceHandle(settings_editor)
        self._place = PointerHit(None, None, 1.0)
        self._pixel: QPointF | None = None
        self._marks: ToolMarks | None = None
        settings_editor.changed.connect(self._redraw)

    @property
    def _map(self) -> TactileMap | None:
        """Map that can be drawn on; None while no arm can be controlled."""
        return self._settings_editor.map if self._settings_editor.enabled else None

    def _point(self, place: PointerHit) -> FloatArray | None:
        """Return the map point (2,) [m] under the pointer in either view; None next to the skin on the body.

        While no arm can be controlled, body locations are ignored: a shown recording may have another skin.
        """
        if place.point is not None or place.at is None or self._map is None:
            return place.point
        return self._map.to_map(place.at)

    def _at(self, place: PointerHit) -> SurfacePoint | None:
        return None if self._map is None else place.at

    def _on_plate(self, place: PointerHit, pixel: QPointF | None) -> bool:
        """Whether the force plate is under the pointer; it is only on the map."""
        return place.point is not None and pixel is not None and self._plate.holds(pixel)

    def _hover(self, place: PointerHit, event: QMouseEvent) -> None:
        self._place = place
        self._pixel = event.position()

    def wheel(self, place: PointerHit, event: QWheelEvent) -> bool:
        """Change the force with the wheel on the plate."""
        if self._map is None or not self._on_plate(place, event.position()):
            return False
        self._plate.roll(event.angleDelta().y())
        return True

    def key(self, event: QKeyEvent) -> bool:
        """Change the force with Page Up and Page Down."""
        return self._map is not None and self._plate.key(Qt.Key(event.key()))

    def cancel(self) -> bool:
        """Restore the force before the drag."""
        return self._plate.cancel()

    def leave(self) -> None:
        """Clear the pointer position."""
        self._place = PointerHit(None, None, 1.0)
        self._pixel = None
        self._redraw()

    def body_marks(self) -> ToolMarks:
        """Return the marks on the body; the same object until something changes."""
        if self._marks is None:
            self._marks = NO_MARKS if self._map is None else self._mark_body(self._map)
        return self._marks

    def _mark_body(self, map_: TactileMap) -> ToolMarks:
        return NO_MARKS

    def _redraw(self) -> None:
        self._marks = None
        self.drawn.emit()

    @property
    def _plate_at(self) -> FloatArray | None:
        """Map point (2,) [m] next to which the plate is drawn; None hides it."""
        return None

    def boxes(self, to_pixels: ToPixels, font: QFont) -> ToolBoxes:
        """Return the box of the plate."""
        at = self._plate_at
        return NO_BOXES if at is None else ToolBoxes([self._plate.box(_pixel(to_pixels, at), font)])

    def _paint_plate(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        at = self._plate_at
        if at is None:
            self._plate.hide()
            return
        hovered = self._on_plate(self._place, self._pixel)
        self._plate.paint(painter, _pixel(to_pixels, at), theme, hovered=hovered)


def _pixel(to_pixels: ToPixels, at: FloatArray) -> QPointF:
    return QPointF(*to_pixels(at[None])[0].tolist())
