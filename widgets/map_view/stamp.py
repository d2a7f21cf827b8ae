"""A part of a picture that seldom changes, kept in pixels: drawn again only when what it shows is something else."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QPainter, QPixmap


class Stamp:
    """Mutable; knows the last picture only."""

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._box, self._pixmap = QRectF(), QPixmap()

    def paint(
        self, painter: QPainter, key: tuple[object, ...], draw: Callable[[QPainter], QRectF], room: QRectF
    ) -> QRectF:
        """Draw it, by ``draw`` where ``key`` or the display's scale is another one than the last time.

        Args:
            painter: Of the viewport.
            key: Compared by identity or value with the last one.
            draw: Draws on a painter in the viewport's pixels, and returns the box that holds all of it.
            room: The viewport; what lies outside is cut off.

        Returns:
            The box.
        """
        ratio = painter.device().devicePixelRatioF()
        now = (*key, ratio, room.width(), room.height())
        if len(now) != len(self._key) or any(a is not b and a != b for a, b in zip(now, self._key, strict=True)):
            self._key, (self._box, self._pixmap) = now, _drawn(draw, room, ratio)
        painter.drawPixmap(self._box.topLeft(), self._pixmap)
        return self._box


def _drawn(draw: Callable[[QPainter], QRectF], room: QRectF, ratio: float) -> tuple[QRectF, QPixmap]:
    whole = QPixmap((room.size() * ratio).toSize())
    whole.setDevicePixelRatio(ratio)
    whole.fill(Qt.GlobalColor.transparent)
    painter = QPainter(whole)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    box = draw(painter).intersected(room).toAlignedRect()
    painter.end()
    cut = QRectF(box.x() * ratio, box.y() * ratio, box.width() * ratio, box.height() * ratio).toRect()
    return QRectF(box), whole.copy(cut)
