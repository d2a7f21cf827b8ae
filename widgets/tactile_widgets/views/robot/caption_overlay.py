"""What lies over the robot, drawn by Qt: forces in words, the arrows' scale, the orientation cube, replaying or paused.

The cube in the corner says where x, y and z point, and turns the view; its visible faces are found without Qt.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.plane import cross
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.views.interaction.select_gesture import RubberBand, paint_rubber_band
from tactile_widgets.views.interaction.view_tool import ViewTool
from tactile_widgets.views.overlays.callouts import Callout, Spot, place_callouts

_NAMES = (("X", "\u2212X"), ("Y", "\u2212Y"), ("Z", "\u2212Z"))
_RING = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_LEGIBLE = 0.3


@dataclass(frozen=True, eq=False)
class CubeFace:
    """One face that looks at the eye.

    Attributes:
        corners: (4, 2) in half edges from the cube's middle, x to the right and y down.
        facing: 0 seen from the side, 1 seen straight on.
        name: Its axis, or nothing where it is too slanted to be read.
        normal: (3,) its axis with its sign, world frame.
    """

    corners: FloatArray
    facing: float
    name: str
    normal: FloatArray

    def holds(self, x: float, y: float) -> bool:
        """Whether a point in half edges from the cube's middle, y down, lies on it."""
        sides = np.roll(self.corners, -1, axis=0) - self.corners
        arms = np.array([x, y]) - self.corners
        turns = cross(sides, arms)
        return bool((turns >= 0).all() or (turns <= 0).all())


def cube_faces(axes: FloatArray) -> list[CubeFace]:
    """The faces of a cube along the world's axes that can be seen, parallel projection.

    Args:
        axes: (3, 3) rows right, up and forward of the picture, world frame.
    """
    faces = []
    for axis in range(3):
        for side, name in zip((1.0, -1.0), _NAMES[axis], strict=True):
            facing = -side * float(axes[2, axis])
            if facing <= 1e-6:
                continue
            corners = np.insert(_RING, axis, side, axis=1) @ axes[:2].T * [1.0, -1.0]
            faces.append(CubeFace(corners, facing, name if facing > _LEGIBLE else "", side * np.eye(3)[axis]))
    return faces


EDGE = 12.0
"""Distance of captions from the view's edge [px]."""
CUBE = 15.0
"""Half edge of the orientation cube [px]."""


@dataclass(frozen=True, eq=False)
class ForceCaption:
    """A contact's force in words.

    Attributes:
        arrow: (2, 2) tail and tip of its arrow [px].
        text: The words.
        away: Whether it presses on the side that looks away from the eye; said more quietly.
        radius: Around the arrow's tip, that no words may hide [px].
    """

    arrow: FloatArray
    text: str
    away: bool = False
    radius: float = 4.0


@dataclass(frozen=True, eq=False)
class Captions:
    """Everything said over the body at one instant.

    Attributes:
        forces: One for each arrow in front of the eye.
        legend: What the arrows' length means.
        axes: (3, 3) rows right, up and forward of the picture; None before there is one.
        replaying: Whether all this comes from a recording; said by the word and a coloured edge.
        paused: Whether time stands still; said by the word.
        hidden: How many links and objects are left out of the picture.
        rubber_band: What a gesture draws.
    """

    forces: tuple[ForceCaption, ...] = ()
    legend: str = ""
    axes: FloatArray | None = field(default=None)
    replaying: bool = False
    paused: bool = False
    hidden: int = 0
    rubber_band: RubberBand = field(default_factory=RubberBand)


class CaptionOverlay(QWidget):
    """A transparent sheet over the canvas; the mouse goes through it.

    Attributes:
        tool: May draw over everything; None for none.
        control: Where a control floats over the view; no words are written there.
    """

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self._theme = theme
        self._captions = Captions()
        self.tool: ViewTool | None = None
        self.control = QRectF()
        self.setObjectName("robot-overlay")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._caption, self._figure = QFont(self.font()), QFont(self.font())
        self._caption.setPixelSize(11)
        self._figure.setPixelSize(13)
        self._figure.setWeight(QFont.Weight.DemiBold)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self.update()

    def say(self, captions: Captions) -> None:
        """Show these captions."""
        self._captions = captions
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: captions, cube, edge."""
        painter = QPainter(self)
        said = self._captions
        room = QRectF(self.rect())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        inner = room.adjusted(EDGE, EDGE, -EDGE, -EDGE)
        seen = [force for force in said.forces if room.contains(QPointF(*force.arrow[1].tolist()))]
        for force, callout in zip(seen, place_callouts([self._spot(force) for force in seen], inner), strict=True):
            self._paint_force(painter, force, callout)
        if said.legend:
            self._paint_chip(painter, self.legend_box(said.legend).topLeft(), said.legend, self._caption, quiet=True)
        if said.axes is not None:
            self._paint_cube(painter, said.axes, self._cube_middle())
        paint_rubber_band(painter, said.rubber_band, self._theme)
        if self.tool is not None:
            painter.save()
            self.tool.paint_body(painter, self._theme)
            painter.restore()
        if said.replaying:
            pen = QPen(QColor(self._theme.accent), 3)
            pen.setJoinStyle(Qt.PenJoinStyle.MiterJoin)
            painter.setPen(pen)
            painter.drawRect(room.adjusted(1.5, 1.5, -1.5, -1.5))
        if said.replaying or said.paused:
            word = "Replaying" if said.replaying else "Paused"
            self._paint_chip(painter, QPointF(EDGE, EDGE), word, self._figure)
        if said.hidden:
            above = QFontMetricsF(self._figure).height() + 12 if said.replaying or said.paused else 0.0
            self._paint_chip(painter, QPointF(EDGE, EDGE + above), f"{said.hidden} hidden", self._caption, quiet=True)
        painter.end()

    def legend_box(self, text: str) -> QRectF:
        """Where the legend is written: in the lower left corner, above what floats there."""
        metrics = QFontMetricsF(self._caption)
        size = QSizeF(metrics.horizontalAdvance(text) + 12, metrics.height() + 4)
        box = QRectF(QPointF(EDGE, self.height() - EDGE - size.height()), size)
        return box.translated(0, self.control.top() - 4 - box.bottom()) if box.intersects(self.control) else box

    def cube_face_at(self, pixel: QPointF) -> CubeFace | None:
        """The face of the orientation cube under a pixel; None beside it."""
        if self._captions.axes is None:
            return None
        away = (pixel - self._cube_middle()) / CUBE
        return next((face for face in cube_faces(self._captions.axes) if face.holds(away.x(), away.y())), None)

    def near_cube(self, pixel: QPointF) -> bool:
        """Whether a pixel is where the orientation cube can be, however it is turned."""
        away = pixel - self._cube_middle()
        return self._captions.axes is not None and bool(np.hypot(away.x(), away.y()) < 2 * CUBE)

    def _cube_middle(self) -> QPointF:
        return QPointF(self.width() - 3 * CUBE, self.height() - 3 * CUBE)

    def _spot(self, force: ForceCaption) -> Spot:
        """Its words go beyond the arrow's tail if that is free, so that neither arrow nor touch is covered."""
        metrics = QFontMetricsF(self._figure)
        arrow = force.arrow
        half = 0.5 * np.array([metrics.horizontalAdvance(force.text) + 16, metrics.height() + 6])
        along = arrow[0] - arrow[1]
        length = float(np.linalg.norm(along))
        along = along / length if length > 4 else np.array([0.0, -1.0])
        clear = 6 + max(20.0 - length, 0.0) + float(np.min(half / np.maximum(np.abs(along), 1e-6)))
        clear = max(clear, force.radius + 6 - length)
        corner = QPointF(*(arrow[0] + clear * along - half).tolist())
        size = QSizeF(*(2 * half).tolist())
        return Spot(QPointF(*arrow[1].tolist()), force.radius, size, QRectF(corner, size))

    def _paint_force(self, painter: QPainter, force: ForceCaption, callout: Callout) -> None:
        if callout.leader is not None:
            painter.setPen(QPen(QColor(self._theme.quiet), 1))
            painter.drawLine(*callout.leader)
        self._paint_chip(painter, callout.box.topLeft(), force.text, self._figure, quiet=force.away)

    def _paint_chip(self, painter: QPainter, corner: QPointF, text: str, font: QFont, *, quiet: bool = False) -> None:
        metrics = QFontMetricsF(font)
        pad = 8.0 if font.pixelSize() > 11 else 6.0
        box = QRectF(corner.x(), corner.y(), metrics.horizontalAdvance(text) + 2 * pad, metrics.height() + pad - 2)
        ground = QColor(self._theme.panel)
        ground.setAlpha(225)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ground)
        painter.drawRoundedRect(box, 4, 4)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setFont(font)
        painter.setPen(QColor(self._theme.quiet if quiet else self._theme.text))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)

    def _paint_cube(self, painter: QPainter, axes: FloatArray, middle: QPointF) -> None:
        theme = self._theme
        painter.setFont(self._caption)
        for face in cube_faces(axes):
            corners = [QPointF(middle.x() + CUBE * x, middle.y() + CUBE * y) for x, y in face.corners.tolist()]
            painter.setPen(QPen(QColor(mixed(theme.panel, theme.quiet, 0.55)), 1))
            painter.setBrush(QColor(mixed(theme.panel, theme.quiet, 0.08 + 0.22 * face.facing)))
            painter.drawPolygon(QPolygonF(corners))
            x, y = (CUBE * np.mean(face.corners, axis=0)).tolist()
            box = QRectF(middle.x() + x - 20, middle.y() + y - 20, 40, 40)
            painter.setPen(QColor(theme.text))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, face.name)
        painter.setBrush(Qt.BrushStyle.NoBrush)
