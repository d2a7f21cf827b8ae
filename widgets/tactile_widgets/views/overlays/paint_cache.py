"""Cache of painted pixels: copying them takes a tenth of the time of drawing fine dots and dashes."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QPaintEngine, QPainter, QPixmap, QTransform


class PaintCache:
    """Copies a drawing from its pixels while neither the drawing nor the view changes.

    Vector files, such as PDF and SVG, receive the drawing itself.

    Args:
        at_once: Whether the first drawing is cached too, so that the rounding of its rim never differs; if not, the
            cache starts with the second equal drawing, so that it costs nothing while the view moves.
    """

    def __init__(self, *, at_once: bool = False) -> None:
        self._at_once = at_once
        self._last: tuple[object, ...] | None = None
        self._pixels: QPixmap | None = None

    def paint(
        self,
        painter: QPainter,
        content: object,
        bounds: QRectF,
        draw: Callable[[QPainter], None],
        *,
        changed: QRectF | None = None,
    ) -> None:
        """Draw, or copy the pixels of the previous drawing.

        Args:
            painter: Painter; its transform is the view.
            content: Everything that ``draw`` depends on except the view; equal for equal drawings.
            bounds: Bounds of the drawing, in the coordinates of ``draw``.
            draw: Draws it; sets pen and hints itself.
            changed: Rectangle outside of which new content equals the previous one, in the coordinates of ``draw``;
                None if it may differ everywhere.
        """
        if painter.paintEngine().type() is not QPaintEngine.Type.Raster:
            draw(painter)
            return
        device = painter.device()
        ratio = device.devicePixelRatio()
        size = (device.width(), device.height())
        now = (content, painter.worldTransform(), bounds, size, ratio)
        known = now == self._last
        if not known:
            if changed is None or self._last is None or now[1:] != self._last[1:]:
                self._pixels = None
            self._last = now
            if not self._at_once:
                draw(painter)
                return
        view = painter.worldTransform() * QTransform.fromScale(ratio, ratio)
        room = QRectF(0, 0, ratio * size[0], ratio * size[1])
        area = view.mapRect(bounds).intersected(room).toAlignedRect()
        if area.isEmpty():
            return
        if self._pixels is None:
            self._pixels = QPixmap(area.size())
            self._pixels.setDevicePixelRatio(ratio)
            self._pixels.fill(Qt.GlobalColor.transparent)
            _draw_pixels(self._pixels, area, painter.worldTransform(), area.topLeft(), draw)
        elif not known and changed is not None:
            part = view.mapRect(changed).toAlignedRect().adjusted(-1, -1, 1, 1)
            # Whole rows, because Qt accumulates rounding errors from a row's first pixel on.
            part = QRect(area.left(), part.top(), area.width(), part.height()) & area
            _draw_pixels(self._pixels, part, painter.worldTransform(), area.topLeft(), draw)
        painter.save()
        painter.resetTransform()
        painter.drawPixmap(QPointF(area.topLeft()) / ratio, self._pixels)
        painter.restore()


def _draw_pixels(
    pixels: QPixmap, part: QRect, view: QTransform, origin: QPoint, draw: Callable[[QPainter], None]
) -> None:
    """Draw a ``part`` of the view into ``pixels``, whose first pixel is at ``origin``; both in pixels of the device."""
    ratio = pixels.devicePixelRatio()
    painter = QPainter(pixels)
    there = QRectF(part.translated(-origin))
    painter.setClipRect(QRectF(there.topLeft() / ratio, there.size() / ratio))
    painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_Clear)
    painter.fillRect(painter.clipBoundingRect(), Qt.GlobalColor.transparent)
    painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_SourceOver)
    painter.setTransform(view * QTransform.fromTranslate(-origin.x() / ratio, -origin.y() / ratio))
    draw(painter)
    painter.end()
