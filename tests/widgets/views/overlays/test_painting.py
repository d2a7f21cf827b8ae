"""Marks and texts painted over the views."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from tactile_widgets.common.colours import LIGHT
from tactile_widgets.views.overlays.body_overlays import MarkRole
from tactile_widgets.views.overlays.painting import PAUSED, draw_lines, paint_state, state_chips


def test_mode_has_more_contrast_than_counts(qapp):
    image = QImage(300, 60, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.white)
    counts = ["2 links hidden"]
    painter = QPainter(image)
    paint_state(painter, QRectF(image.rect()), LIGHT, PAUSED, counts)
    boxes = [box.toRect() for box, _, _ in state_chips(painter.font(), PAUSED, counts)]
    painter.end()
    mode, counts = (
        min(image.pixelColor(x, y).lightness() for x in range(box.left(), box.right()) for y in range(20, 30))
        for box in boxes
    )
    assert mode < counts - 20


@pytest.mark.parametrize("role", MarkRole)
def test_only_dashed_roles_have_gaps(qapp, role):
    image = QImage(200, 40, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.white)
    painter = QPainter(image)
    draw_lines(painter, [np.array([[10.0, 20.0], [190.0, 20.0]])], role, LIGHT)
    painter.end()
    colours = [image.pixel(x, 20) for x in range(20, 180)]
    assert (len(set(colours)) > 1) == role.dashed
