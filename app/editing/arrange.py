"""Arranging: patches moved, turned, mirrored, scaled, lined up and packed; no chart changes.

Every edit is one placement put after those that were there, so that it can be undone, repeated and mixed freely. All
take the numbers of the patches to be edited, and give the same document back where there is nothing to do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Literal

import numpy as np

from app.arrays import FloatArray
from app.editing.document import MapDocument
from app.errors import MapError
from app.maps.layout import MapLayout, Placement
from app.maps.packing import MARGIN, pack

Edge = Literal["left", "centre", "right", "top", "middle", "bottom"]
_EDGES: dict[Edge, Callable[[FloatArray], FloatArray]] = {
    "left": lambda box: box[..., 0, :] * [1, 0],
    "centre": lambda box: box.mean(axis=-2) * [1, 0],
    "right": lambda box: box[..., 1, :] * [1, 0],
    "top": lambda box: box[..., 1, :] * [0, 1],
    "middle": lambda box: box.mean(axis=-2) * [0, 1],
    "bottom": lambda box: box[..., 0, :] * [0, 1],
}
EDGES: tuple[Edge, ...] = tuple(_EDGES)


def move(document: MapDocument, numbers: Iterable[int], by: FloatArray | tuple[float, float]) -> MapDocument:
    """The patches moved by (x, y) [m].

    Raises:
        MapError: Here and in all that follow: no such patch, or one would come to lie absurdly far out.
    """
    x, y = map(float, by)
    return _placed(document, numbers, Placement(offset=(x, y)))


def rotate(
    document: MapDocument, numbers: Iterable[int], angle: float, *, about: FloatArray | None = None
) -> MapDocument:
    """The patches turned together, counter-clockwise [rad], ``about`` a map point, by default their box's middle."""
    return _about(document, numbers, Placement(angle=angle), about)


def mirror(document: MapDocument, numbers: Iterable[int], *, about: FloatArray | None = None) -> MapDocument:
    """Left and right of the patches exchanged, in the upright line through ``about``, by default their box's middle."""
    return _about(document, numbers, Placement(mirrored=True), about)


def scale(
    document: MapDocument, numbers: Iterable[int], factor: float, *, about: FloatArray | None = None
) -> MapDocument:
    """The patches drawn ``factor`` times larger, away from ``about``, by default their box's middle.

    Raises:
        MapError: As ``move``; or one would be drawn outside ``layout.SMALLEST`` to ``layout.LARGEST``.
    """
    return _about(document, numbers, Placement(scale=factor), about)


def true_size(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    """Each patch at its true size again, its middle where it is."""
    for number in document.chosen(numbers):
        current = document.layout.placements[number].scale
        if current != 1:
            document = _exactly_true(scale(document, [number], 1 / current), number)
    return document


def align(document: MapDocument, numbers: Iterable[int], edge: Edge) -> MapDocument:
    """Each patch moved so that its ``edge`` is in line with that of the box around all of them.

    Raises:
        MapError: As ``move``; or fewer than two patches.
    """
    chosen = document.chosen(numbers)
    if len(chosen) < 2:
        raise MapError("one patch has nothing to be aligned with", remedy="Select at least two patches")
    boxes, of = document.map.boxes, _EDGES[edge]
    goal = of(_around(boxes[chosen]))
    for number in chosen:
        document = move(document, [number], goal - of(boxes[number]))
    return document


def repack(document: MapDocument, numbers: Iterable[int] | None = None) -> MapDocument:
    """The patches packed anew as they sit on the body, without overlaps; each keeps its turn, mirroring and scale.

    Args:
        document: What to arrange.
        numbers: Only these; they then come as one block to the free place nearest to where they were.
    """
    chosen = document.chosen(range(len(document.patches)) if numbers is None else numbers)
    placements = [document.layout.placements[k] for k in chosen]
    drawn = [p.apply(document.charts[k].plane) for p, k in zip(placements, chosen, strict=True)]
    corners = [points.min(axis=0) for points in drawn]
    charts = [
        replace(document.charts[k], plane=points - corner)
        for k, points, corner in zip(chosen, drawn, corners, strict=True)
    ]
    packed = pack(charts, links=[document.skin.patches[k].link for k in chosen])
    steps = np.array([p.offset for p in packed.placements]).reshape(-1, 2) - np.reshape(corners, (-1, 2))
    others = np.setdiff1d(np.arange(len(document.patches)), chosen)
    if chosen and others.size:
        before, boxes = _around(document.map.boxes[chosen]), document.map.boxes[chosen] + steps[:, None]
        margin = MARGIN * float(np.median(np.ptp(document.map.boxes, axis=1).max(axis=1)))
        steps += _nearest_free(_around(boxes), document.map.boxes[others], before.mean(axis=0), margin)
    for number, step in zip(chosen, steps, strict=True):
        document = move(document, [number], step)
    return document


def _around(boxes: FloatArray) -> FloatArray:
    """(2, 2) the box around boxes (k, 2, 2)."""
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _nearest_free(block: FloatArray, others: FloatArray, middle: FloatArray, margin: float) -> FloatArray:
    """(2,) the step that brings ``block`` clear of ``others`` with its middle as near as can be to ``middle``.

    The middle must stay out of the other boxes grown by half the block; the nearest such point has each coordinate
    either as wished or on the side of a grown box.
    """
    reach = 0.5 * np.ptp(block, axis=0) + margin
    low, high = others[:, 0] - reach, others[:, 1] + reach
    x, y = (np.unique(np.concatenate([[middle[k]], low[:, k], high[:, k]])) for k in (0, 1))
    tried = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 1, 2)
    free = tried[~((tried > low) & (tried < high)).all(axis=2).any(axis=1), 0]
    return free[np.linalg.norm(free - middle, axis=1).argmin()] - block.mean(axis=0)


def _about(document: MapDocument, numbers: Iterable[int], act: Placement, about: FloatArray | None) -> MapDocument:
    """``act`` around a point that it leaves where it is."""
    chosen = document.chosen(numbers)
    if not chosen:
        return document
    if not np.isfinite([act.angle, act.scale]).all():
        raise MapError("a turn or scale is not finite", value=f"{act.angle:g}, {act.scale:g}")
    centre = _around(document.map.boxes[chosen]).mean(axis=0) if about is None else np.asarray(about, dtype=np.float64)
    x, y = centre - act.apply(centre[None])[0]
    return _placed(document, chosen, replace(act, offset=(float(x), float(y))))


def _placed(document: MapDocument, numbers: Iterable[int], act: Placement) -> MapDocument:
    chosen, placements = document.chosen(numbers), list(document.layout.placements)
    for number in chosen:
        placements[number] = act.after(placements[number])
    layout = MapLayout(tuple(placements))
    return document if layout == document.layout else document.with_layout(layout)


def _exactly_true(document: MapDocument, number: int) -> MapDocument:
    """Scale 1 to the last bit, after it has been divided out."""
    placements = list(document.layout.placements)
    placements[number] = replace(placements[number], scale=1.0)
    return document.with_layout(MapLayout(tuple(placements)))
