"""Captions over the body do not overlap controls, even in the smallest window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QRectF

from tactile_maps.core.reading_units import ReadingUnits
from tactile_widgets.views.robot.actors.contact_marks import arrow_legend


@pytest.mark.parametrize("units", [ReadingUnits.CALIBRATED, ReadingUnits.COUNTS])
@pytest.mark.parametrize("width", [250, 330, 420, 700])
def test_arrow_legend_slider_and_cube_do_not_overlap(view, width, units):
    view.resize(width, 320)
    overlay = view.display.overlay
    box = overlay.legend_box(arrow_legend(units))
    assert not box.intersects(QRectF(view.morph.geometry()))
    assert not box.intersects(overlay.cube_box)
    assert QRectF(view.rect()).contains(box)
