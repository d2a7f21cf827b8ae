"""A graphics view moved by a camera: zoom at the pointer, pan, framing that survives a resize. Knows no tactile map."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QKeyEvent, QResizeEvent, QTransform, QWheelEvent
from PySide6.QtWidgets import QFrame, QGraphicsScene, QGraphicsView, QWidget

from app.arrays import FloatArray
from widgets.map_view.camera import Camera

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
        self.camera = Camera.framing((1000.0, 1000.0))
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
        self.look(Camera.framing(size))

    def look(self, camera: Camera) -> None:
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
        self.look(Camera.framing(self.camera.content, self.camera.origin))

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
