"""A cached drawing is identical to a new one, and it is drawn again after any change."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from PySide6.QtCore import QBuffer, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QTransform
from PySide6.QtSvg import QSvgGenerator

from tactile_widgets.views.overlays.paint_cache import PaintCache

BOUNDS = QRectF(-30, -20, 60, 40)


class Dots:
    """Antialiased dots and a dashed line; counts how often it is drawn."""

    def __init__(self) -> None:
        self.drawn = 0

    def draw(self, painter: QPainter) -> None:
        self.drawn += 1
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pen = QPen(QColor(29, 33, 38, 70), 2.2)
        pen.setCosmetic(True)
        painter.setPen(pen)
        painter.drawPoints([QPointF(7.3 * k - 28, 5.1 * (k % 5) - 11) for k in range(8)])
        pen.setStyle(Qt.PenStyle.DashLine)
        painter.setPen(pen)
        painter.drawLine(QPointF(-29, -19), QPointF(29, 19))


def _picture(ratio: float, view: QTransform, paint) -> np.ndarray:
    image = QImage(round(200 * ratio), round(150 * ratio), QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(ratio)
    image.fill(QColor("#dfe3e7"))
    painter = QPainter(image)
    painter.setTransform(view)
    paint(painter)
    painter.end()
    return np.array(image.constBits()).reshape(image.height(), image.width(), 4)[..., :3].astype(int)


VIEWS = {
    "whole": QTransform(2.0, 0.0, 0.0, 2.0, 100.0, 75.0),
    "between pixels": QTransform(1.7, 0.0, 0.0, 1.7, 100.37, 74.61),
    "turned": QTransform(1.2, 0.7, -0.7, 1.2, 96.4, 71.9),
    "partly out of sight": QTransform(9.0, 0.0, 0.0, 9.0, 20.3, 10.8),
}


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0])
def test_copy_equals_drawing(qapp, ratio, view):
    dots = Dots()
    cache = PaintCache()
    expected = _picture(ratio, view, dots.draw)
    assert np.ptp(expected) > 50
    for _ in range(3):
        shown = _picture(ratio, view, lambda painter: cache.paint(painter, "dots", BOUNDS, dots.draw))
        assert np.abs(shown - expected).max() <= 2  # blended twice, each time rounded
    assert dots.drawn == 3  # expected, the first time, and the pixels


def test_changes_of_content_view_or_resolution_are_drawn(qapp):
    dots = Dots()
    cache = PaintCache()

    def paint(content: str, view: str, ratio: float) -> int:
        before = dots.drawn
        _picture(ratio, VIEWS[view], lambda painter: cache.paint(painter, content, BOUNDS, dots.draw))
        return dots.drawn - before

    for _ in range(2):
        assert paint("dark", "whole", 1.0) == 1
    assert paint("dark", "whole", 1.0) == 0
    for changed in (("light", "whole", 1.0), ("light", "turned", 1.0), ("light", "turned", 2.0)):
        assert paint(*changed) == 1
        assert paint(*changed) == 1  # its pixels
        assert paint(*changed) == 0


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0])
def test_partial_update_equals_full_drawing(qapp, ratio, view):
    """Grey on nothing, so that what is drawn over its old pixels shows."""
    cache = PaintCache(at_once=True)

    def draw(number: int, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(29, 33, 38, 120))
        painter.drawEllipse(QRectF(-25, -15, 50, 30))
        painter.drawEllipse(QPointF(9 * number - 16, 3 * number - 5), 4, 4)

    for number in range(4):
        places = [QPointF(9 * k - 16, 3 * k - 5) for k in (number - 1, number)]
        changed = QRectF(places[0], places[1]).adjusted(-4, -4, 4, 4)
        paint = partial(_paint, number, partial(draw, number), changed)
        shown, expected = (_picture(ratio, view, partial(paint, kept)) for kept in (cache, PaintCache(at_once=True)))
        assert np.ptp(expected) > 50
        np.testing.assert_array_equal(shown, expected)


def _paint(content, draw, changed, cache: PaintCache, painter: QPainter) -> None:
    cache.paint(painter, content, BOUNDS, draw, changed=changed)


def test_vector_files_contain_lines(qapp):
    dots = Dots()
    cache = PaintCache()
    written = []
    for _ in range(3):
        buffer = QBuffer()
        generator = QSvgGenerator()
        generator.setOutputDevice(buffer)
        painter = QPainter(generator)
        cache.paint(painter, "dots", BOUNDS, dots.draw)
        painter.end()
        written.append(bytes(buffer.data().data()))
    assert all(b"<polyline" in svg and b"<image" not in svg for svg in written)
