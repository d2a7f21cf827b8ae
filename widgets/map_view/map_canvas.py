"""A graphics view moved by a camera: zoom at the pointer, pan, framing that survives a resize. Knows no tactile map.

``MapCamera`` is what the viewport shows, as a frozen value without Qt; zoom 1 frames the whole map.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QKeyEvent, QResizeEvent, QTransform, QWheelEvent
from PySide6.QtWidgets import QFrame, QGraphicsScene, QGraphicsView, QWidget

from app.core.arrays import FloatArray

MARGIN_PX = 36.0
LOWEST_ZOOM, HIGHEST_ZOOM = 0.5, 60.0

Point = tuple[float, float]


@dataclass(frozen=True)
class MapCamera:
    """Which scene point is at the viewport's centre, and how much larger than framed it is drawn.

    Because zoom is relative to the framing, a resized viewport keeps showing the same part of the map.

    Attributes:
        content: Width and height of what there is to see [scene units].
        centre: Scene point at the viewport's centre.
        zoom: 1 frames the whole content.
        origin: Upper left corner of the content [scene units].
    """

    content: Point
    centre: Point
    zoom: float = 1.0
    origin: Point = (0.0, 0.0)

    @classmethod
    def framing(cls, content: Point, origin: Point = (0.0, 0.0)) -> MapCamera:
        """The camera that frames all of ``content``."""
        return cls(content, (origin[0] + content[0] / 2, origin[1] + content[1] / 2), origin=origin)

    def over(self, content: Point, origin: Point, viewport: Point) -> MapCamera:
        """The same picture in a ``viewport``, of a content that is no longer what it was."""
        other = replace(self, content=content, origin=origin, zoom=1.0)
        return replace(other, zoom=self.scale(viewport) / other.scale(viewport))

    def scale(self, viewport: Point) -> float:
        """Pixels per scene unit in a ``viewport`` of this width and height [px]; the aspect is kept."""
        room = (max(viewport[0] - 2 * MARGIN_PX, 1.0), max(viewport[1] - 2 * MARGIN_PX, 1.0))
        return self.zoom * min(room[0] / max(self.content[0], 1e-9), room[1] / max(self.content[1], 1e-9))

    def to_scene(self, pixel: Point, viewport: Point) -> Point:
        """The scene point under a pixel."""
        scale = self.scale(viewport)
        return (
            self.centre[0] + (pixel[0] - viewport[0] / 2) / scale,
            self.centre[1] + (pixel[1] - viewport[1] / 2) / scale,
        )

    def zoomed(self, factor: float, pixel: Point, viewport: Point) -> MapCamera:
        """Zoom by ``factor`` so that the scene point under ``pixel`` stays there, as long as it lies on the map."""
        anchor = self.to_scene(pixel, viewport)
        zoom = min(max(self.zoom * factor, min(LOWEST_ZOOM, self.zoom)), max(HIGHEST_ZOOM, self.zoom))
        ratio = self.zoom / zoom
        moved = (
            anchor[0] + (self.centre[0] - anchor[0]) * ratio,
            anchor[1] + (self.centre[1] - anchor[1]) * ratio,
        )
        return self._looking_at(moved, zoom)

    def panned(self, dx: float, dy: float, viewport: Point) -> MapCamera:
        """Drag the map by this many pixels; the centre never leaves the map, so it cannot get lost."""
        scale = self.scale(viewport)
        return self._looking_at((self.centre[0] - dx / scale, self.centre[1] - dy / scale), self.zoom)

    def _looking_at(self, centre: Point, zoom: float) -> MapCamera:
        # An edit may have taken the map away from under the centre: it goes no farther out, and is not pulled back.
        low = [min(start, now) for start, now in zip(self.origin, self.centre, strict=True)]
        ends = [start + size for start, size in zip(self.origin, self.content, strict=True)]
        high = [max(end, now) for end, now in zip(ends, self.centre, strict=True)]
        x, y = (min(max(centre[k], low[k]), high[k]) for k in range(2))
        return replace(self, centre=(x, y), zoom=zoom)


WHEEL_STEP = 1.2
"""Zoom of one notch of the wheel, or one press of plus."""
KEY_PAN_PX = 40.0
_PAN_KEYS = {
    Qt.Key.Key_Left: (KEY_PAN_PX, 0.0),
    Qt.Key.Key_Right: (-KEY_PAN_PX, 0.0),
    Qt.Key.Key_Up: (0.0, KEY_PAN_PX),
    Qt.Key.Key_Down: (0.0, -KEY_PAN_PX),
}
_ZOOM_KEYS = {Qt.Key.Key_Plus: WHEEL_STEP, Qt.Key.Key_Equal: WHEEL_STEP, Qt.Key.Key_Minus: 1 / WHEEL_STEP}


class MapCanvas(QGraphicsView):
    """Shows a scene whose content the camera knows."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.camera = MapCamera.framing((1000.0, 1000.0))
        self.setScene(QGraphicsScene(self))
        self.setInteractive(False)
        self.setAcceptDrops(False)  # a file dropped here is the window's
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTransformationAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setResizeAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.viewport().setMouseTracking(True)

    def show_scene(self, scene: QGraphicsScene, size: tuple[float, float]) -> None:
        """Show another scene of this size, framed; the previous one is deleted."""
        previous = self.scene()
        self.setScene(scene)
        previous.deleteLater()
        self.look(MapCamera.framing(size))

    def look(self, camera: MapCamera) -> None:
        """Look through ``camera``."""
        self.camera = camera
        scale = camera.scale(self._room())
        self.setTransform(QTransform.fromScale(scale, scale))
        # Room around the centre only: a patch moved far away would be more than scroll bars can count.
        reach = max(self._room()) / scale + 1.0
        self.setSceneRect(camera.centre[0] - reach, camera.centre[1] - reach, 2 * reach, 2 * reach)
        self.centerOn(*camera.centre)
        # Scrolling is in whole pixels; the transform carries the rest, so that the camera is met exactly.
        width, height = self._room()
        rest = QPointF(width / 2, height / 2) - self.viewportTransform().map(QPointF(*camera.centre))
        self.setTransform(QTransform(scale, 0, 0, scale, rest.x(), rest.y()))
        self.viewport().update()

    def frame_all(self) -> None:
        """Frame the whole content."""
        self.look(MapCamera.framing(self.camera.content, self.camera.origin))

    def set_content(self, bounds: FloatArray) -> None:
        """There is something else to see, within (2, 2) scene points; what is in view stays there."""
        low, high = np.asarray(bounds)
        size = float(high[0] - low[0]), float(high[1] - low[1])
        self.look(self.camera.over(size, (float(low[0]), float(low[1])), self._room()))

    def pan(self, dx: float, dy: float) -> None:
        """Drag the content by pixels."""
        self.look(self.camera.panned(dx, dy, self._room()))

    def zoom(self, factor: float, at: QPointF) -> None:
        """Zoom so that what lies under the viewport point ``at`` stays there."""
        self.look(self.camera.zoomed(factor, (at.x(), at.y()), self._room()))

    def scene_point(self, position: QPointF) -> QPointF:
        """The scene point under a viewport position, finer than a pixel."""
        inverse, _ = self.viewportTransform().inverted()
        return inverse.map(position)

    def _room(self) -> tuple[float, float]:
        return float(self.viewport().width()), float(self.viewport().height())

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: zoom at the pointer."""
        notches = event.angleDelta().y() / 120
        if notches:
            self.zoom(WHEEL_STEP**notches, event.position())
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: F frames all, plus and minus zoom, arrows pan."""
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_F:
            self.frame_all()
        elif key in _ZOOM_KEYS:
            self.zoom(_ZOOM_KEYS[key], QPointF(self.viewport().rect().center()))
        elif key in _PAN_KEYS:
            self.pan(*_PAN_KEYS[key])
        else:
            event.ignore()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: keep showing the same part of the content."""
        super().resizeEvent(event)
        self.look(self.camera)
