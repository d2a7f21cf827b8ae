"""Posture tool: the user drags a link, and the joints follow within their limits."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QPainter

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import names_text
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.link_drag import LinkDrag, drag_link
from tactile_widgets.common.colours import Theme
from tactile_widgets.document.posture_editor import PostureEditor
from tactile_widgets.views.interaction.view_tool import PointerHit, ViewTool
from tactile_widgets.views.overlays.painting import draw_label

_REPORTED_DISTANCE = 0.003
"""Distance of the link from the pointer above which it is reported [m]."""


@dataclass(frozen=True, eq=False)
class _Grip:
    """Held link point, fixed at the press.

    Attributes:
        link: Name of the link.
        point: (3,) held point, link frame [m].
        pressed: (3,) point hit by the pointer, world frame [m].
        normal: (3,) normal of the plane, perpendicular to the line of sight, in which the pointer moves the point.
        start: (3,) held point in the target posture at the press, world frame [m].
    """

    link: str
    point: FloatArray
    pressed: FloatArray
    normal: FloatArray
    start: FloatArray


class PostureTool(ViewTool):
    """Tool that moves the link point under the pointer, parallel to the image plane. Mutable.

    Args:
        editor: Posture editor.
        parent: Qt parent.

    Attributes:
        words: Text next to the pointer; empty if there is none.
    """

    hint = "Drag a link: the joints follow within their limits, at once while paused. Escape cancels the drag."
    grabs_links = True

    def __init__(self, editor: PostureEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._grip: _Grip | None = None
        self._configuration: Configuration | None = None
        self._pixel = QPointF()
        self._hovered = ""
        self.words = ""

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Hold the link under the pointer if a joint moves it."""
        editor = self._editor
        hit = place.body
        if hit is None or not editor.enabled or editor.robot is None or hit.number >= len(editor.robot.links):
            return False
        link = editor.robot.links[hit.number].name
        configuration = Configuration(editor.robot)
        if not len(configuration.joints_before(link)):
            editor.notified.emit(f"No joint moves {link.replace('_', ' ')}")
            return False
        point = hit.rotation.T @ (hit.point - hit.origin)
        configuration.update(editor.target)
        self._configuration = configuration
        self._grip = _Grip(link, point, hit.point, hit.direction, configuration.pose(link).points(point))
        self._pixel = event.position()
        self.words = ""
        editor.begin(f"drag {link.replace('_', ' ')}")
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Move the held link, or highlight the link under the pointer."""
        self._pixel = event.position()
        if self._grip is not None and place.ray is not None:
            self._drag(self._grip, *place.ray)
        elif self._grip is None:
            self._hover(place)
        self.drawn.emit()

    def _hover(self, place: PointerHit) -> None:
        robot = self._editor.robot
        hit = place.body
        on_link = robot is not None and hit is not None and self._editor.enabled and hit.number < len(robot.links)
        self._hovered = robot.links[hit.number].name if on_link and robot is not None and hit is not None else ""
        self.words = self._hovered.replace("_", " ")

    def _drag(self, grip: _Grip, origin: FloatArray, direction: FloatArray) -> None:
        editor = self._editor
        across = float(direction @ grip.normal)
        if self._configuration is None or across < 1e-3:
            return
        pointed = origin + direction * float((grip.pressed - origin) @ grip.normal) / across
        goal = grip.start + pointed - grip.pressed
        drag = drag_link(self._configuration, grip.link, grip.point, goal, editor.target, editor.lower, editor.upper)
        self.words = self._words_for(drag)
        editor.change(drag.posture)

    def _words_for(self, drag: LinkDrag) -> str:
        """Return why the link does not reach the pointer; empty if it does."""
        robot = self._editor.robot
        if drag.away < _REPORTED_DISTANCE or robot is None:
            return ""
        far = f"{1e3 * drag.away:.0f}\u202fmm short"
        if not drag.stuck:
            return f"Out of reach, {far}"
        names = [robot.joints[joint].name.replace("_", " ") for joint in drag.stuck]
        return f"At its limit: {names_text(names, 2)}, {far}"

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """End the drag as one undo step."""
        held = self._grip is not None
        self._grip = None
        if held:
            if self.words:
                self._editor.notified.emit(self.words)
            self.words = ""
            self._editor.end()
        self.drawn.emit()

    def cancel(self) -> bool:
        """Restore the target posture before the drag."""
        held = self._grip is not None
        self._grip = None
        self.words = ""
        if held:
            self._editor.cancel()
        self.drawn.emit()
        return held

    def leave(self) -> None:
        """Clear the highlighted link."""
        if self._grip is None:
            self._hovered = self.words = ""
            self.drawn.emit()

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw the name of the link under the pointer, or why it does not reach the pointer."""
        if self.words:
            draw_label(painter, self.words, theme, at=self._pixel)

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return a hand cursor over links that can be dragged."""
        if self._grip is not None:
            return Qt.CursorShape.ClosedHandCursor
        return Qt.CursorShape.PointingHandCursor if self._hovered else Qt.CursorShape.OpenHandCursor
