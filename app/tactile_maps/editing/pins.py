"""Pins: added, dragged, nudged and removed. The map between them is recomputed.

A drag consists of ``begin_pin_drag`` at the press; ``PinnedPatch.move``, ``frame`` and ``with_dragged_patch`` at each
mouse move, the last always from the document in which the drag began; and ``finish_pin_drag`` at the release, whose
exact result ``History.refine`` puts in place of the document left by the drag.
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
    """Return the targets (p, 2) of a patch's pins as map points [m]."""
    document.chosen([number])
    places = np.array([pin.place for pin in document.patches[number].pins]).reshape(-1, 2)
    return document.layout.placements[number].apply(places)


def chart_place(document: MapDocument, number: int, point: FloatArray | tuple[float, float]) -> tuple[float, float]:
    """Convert a map point (2,) [m] to the chart's frame, in which pins are stored."""
    document.chosen([number])
    x, y = document.layout.placements[number].back(np.asarray(point, dtype=np.float64).reshape(1, 2))[0]
    return float(x), float(y)


def add_pin(document: MapDocument, at: SurfacePoint) -> MapDocument:
    """Add a pin that holds a point of the body at its current map point, so that nothing moves.

    Raises:
        MapError: Unknown patch, invalid point, or a pin at the same point.
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
    """Return a patch for dragging, with its pins numbered from 0 in order. Cost: 30 ms for 10,000 faces."""
    document.chosen([number])
    patch = document.patches[number]
    surface = document.skin.patches[number].surface
    return PinnedPatch(surface, document.charts[number], lengths=kept_lengths(patch), pins=patch.pins, name=patch.name)


def with_dragged_patch(document: MapDocument, number: int, gripped: PinnedPatch) -> MapDocument:
    """Return the document with the current state of the dragged patch.

    Args:
        document: The document at the start of the drag, not an earlier result, whose frame has moved.
        number: Number of the patch.
        gripped: The patch of ``begin_pin_drag``, moved since.
    """
    chart = replace(document.charts[number], plane=gripped.plane)
    return with_chart_in_frame(
        document, number, chart, replace(document.patches[number], pins=tuple(gripped.pins.values()))
    )


def finish_pin_drag(document: MapDocument, number: int) -> ReflattenRequest:
    """Request the exact map for the pins of a patch, which ``with_dragged_patch`` only approximates."""
    document.chosen([number])
    return request_reflatten(document, "Drag a pin", [(number, document.patches[number])], anyway=True)


def remove_pins(document: MapDocument, number: int, pins: Iterable[int]) -> ReflattenRequest:
    """Remove pins by their numbers; without pins the map is that of its method.

    Raises:
        MapError: Unknown patch or pin.
    """
    out = set(pins)
    _check_pins(document, number, out)
    left = [pin for k, pin in enumerate(document.patches[number].pins) if k not in out]
    return request_reflatten(document, "Remove pins", [(number, replace(document.patches[number], pins=tuple(left)))])


def nudge_pins(
    document: MapDocument, pins_by_patch: Mapping[int, Iterable[int]], by: FloatArray | tuple[float, float]
) -> ReflattenRequest:
    """Move the targets of pins, by patch and number, by (x, y) [m] on the map.

    Raises:
        MapError: Unknown patch or pin, or the step is not finite.
    """
    edits = []
    for number, chosen in pins_by_patch.items():
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


def unpin(document: MapDocument, pins_by_patch: Mapping[int, Iterable[int]]) -> ReflattenRequest:
    """Remove pins, by patch and number, in one step.

    Raises:
        MapError: Unknown patch or pin.
    """
    requests = [remove_pins(document, number, pins) for number, pins in pins_by_patch.items()]
    return ReflattenRequest("Remove pins", tuple(job for part in requests for job in part.jobs))


def _check_pins(document: MapDocument, number: int, numbers: Iterable[int]) -> None:
    document.chosen([number])
    pins = document.patches[number].pins
    for pin in numbers:
        if not 0 <= pin < len(pins):
            raise MapError("unknown pin number", place=document.patches[number].name, value=pin)


def _chart_point(document: MapDocument, at: SurfacePoint) -> FloatArray:
    """Return the chart point (2,) of a point of the body [m]."""
    chart = document.charts[at.patch]
    return np.asarray(at.weights) @ chart.plane[chart.faces[at.face]]
