"""Pixels of what is drawn alike in frame after frame: copying them costs a tenth of drawing fine dots and dashes."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QPaintEngine, QPainter, QPixmap, QTransform


class PaintCache:
    """One drawing, copied from its pixels while neither it nor the view of it changes. Mutable.

    Files of lines and words, such as PDF and SVG, get the lines.

    Args:
        at_once: Whether it is drawn by way of its pixels from the first time on, so that it never differs by a rounding
            of its rim; else from the second time that it is drawn alike, so that a view that is being moved pays
            nothing for it.
    """

    def __init__(self, *, at_once: bool = False) -> None:
        self._at_once = at_once
        self._last: tuple[object, ...] | None = None
        self._pixels: QPixmap | None = None

    def paint(self, painter: QPainter, content: object, bounds: QRectF, draw: Callable[[QPainter], None]) -> None:
        """Draw, or copy what was drawn.

        Args:
            painter: Where; its transform is the view.
            content: All that ``draw`` depends on but the view; equal where it draws the same.
            bounds: Around all of it, in the coordinates of ``draw``.
            draw: Draws it; sets pen and hints itself.
        """
        if painter.paintEngine().type() is not QPaintEngine.Type.Raster:
            draw(painter)
            return
        device = painter.device()
        ratio, size = device.devicePixelRatio(), (device.width(), device.height())
        now = (content, painter.worldTransform(), bounds, size, ratio)
        if now != self._last:
            self._last, self._pixels = now, None
            if not self._at_once:
                draw(painter)
                return
        view = painter.worldTransform() * QTransform.fromScale(ratio, ratio)
        room = QRectF(0, 0, ratio * size[0], ratio * size[1])
        area = view.mapRect(bounds).intersected(room).toAlignedRect()
        if area.isEmpty():
            return
        if self._pixels is None:
            self._pixels = _draw_pixels(painter.worldTransform(), area, ratio, draw)
        painter.save()
        painter.resetTransform()
        painter.drawPixmap(QPointF(area.topLeft()) / ratio, self._pixels)
        painter.restore()


def _draw_pixels(view: QTransform, area: QRect, ratio: float, draw: Callable[[QPainter], None]) -> QPixmap:
    """What ``draw`` draws of a view within ``area``, in the pixels of the device."""
    pixels = QPixmap(area.size())
    pixels.setDevicePixelRatio(ratio)
    pixels.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixels)
    painter.setTransform(view * QTransform.fromTranslate(-area.left() / ratio, -area.top() / ratio))
    draw(painter)
    painter.end()
    return pixels
