"""The tool for the posture: a link is dragged, and the joints follow as far as their limits let them."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QPainter

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.link_drag import LinkDrag, drag_link
from tactile_widgets.common.colours import Theme
from tactile_widgets.document.posture_editor import PostureEditor
from tactile_widgets.views.interaction.view_tool import PointerHit, ViewTool
from tactile_widgets.views.overlays.painting import draw_label

_TOLD_FROM = 0.003
"""A link that stays behind by more than this is said to [m]."""


@dataclass(frozen=True, eq=False)
class _Grip:
    """What is held, from the press on.

    Attributes:
        link: Its name.
        point: (3,) of it, link frame [m].
        pressed: (3,) where the pointer met it, world [m].
        normal: (3,) of the plane across the line of sight in which the pointer leads it.
        start: (3,) where the point is in the posture that was wanted then, world [m].
    """

    link: str
    point: FloatArray
    pressed: FloatArray
    normal: FloatArray
    start: FloatArray


class PostureTool(ViewTool):
    """Leads the place of a link under the pointer, parallel to the picture. Mutable.

    Args:
        editor: Of the posture.
        parent: Qt parent.

    Attributes:
        words: What is said beside the pointer; empty for nothing.
    """

    hint = (
        "Drag a link: the joints follow within their limits. While paused the robot is placed, else it goes there. "
        "Escape gives the drag up, Undo takes it back."
    )
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
        """On a link that moves: hold it there."""
        editor = self._editor
        hit = place.body
        if hit is None or not editor.enabled or editor.robot is None or hit.number >= len(editor.robot.links):
            return False
        link = editor.robot.links[hit.number].name
        configuration = Configuration(editor.robot)
        if not len(configuration.joints_before(link)):
            editor.told.emit(f"No joint moves {link.replace('_', ' ')}")
            return False
        point = hit.rotation.T @ (hit.point - hit.origin)
        configuration.update(editor.wanted)
        self._configuration = configuration
        self._grip = _Grip(link, point, hit.point, hit.direction, configuration.pose(link).points(point))
        self._pixel = event.position()
        self.words = ""
        editor.begin(f"drag {link.replace('_', ' ')}")
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """The link follows the pointer."""
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
        answer = drag_link(self._configuration, grip.link, grip.point, goal, editor.wanted, editor.lower, editor.upper)
        self.words = self._words_for(answer)
        editor.change(answer.posture)

    def _words_for(self, answer: LinkDrag) -> str:
        """Why it is not where it is wanted; empty where it is."""
        robot = self._editor.robot
        if answer.away < _TOLD_FROM or robot is None:
            return ""
        far = f"{1e3 * answer.away:.0f}\u202fmm short"
        if not answer.stuck:
            return f"Out of reach, {far}"
        names = ", ".join(robot.joints[joint].name.replace("_", " ") for joint in answer.stuck[:2])
        more = f" and {len(answer.stuck) - 2} more" if len(answer.stuck) > 2 else ""
        return f"At its limit: {names}{more}, {far}"

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """All of it is one step."""
        held = self._grip is not None
        self._grip = None
        if held:
            if self.words:
                self._editor.told.emit(self.words)
            self.words = ""
            self._editor.end()
        self.drawn.emit()

    def cancel(self) -> bool:
        """The posture wanted as it was before the drag."""
        held = self._grip is not None
        self._grip = None
        self.words = ""
        if held:
            self._editor.cancel()
        self.drawn.emit()
        return held

    def leave(self) -> None:
        """Nothing is under the pointer."""
        if self._grip is None:
            self._hovered = self.words = ""
            self.drawn.emit()

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """The link's name under the pointer, or why it stays behind."""
        if self.words:
            draw_label(painter, self.words, theme, at=self._pixel)

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """A hand over what can be dragged."""
        if self._grip is not None:
            return Qt.CursorShape.ClosedHandCursor
        return Qt.CursorShape.PointingHandCursor if self._hovered else Qt.CursorShape.OpenHandCursor
