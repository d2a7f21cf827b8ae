"""Marks and texts painted over the views."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from tactile_widgets.common.colours import LIGHT
from tactile_widgets.views.overlays.painting import paint_state, state_chips


def test_mode_has_more_contrast_than_counts(qapp):
    image = QImage(300, 60, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.white)
    state = {"replaying": False, "paused": True, "counts": ["2 links hidden"]}
    painter = QPainter(image)
    paint_state(painter, QRectF(image.rect()), LIGHT, **state)
    boxes = [box.toRect() for box, _, _ in state_chips(painter.font(), **state)]
    painter.end()
    mode, counts = (
        min(image.pixelColor(x, y).lightness() for x in range(box.left(), box.right()) for y in range(20, 30))
        for box in boxes
    )
    assert mode < counts - 20
