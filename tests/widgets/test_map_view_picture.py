"""How the map looks, pinned: framed with two touches, and zoomed in until taxels show."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QFont

from tests.widgets.hand_made import middle_taxel, touched
from tests.widgets.pictures import check_picture
from widgets.colours import DARK, LIGHT, PressureScale
from widgets.map_view.map_view import MapView


@pytest.fixture
def view(qtbot, prepared):
    view = MapView(DARK, PressureScale(20.0))
    qtbot.addWidget(view)
    view.setFont(QFont("DejaVu Sans", 10))
    view.resize(640, 560)
    view.show_prepared(prepared)
    view.show_frame(touched(prepared.map, [middle_taxel(prepared.map, 0), middle_taxel(prepared.map, 1)], radius=0.05))
    return view


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=["dark", "light"])
def test_framed(view, theme):
    view.set_theme(theme)
    view.show()
    check_picture(view, f"map_view_{'dark' if theme is DARK else 'light'}")


def test_zoomed_in_and_replaying(view, prepared):
    view.show()
    view.set_replaying(replaying=True)
    for _ in range(2):
        view.zoom(2.0, view.pixel_of(prepared.skin.taxel_point(middle_taxel(prepared.map, 0))))
    check_picture(view, "map_view_zoomed")
