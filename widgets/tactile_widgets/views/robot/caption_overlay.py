"""Captions over the robot, painted by Qt: forces, scale of the arrows, orientation cube, state.

The cube in the corner shows the directions of x, y and z, and turns the view; its visible faces are found without Qt.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.plane import cross
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.views.interaction.select_gesture import RubberBand, paint_rubber_band
from tactile_widgets.views.interaction.view_tool import ViewTool
from tactile_widgets.views.overlays.callouts import Callout, Spot, more_contacts, place_callouts
from tactile_widgets.views.overlays.legend import Legend
from tactile_widgets.views.overlays.painting import (
    EDGE,
    PRESENT,
    ViewState,
    caption_fonts,
    chip_size,
    paint_chip,
    paint_state,
    polygon,
    state_chips,
)
from tactile_widgets.views.overlays.shear_arrows import draw_arrows

_NAMES = (("X", "\u2212X"), ("Y", "\u2212Y"), ("Z", "\u2212Z"))
_RING = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_LEGIBLE = 0.3


@dataclass(frozen=True, eq=False)
class CubeFace:
    """Visible face of the orientation cube.

    Attributes:
        corners: (4, 2) in half edges from the cube's centre, x to the right and y down.
        facing: 0 if seen from the side, 1 if seen straight on.
        name: Name of its axis; empty if it is too slanted to be legible.
        normal: (3,) signed axis, world frame.
    """

    corners: FloatArray
    facing: float
    name: str
    normal: FloatArray

    def holds(self, x: float, y: float) -> bool:
        """Whether a point in half edges from the cube's centre, y down, is on this face."""
        sides = np.roll(self.corners, -1, axis=0) - self.corners
        arms = np.array([x, y]) - self.corners
        turns = cross(sides, arms)
        return bool((turns >= 0).all() or (turns <= 0).all())


def cube_faces(axes: FloatArray) -> list[CubeFace]:
    """Return the visible faces of a cube along the world's axes, in parallel projection.

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


CUBE = 15.0
"""Half edge of the orientation cube [px]."""


@dataclass(frozen=True, eq=False)
class ForceCaption:
    """Force of a contact as a caption.

    Attributes:
        arrow: (2, 2) tail and tip of its arrow [px].
        text: The caption.
        away: Whether the contact is on the far side of the body, which gives a quieter colour.
        radius: Radius around the arrow's tip that no caption may cover [px].
    """

    arrow: FloatArray
    text: str
    away: bool = False
    radius: float = 4.0


@dataclass(frozen=True, eq=False)
class Captions:
    """All captions over the body at one instant.

    Attributes:
        forces: One for the arrow of each of the strongest contacts that is in front of the camera.
        legend: Meaning of the arrows' length.
        axes: (3, 3) rows right, up and forward of the picture; None before the first picture.
        state: State of the view, such as paused or replaying.
        hidden: Number of hidden links and objects.
        contacts: Number of contacts, of which the strongest have a caption.
        rubber_band: Outline of a selection gesture.
        arrows: (k, 2, 2) tail and tip of the arrows of layers [px].
        layers: Legends of layers.
    """

    forces: tuple[ForceCaption, ...] = ()
    legend: str = ""
    axes: FloatArray | None = field(default=None)
    state: ViewState = PRESENT
    hidden: int = 0
    contacts: int = 0
    rubber_band: RubberBand = field(default_factory=RubberBand)
    arrows: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 2)))
    layers: tuple[Legend, ...] = ()


class CaptionOverlay(QWidget):
    """Transparent widget over the canvas that ignores the mouse.

    Attributes:
        tool: Tool that may draw over everything; None without one.
        control: Box of a control that floats over the view; no caption covers it.
        cube_shown: Whether the orientation cube is shown.
    """

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self._theme = theme
        self._captions = Captions()
        self.tool: ViewTool | None = None
        self.control = QRectF()
        self.cube_shown = True
        self.setObjectName("robot-overlay")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._caption, self._figure = caption_fonts(self.font())

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        self._theme = theme
        self.update()

    def show_captions(self, captions: Captions) -> None:
        """Show these captions."""
        self._captions = captions
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        shown = self._captions
        theme = self._theme
        room = QRectF(self.rect())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw_arrows(painter, shown.arrows)
        for force, callout in self.callouts():
            if callout.leader is not None:
                painter.setPen(QPen(QColor(theme.quiet), 1))
                painter.drawLine(*callout.leader)
            ink = theme.quiet if force.away else theme.text
            paint_chip(painter, callout.box, force.text, self._figure, ink, theme.panel)
        if shown.legend:
            self._paint_quiet(painter, self.legend_box(shown.legend), shown.legend)
        for legend, box in self._legends():
            legend.paint(painter, box, self._caption, theme)
        if self._axes is not None:
            self._paint_cube(painter, self._axes, self._cube_middle())
        paint_rubber_band(painter, shown.rubber_band, theme)
        if self.tool is not None:
            painter.save()
            self.tool.paint_body(painter, theme)
            painter.restore()
        paint_state(painter, room, theme, shown.state, self._counts())
        painter.end()

    def _counts(self) -> tuple[str, ...]:
        hidden = self._captions.hidden
        return (*([f"{hidden} hidden"] if hidden else []), *more_contacts(self._captions.contacts))

    def caption_boxes(self) -> list[QRectF]:
        """Return the boxes of all captions except those of forces, and of the cube and the control over the view."""
        shown = self._captions
        state = state_chips(self.font(), shown.state, self._counts())
        return [
            *(box for box, *_ in state),
            *([self.legend_box(shown.legend)] if shown.legend else []),
            *(box for _, box in self._legends()),
            *([self.cube_box] if self._axes is not None else []),
            self.control,
        ]

    def callouts(self) -> list[tuple[ForceCaption, Callout]]:
        """Return the captions of forces in view, and their places."""
        room = QRectF(self.rect())
        seen = [force for force in self._captions.forces if room.contains(QPointF(*force.arrow[1].tolist()))]
        inner = room.adjusted(EDGE, EDGE, -EDGE, -EDGE)
        placed = place_callouts([self._spot(force) for force in seen], inner, self.caption_boxes() if seen else [])
        return list(zip(seen, placed, strict=True))

    def _paint_quiet(self, painter: QPainter, box: QRectF, text: str) -> None:
        paint_chip(painter, box, text, self._caption, self._theme.quiet, self._theme.panel)

    def legend_box(self, text: str) -> QRectF:
        """Return the box of the legend in the lower left corner, above a control and the cube if it would meet them."""
        size = chip_size(text, self._caption)
        box = QRectF(QPointF(EDGE, self.height() - EDGE - size.height()), size)
        for other in (self.control, *([self.cube_box] if self._axes is not None else [])):
            if box.intersects(other):
                box.moveBottom(other.top() - 4)
        return box

    def _legends(self) -> list[tuple[Legend, QRectF]]:
        """Legends of layers and their boxes, one above the other over the legend of forces."""
        bottom = self.legend_box(self._captions.legend or " ").top() - 4
        placed = []
        for legend in self._captions.layers:
            size = legend.size(self._caption)
            placed.append((legend, QRectF(QPointF(EDGE, bottom - size.height()), size)))
            bottom -= size.height() + 4
        return placed

    def cube_face_at(self, pixel: QPointF) -> CubeFace | None:
        """Return the face of the orientation cube under a pixel; None next to the cube."""
        if self._axes is None:
            return None
        away = (pixel - self._cube_middle()) / CUBE
        return next((face for face in cube_faces(self._axes) if face.holds(away.x(), away.y())), None)

    def near_cube(self, pixel: QPointF) -> bool:
        """Whether a pixel is where the orientation cube can be in any orientation."""
        away = pixel - self._cube_middle()
        return self._axes is not None and bool(np.hypot(away.x(), away.y()) < 2 * CUBE)

    @property
    def cube_box(self) -> QRectF:
        """Box of the orientation cube in any orientation."""
        box = QRectF(0, 0, 4 * CUBE, 4 * CUBE)
        box.moveCenter(self._cube_middle())
        return box

    @property
    def _axes(self) -> FloatArray | None:
        """Directions of the orientation cube; None if it is not shown."""
        return self._captions.axes if self.cube_shown else None

    def cube_covers(self, pixels: FloatArray) -> bool:
        """Whether the orientation cube, if it is shown, would cover one of the pixels (k, 2)."""
        axes = self._captions.axes
        away = (pixels - np.array(self._cube_middle().toTuple())) / CUBE
        near = away[np.hypot(*away.T) < np.sqrt(3)].tolist()
        return axes is not None and any(face.holds(x, y) for face in cube_faces(axes) for x, y in near)

    def _cube_middle(self) -> QPointF:
        return QPointF(self.width() - 3 * CUBE, self.height() - 3 * CUBE)

    def _spot(self, force: ForceCaption) -> Spot:
        """Prefer the place beyond the arrow's tail, where the caption covers neither arrow nor touch."""
        arrow = force.arrow
        size = chip_size(force.text, self._figure)
        half = 0.5 * np.array(size.toTuple())
        along = arrow[0] - arrow[1]
        length = float(np.linalg.norm(along))
        along = along / length if length > 4 else np.array([0.0, -1.0])
        clear = 6 + max(20.0 - length, 0.0) + float(np.min(half / np.maximum(np.abs(along), 1e-6)))
        clear = max(clear, force.radius + 6 - length)
        corner = QPointF(*(arrow[0] + clear * along - half).tolist())
        return Spot(QPointF(*arrow[1].tolist()), force.radius, size, QRectF(corner, size))

    def _paint_cube(self, painter: QPainter, axes: FloatArray, middle: QPointF) -> None:
        theme = self._theme
        painter.setFont(self._caption)
        for face in cube_faces(axes):
            painter.setPen(QPen(QColor(mixed(theme.panel, theme.quiet, 0.55)), 1))
            painter.setBrush(QColor(mixed(theme.panel, theme.quiet, 0.08 + 0.22 * face.facing)))
            painter.drawPolygon(polygon(CUBE * face.corners + middle.toTuple()))
            x, y = (CUBE * np.mean(face.corners, axis=0)).tolist()
            box = QRectF(middle.x() + x - 20, middle.y() + y - 20, 40, 40)
            painter.setPen(QColor(theme.text))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, face.name)
        painter.setBrush(Qt.BrushStyle.NoBrush)
