"""Line buffers and cached painting of the map's items."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from tactile_widgets.views.map.items.map_items import LineBuffer
from tests.widgets.support.samples import touched


def test_line_buffer_has_the_latest_segments():
    buffer = LineBuffer()
    random = np.random.default_rng(0)
    for count in (3, 50, 0, 7):
        segments = random.normal(size=(count, 2, 2))
        lines = buffer.fill(segments)
        found = [[[line.x1(), line.y1()], [line.x2(), line.y2()]] for line in lines]
        assert np.array_equal(np.reshape(found, (-1, 2, 2)), segments)


@pytest.fixture
def open_view(open_map_view, prepared):
    """Opens views of the small arm with the same camera."""
    return lambda: open_map_view(420, 380, lambda view: view.show_prepared(prepared))


@pytest.mark.parametrize("zoom", [1.0, 4.0])
def test_moving_touch_is_painted_as_in_a_new_view(open_view, prepared, zoom):
    place = prepared.skin.taxel_point(len(prepared.skin) // 2)
    kept = open_view()
    kept.zoom(zoom, kept.pixel_of(place))
    for tick, taxels in enumerate(([20, 21], [21, 22, 40], [], [len(prepared.skin) // 2], [3, 90])):
        frame = touched(prepared.map, taxels, tick=tick)
        other = open_view()
        other.zoom(zoom, other.pixel_of(place))
        pictures = []
        for view in (kept, other):
            view.show_frame(frame)
            QApplication.processEvents()
            view.viewport().repaint()
            picture = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
            pictures.append(np.array(picture.constBits()).astype(int))
        assert np.abs(pictures[0] - pictures[1]).max() <= 2  # dots and dashes are copied by the kept one, and rounded
        other.hide()
