"""The layers of View > Overlay, one line each: words, key, and what draws them on the map and on the body.

Menu, key, settings, theme, frames and edits reach a layer from here; a layer on both sides is still one line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from widgets.map_view.map_layer import MapLayerFactory
from widgets.robot_view.body_layer import BodyLayerFactory
from widgets.robot_view.contact_marks import ContactShapes


@dataclass(frozen=True)
class LayerSpec:
    """One layer.

    Attributes:
        name: In settings, and after ``mark_`` of the action that shows it.
        text: In the menu.
        key: Shortcut; empty for none.
        tip: What it shows.
        shown_at_first: Whether it is shown until a person chooses.
        on_map: Makes its items; None where it has none, or the map's own items draw it.
        on_body: Makes its actors; None where it has none, or the body wears the map's picture of it.
    """

    name: str
    text: str
    key: str
    tip: str
    shown_at_first: bool = False
    on_map: MapLayerFactory | None = None
    on_body: BodyLayerFactory | None = None


LAYERS = (
    LayerSpec("seams", "Seams", "Alt+S", "Show the seams along which the skin was cut", shown_at_first=True),
    LayerSpec("border", "Border", "Alt+B", "Show the border of the skin", shown_at_first=True),
    LayerSpec("pins", "Pins", "", "Show the pins with every tool"),
    LayerSpec("contours", "Contours", "Alt+C", "Show the outlines of contact regions", shown_at_first=True),
    LayerSpec(
        "shapes",
        "Contact shapes",
        "",
        "Show each contact's ellipse (dashed) and the error circle of its centre (dotted), where large enough",
        shown_at_first=True,
        on_body=ContactShapes,
    ),
    LayerSpec("taxel_ids", "Taxel numbers", "Alt+N", "Show the numbers of the taxels where there is room"),
    LayerSpec("dots", "Taxels as dots", "Alt+D", "Draw a dot for each taxel instead of the interpolated image"),
)


def map_layers(specs: Sequence[LayerSpec]) -> dict[str, MapLayerFactory]:
    """What makes each layer that has items on the map, by name."""
    return {spec.name: spec.on_map for spec in specs if spec.on_map is not None}


def body_layers(specs: Sequence[LayerSpec]) -> dict[str, BodyLayerFactory]:
    """What makes each layer that has actors on the body, by name."""
    return {spec.name: spec.on_body for spec in specs if spec.on_body is not None}
