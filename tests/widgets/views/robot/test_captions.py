"""Captions over the body do not overlap controls, even in the smallest window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QRectF


@pytest.mark.long
@pytest.mark.parametrize("width", [240, 330, 420, 700])
def test_arrow_legend_and_slider_do_not_overlap(view, width):
    view.resize(width, 320)
    text = view.display._captions.legend
    assert "newton" in text
    box = view.display.overlay.legend_box(text)
    assert not box.intersects(QRectF(view.morph.geometry()))
    assert QRectF(view.rect()).contains(box)
