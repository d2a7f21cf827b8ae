"""The layers of View > Overlay, one line each: words, key, and what draws them on the map and on the body.

Menu, key, settings, theme, frames and edits reach a layer from here; a layer on both sides is still one line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.views.map.items.map_scene import MapLayerFactory
from tactile_widgets.views.map.painting.map_layers import (
    BorderLines,
    ContactEllipses,
    PinMarks,
    SeamLines,
    TaxelDots,
    TaxelNumbers,
    TouchContours,
)
from tactile_widgets.views.robot.scene.body_layers import ContactShapes, TaxelDiscs
from tactile_widgets.views.robot.scene.robot_scene import BodyLayerFactory


@dataclass(frozen=True)
class LayerSpec:
    """One layer.

    Attributes:
        name: In settings, and after ``mark_`` of the action that shows it.
        text: In the menu.
        key: Shortcut; empty for none.
        tip: What it shows.
        shown_at_first: Whether it is shown until a person chooses.
        on_map: Draws it on the map; None where it is on the body alone.
        on_body: Draws it on the body; None where it is on the map alone.
    """

    name: str
    text: str
    key: str
    tip: str
    shown_at_first: bool = False
    on_map: MapLayerFactory | None = None
    on_body: BodyLayerFactory | None = None


LAYERS = (
    LayerSpec(
        "seams", "Seams", "Alt+S", "Show the seams along which the skin was cut", shown_at_first=True,
        on_map=SeamLines,
    ),
    LayerSpec(
        "border", "Border", "Alt+B", "Show the border of the skin", shown_at_first=True,
        on_map=BorderLines,
    ),
    LayerSpec("pins", "Pins", "", "Show the pins with every tool", on_map=PinMarks),
    LayerSpec(
        "contours", "Contours", "Alt+C", "Show the outlines of contact regions", shown_at_first=True,
        on_map=TouchContours,
    ),
    LayerSpec(
        "shapes", "Contact shapes", "",
        "Show each contact's ellipse (dashed) and the error circle of its centre (dotted), where large enough",
        shown_at_first=True, on_map=ContactEllipses, on_body=ContactShapes,
    ),
    LayerSpec(
        "taxel_ids", "Taxel numbers", "Alt+N", "Show the numbers of the taxels where there is room",
        on_map=TaxelNumbers,
    ),
    LayerSpec(
        "dots", "Taxels as dots", "Alt+D", "Draw a dot for each taxel instead of the interpolated image",
        on_map=TaxelDots, on_body=TaxelDiscs,
    ),
)  # fmt: skip


def at_first(specs: Sequence[LayerSpec]) -> OverlayOptions:
    """What is shown until a person chooses."""
    return OverlayOptions(shown=frozenset(spec.name for spec in specs if spec.shown_at_first))


def map_layers(specs: Sequence[LayerSpec]) -> dict[str, MapLayerFactory]:
    """What makes each layer that is drawn on the map, by name."""
    return {spec.name: spec.on_map for spec in specs if spec.on_map is not None}


def body_layers(specs: Sequence[LayerSpec]) -> dict[str, BodyLayerFactory]:
    """What makes each layer that is drawn on the body, by name."""
    return {spec.name: spec.on_body for spec in specs if spec.on_body is not None}
