"""Snapshots of the map: fitted with two contacts in both themes, and zoomed in until taxels are visible."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QFont

from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.overlays.painting import REPLAYING
from tests.widgets.support.layered_map_view import layered_map_view
from tests.widgets.support.samples import leaf_map, middle_taxel, touched
from tests.widgets.support.snapshots import check_picture

pytestmark = pytest.mark.long

HOVERED = 9


@pytest.fixture
def view(qtbot):
    leaves = leaf_map()
    view = layered_map_view(DARK, PressureScale(20.0))
    qtbot.addWidget(view)
    view.setFont(QFont("DejaVu Sans", 10))
    view.resize(640, 560)
    view.show_document(MapDocument.of(leaves))
    view.show_frame(touched(leaves, [0, middle_taxel(leaves, 1)], radius=0.04))
    view.set_hover(leaves.skin.taxel_point(HOVERED))
    return view


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=["dark", "light"])
def test_fitted_map_view_matches_its_snapshot(view, theme):
    view.set_theme(theme)
    view.show()
    check_picture(view, f"map_view_{theme.name}")


def test_zoomed_map_view_in_a_replay_matches_its_snapshot(view):
    view.show()
    view.set_state(REPLAYING)
    view.zoom(3.0, view.pixel_of(leaf_map().skin.taxel_point(0)))
    check_picture(view, "map_view_zoomed")
