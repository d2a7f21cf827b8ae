"""A map view without a window, with the default layers of View > Overlay."""

from __future__ import annotations

from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.views.layers import LAYERS, at_first, map_layers
from tactile_widgets.views.map.map_view import MapView


def layered_map_view(theme: Theme, scale: PressureScale) -> MapView:
    """The view, empty."""
    view = MapView(theme, scale, layers=map_layers(LAYERS))
    view.set_overlays(at_first(LAYERS))
    return view
