"""What is written over the body has room of its own, in the smallest window too."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QRectF


@pytest.mark.parametrize("width", [240, 330, 420, 700])
def test_the_legend_of_arrows_and_the_slider_do_not_overlap(view, width):
    view.resize(width, 320)
    text = view.display._captions.legend
    assert "newton" in text
    box = view.display.overlay.legend_box(text)
    assert not box.intersects(QRectF(view.morph.geometry()))
    assert QRectF(view.rect()).contains(box)
