"""Pins: put in, dragged, typed and taken out. The map between them is solved anew.

A drag goes so: ``begin_pin_drag`` at the press, ``PinnedPatch.move`` and ``frame`` at each move of the mouse,
``with_dragged_patch`` for the document to be shown (always from the document in which the drag began), and at the
release ``finish_pin_drag``, whose exact result ``History.refine`` puts in place of what the drag left.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import ReflattenRequest, kept_lengths, request_reflatten, with_chart_in_frame
from tactile_maps.flattening.chart import Pin
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.geometry.surface.mesh import SurfacePoint

_SAME = 1e-9
_ROUNDING = 1e-6


def pin_places(document: MapDocument, number: int) -> FloatArray:
    """(p, 2) map points [m] at which the pins of a patch are wanted; where they are, unless they hinder each other."""
    document.chosen([number])
    places = np.array([pin.place for pin in document.patches[number].pins]).reshape(-1, 2)
    return document.layout.placements[number].apply(places)


def chart_place(document: MapDocument, number: int, point: FloatArray | tuple[float, float]) -> tuple[float, float]:
    """A map point (2,) [m] in the chart's own frame, in which pins are kept."""
    document.chosen([number])
    x, y = document.layout.placements[number].back(np.asarray(point, dtype=np.float64).reshape(1, 2))[0]
    return float(x), float(y)


def add_pin(document: MapDocument, at: SurfacePoint) -> MapDocument:
    """A pin that holds a place of the body where it is on the map now, so that nothing moves.

    Raises:
        MapError: No such patch or place on it, or a pin is there already.
    """
    (number,) = document.chosen([at.patch])
    patch = document.patches[number]
    weights = np.asarray(at.weights, dtype=np.float64)
    sound = np.isfinite(weights).all() and (weights >= 0).all() and abs(weights.sum() - 1) <= _ROUNDING
    if not (sound and 0 <= at.face < len(document.charts[number].faces)):
        raise MapError("a pin is not on the patch", place=patch.name, value=f"face {at.face}, weights {at.weights}")
    here = _chart_point(document, at)
    if any(np.abs(_chart_point(document, pin.at) - here).max() < _SAME for pin in patch.pins):
        raise MapError("a pin is already at this point", place=patch.name, remedy="Drag that one")
    a, b, c = map(float, weights)
    pin = Pin(SurfacePoint(number, int(at.face), (a, b, c)), (float(here[0]), float(here[1])))
    return document.with_patch(number, replace(patch, pins=(*patch.pins, pin)))


def begin_pin_drag(document: MapDocument, number: int) -> PinnedPatch:
    """A patch being dragged, with its pins numbered from 0 in their order. Cost: 30 ms for 10,000 faces."""
    document.chosen([number])
    patch = document.patches[number]
    surface = document.skin.patches[number].surface
    return PinnedPatch(surface, document.charts[number], lengths=kept_lengths(patch), pins=patch.pins, name=patch.name)


def with_dragged_patch(document: MapDocument, number: int, gripped: PinnedPatch) -> MapDocument:
    """The document with the patch as it is dragged now.

    Args:
        document: The one that was gripped; not what ``with_dragged_patch`` gave before, whose frame moved along.
        number: Of the patch.
        gripped: From ``begin_pin_drag``, moved since.
    """
    chart = replace(document.charts[number], plane=gripped.plane)
    return with_chart_in_frame(
        document, number, chart, replace(document.patches[number], pins=tuple(gripped.pins.values()))
    )


def finish_pin_drag(document: MapDocument, number: int) -> ReflattenRequest:
    """The exact map for the pins of a patch, after ``with_dragged_patch`` left one that only looks like it."""
    document.chosen([number])
    return request_reflatten(document, "Drag a pin", [(number, document.patches[number])], anyway=True)


def remove_pins(document: MapDocument, number: int, pins: Iterable[int]) -> ReflattenRequest:
    """Pins taken out by their numbers; without the last the map is what its method makes of it.

    Raises:
        MapError: No such patch or pin.
    """
    out = set(pins)
    _check_pins(document, number, out)
    left = [pin for k, pin in enumerate(document.patches[number].pins) if k not in out]
    return request_reflatten(document, "Remove pins", [(number, replace(document.patches[number], pins=tuple(left)))])


def nudge_pins(
    document: MapDocument, wanted: Mapping[int, Iterable[int]], by: FloatArray | tuple[float, float]
) -> ReflattenRequest:
    """Pins, their numbers by patch, wanted (x, y) [m] farther on the map.

    Raises:
        MapError: No such patch or pin, or the step is not finite.
    """
    edits = []
    for number, chosen in wanted.items():
        moved = set(chosen)
        _check_pins(document, number, moved)
        places = pin_places(document, number) + np.asarray(by, dtype=np.float64)
        if not np.isfinite(places).all():
            raise MapError("a pin target is not finite", place=document.patches[number].name, value=by)
        pins = [
            replace(pin, place=chart_place(document, number, places[k])) if k in moved else pin
            for k, pin in enumerate(document.patches[number].pins)
        ]
        edits.append((number, replace(document.patches[number], pins=tuple(pins))))
    return request_reflatten(document, "Move pins", edits)


def unpin(document: MapDocument, wanted: Mapping[int, Iterable[int]]) -> ReflattenRequest:
    """Pins, their numbers by patch, taken out in one step.

    Raises:
        MapError: No such patch or pin.
    """
    asked = [remove_pins(document, number, pins) for number, pins in wanted.items()]
    return ReflattenRequest("Remove pins", tuple(job for part in asked for job in part.jobs))


def _check_pins(document: MapDocument, number: int, wanted: Iterable[int]) -> None:
    document.chosen([number])
    pins = document.patches[number].pins
    for pin in wanted:
        if not 0 <= pin < len(pins):
            raise MapError("unknown pin number", place=document.patches[number].name, value=pin)


def _chart_point(document: MapDocument, at: SurfacePoint) -> FloatArray:
    """(2,) where a place of the body lies in its chart's own frame [m]."""
    chart = document.charts[at.patch]
    return np.asarray(at.weights) @ chart.plane[chart.faces[at.face]]
