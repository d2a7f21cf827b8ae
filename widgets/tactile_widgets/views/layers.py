"""Layers of View > Overlay, one entry each: texts, key, and classes that draw it on the map and on the body.

An entry is all that a layer needs to receive menu, key, settings, theme, ticks and edits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.views.map.items.map_canvas import MapLayerFactory
from tactile_widgets.views.map.painting.map_layers import (
    BorderLines,
    ContactEllipses,
    FrictionDots,
    PinMarks,
    SeamLines,
    ShearArrows,
    TaxelDots,
    TaxelNumbers,
    TouchContours,
)
from tactile_widgets.views.robot.actors.body_layers import BodyShear, ContactShapes, FrictionDiscs, TaxelDiscs
from tactile_widgets.views.robot.actors.robot_actors import BodyLayerFactory


@dataclass(frozen=True)
class LayerSpec:
    """Entry of the menu View > Overlay.

    Attributes:
        name: Name in settings, and after ``mark_`` in the name of its action.
        text: Text in the menu.
        key: Shortcut; empty if there is none.
        tip: Tooltip.
        shown_at_first: Whether it is shown by default.
        on_map: Class that draws it on the map; None if it is not drawn there.
        on_body: Class that draws it on the body; None if it is not drawn there.
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
        "seams",
        "Seams",
        "Alt+S",
        "Show the seams along which the skin was cut",
        shown_at_first=True,
        on_map=SeamLines,
    ),
    LayerSpec(
        "border",
        "Border",
        "Alt+B",
        "Show the border of the skin",
        shown_at_first=True,
        on_map=BorderLines,
    ),
    LayerSpec("pins", "Pins", "", "Show the pins with every tool", on_map=PinMarks),
    LayerSpec(
        "contours",
        "Contours",
        "Alt+C",
        "Show the outlines of contact regions",
        shown_at_first=True,
        on_map=TouchContours,
    ),
    LayerSpec(
        "friction",
        "Friction in use",
        "",
        "Colour pressed taxels by the share of their friction that shear uses, and mark those that slip",
        on_map=FrictionDots,
        on_body=FrictionDiscs,
    ),
    LayerSpec(
        "shear",
        "Shear arrows",
        "",
        "Show the traction along the skin on pressed taxels, where it is measured or simulated; close arrows merge",
        shown_at_first=True,
        on_map=ShearArrows,
        on_body=BodyShear,
    ),
    LayerSpec(
        "shapes",
        "Contact shapes",
        "",
        "Show each contact's ellipse (dashed) and the error circle of its centre (dotted), where large enough",
        shown_at_first=True,
        on_map=ContactEllipses,
        on_body=ContactShapes,
    ),
    LayerSpec(
        "taxel_ids",
        "Taxel numbers",
        "Alt+N",
        "Show the numbers of the taxels where there is room",
        on_map=TaxelNumbers,
    ),
    LayerSpec(
        "dots",
        "Taxels as dots",
        "Alt+D",
        "Draw a dot for each taxel instead of the interpolated image",
        on_map=TaxelDots,
        on_body=TaxelDiscs,
    ),
)


def at_first(specs: Sequence[LayerSpec]) -> OverlayOptions:
    """Return the default layers."""
    return OverlayOptions(shown=frozenset(spec.name for spec in specs if spec.shown_at_first))


def map_layers(specs: Sequence[LayerSpec]) -> dict[str, MapLayerFactory]:
    """Return the factories of layers on the map, by name."""
    return {spec.name: spec.on_map for spec in specs if spec.on_map is not None}


def body_layers(specs: Sequence[LayerSpec]) -> dict[str, BodyLayerFactory]:
    """Return the factories of layers on the body, by name."""
    return {spec.name: spec.on_body for spec in specs if spec.on_body is not None}
