"""Arranging: patches are moved, rotated, mirrored, scaled, aligned and packed without a change of their charts.

Every edit composes one placement with the previous ones, so that edits can be undone, repeated and combined freely. All
take the numbers of the patches to edit, and return the same document if nothing changes.

Snapping adjusts a drag so that patches line up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.model.layout import PACKING_MARGIN, MapLayout, Placement, pack_charts

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
_NEGLIGIBLE = 1e-9
"""Steps of packing up to this length [m] are rounding errors."""


def move(document: MapDocument, numbers: Iterable[int], by: FloatArray | tuple[float, float]) -> MapDocument:
    """Move patches by (x, y) [m].

    Raises:
        MapError: For this and the following functions: unknown patch, or one would be beyond ``FARTHEST_OFFSET``.
    """
    x, y = map(float, by)
    return _placed(document, numbers, Placement(offset=(x, y)))


def rotate(
    document: MapDocument, numbers: Iterable[int], angle: float, *, about: FloatArray | None = None
) -> MapDocument:
    """Rotate patches together counter-clockwise [rad] ``about`` a map point, by default the centre of their box."""
    return _about(document, numbers, Placement(angle=angle), about)


def mirror(document: MapDocument, numbers: Iterable[int], *, about: FloatArray | None = None) -> MapDocument:
    """Mirror patches left to right in the vertical line through ``about``, by default the centre of their box."""
    return _about(document, numbers, Placement(mirrored=True), about)


def scale(
    document: MapDocument, numbers: Iterable[int], factor: float, *, about: FloatArray | None = None
) -> MapDocument:
    """Scale patches by ``factor`` away from ``about``, by default the centre of their box.

    Raises:
        MapError: Same as for ``move``; or a scale would be outside ``SMALLEST_SCALE`` to ``LARGEST_SCALE``.
    """
    return _about(document, numbers, Placement(scale=factor), about)


def true_size(document: MapDocument, numbers: Iterable[int]) -> MapDocument:
    """Restore the true size of each patch about its centre."""
    for number in document.chosen(numbers):
        current = document.layout.placements[number].scale
        if current != 1:
            document = _exactly_true(scale(document, [number], 1 / current), number)
    return document


def align(document: MapDocument, numbers: Iterable[int], edge: Edge) -> MapDocument:
    """Align the ``edge`` of each patch with that of the box around all of them.

    Raises:
        MapError: Same as for ``move``; or fewer than two patches.
    """
    chosen = document.chosen(numbers)
    if len(chosen) < 2:
        raise MapError("aligning needs two patches", remedy="Select at least two patches")
    boxes = document.map.boxes
    of = _EDGES[edge]
    goal = of(_around(boxes[chosen]))
    for number in chosen:
        document = move(document, [number], goal - of(boxes[number]))
    return document


def repack(document: MapDocument, numbers: Iterable[int] | None = None) -> MapDocument:
    """Pack patches in the order of the body without overlaps; each keeps its rotation, mirroring and scale.

    Args:
        document: The document.
        numbers: Patches to pack, by default all. Some patches are moved as one block to the nearest free space.

    Returns:
        The packed document; the same one if all patches keep their places.
    """
    chosen = document.chosen(range(len(document.patches)) if numbers is None else numbers)
    placements = [document.layout.placements[k] for k in chosen]
    drawn = [p.apply(document.charts[k].plane) for p, k in zip(placements, chosen, strict=True)]
    corners = [points.min(axis=0) for points in drawn]
    charts = [
        replace(document.charts[k], plane=points - corner)
        for k, points, corner in zip(chosen, drawn, corners, strict=True)
    ]
    packed = pack_charts(charts, links=[document.skin.patches[k].link for k in chosen])
    steps = np.array([p.offset for p in packed.placements]).reshape(-1, 2) - np.reshape(corners, (-1, 2))
    others = np.setdiff1d(np.arange(len(document.patches)), chosen)
    if chosen and others.size:
        before = _around(document.map.boxes[chosen])
        boxes = document.map.boxes[chosen] + steps[:, None]
        margin = PACKING_MARGIN * float(np.median(np.ptp(document.map.boxes, axis=1).max(axis=1)))
        steps += _nearest_free(_around(boxes), document.map.boxes[others], before.mean(axis=0), margin)
    if np.abs(steps).max(initial=0.0) <= _NEGLIGIBLE:
        return document
    for number, step in zip(chosen, steps, strict=True):
        document = move(document, [number], step)
    return document


def _around(boxes: FloatArray) -> FloatArray:
    """Return the box (2, 2) around boxes (k, 2, 2)."""
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _nearest_free(block: FloatArray, others: FloatArray, middle: FloatArray, margin: float) -> FloatArray:
    """Return the step (2,) that moves ``block`` clear of ``others`` with its centre as close as possible to ``middle``.

    The centre must be outside the other boxes enlarged by half the block; each coordinate of the closest such point is
    either unchanged or on the side of an enlarged box.
    """
    reach = 0.5 * np.ptp(block, axis=0) + margin
    low = others[:, 0] - reach
    high = others[:, 1] + reach
    x, y = (np.unique(np.concatenate([[middle[k]], low[:, k], high[:, k]])) for k in (0, 1))
    tried = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 1, 2)
    free = tried[~((tried > low) & (tried < high)).all(axis=2).any(axis=1), 0]
    return free[np.linalg.norm(free - middle, axis=1).argmin()] - block.mean(axis=0)


def _about(document: MapDocument, numbers: Iterable[int], act: Placement, about: FloatArray | None) -> MapDocument:
    """Apply ``act`` about a fixed point."""
    chosen = document.chosen(numbers)
    if not chosen:
        return document
    if not np.isfinite([act.angle, act.scale]).all():
        raise MapError("a rotation or scale is not finite", value=f"{act.angle:g}, {act.scale:g}")
    centre = _around(document.map.boxes[chosen]).mean(axis=0) if about is None else np.asarray(about, dtype=np.float64)
    x, y = centre - act.apply(centre[None])[0]
    return _placed(document, chosen, replace(act, offset=(float(x), float(y))))


def _placed(document: MapDocument, numbers: Iterable[int], act: Placement) -> MapDocument:
    chosen = document.chosen(numbers)
    placements = list(document.layout.placements)
    for number in chosen:
        placements[number] = act.after(placements[number])
    layout = MapLayout(tuple(placements))
    return document if layout == document.layout else document.with_layout(layout)


def _exactly_true(document: MapDocument, number: int) -> MapDocument:
    """Set the scale to exactly 1, without rounding errors."""
    placements = list(document.layout.placements)
    placements[number] = replace(placements[number], scale=1.0)
    return document.with_layout(MapLayout(tuple(placements)))


SNAP_ANGLE = math.radians(15)


@dataclass(frozen=True)
class Snap:
    """Result of snapping a move.

    Attributes:
        by: (x, y) to move [m].
        x: The x of aligned vertical lines on the map [m], to be drawn as guides.
        y: The y of aligned horizontal lines on the map [m].
    """

    by: tuple[float, float]
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()


def snap_move(
    document: MapDocument, numbers: Iterable[int], by: FloatArray | tuple[float, float], *, reach: float
) -> Snap:
    """Adjust a move of patches ``by`` (x, y) by less than ``reach`` so that edges or centres line up [m].

    The sides and the centre of the moved patches' common box are aligned with those of every other visible patch,
    independently in x and y.

    Args:
        document: The document before the gesture.
        numbers: Moved patches.
        by: The dragged move [m].
        reach: Largest adjustment, usually some pixels in metres; 0 for no snapping.
    """
    chosen = document.chosen(numbers)
    others = [k for k, patch in enumerate(document.patches) if patch.visible and k not in chosen]
    if not chosen or not others:
        return Snap((float(by[0]), float(by[1])))
    boxes = document.map.boxes
    own = np.stack([boxes[chosen, 0].min(axis=0), boxes[chosen, 1].max(axis=0)])
    steps, lines = zip(*(_snapped(own[:, k], boxes[others, :, k], float(by[k]), reach) for k in (0, 1)), strict=True)
    return Snap((steps[0], steps[1]), *lines)


def _snapped(own: FloatArray, others: FloatArray, by: float, reach: float) -> tuple[float, tuple[float, ...]]:
    """Return the step of one coordinate and the aligned line."""
    marks = np.array([own[0], own.mean(), own[1]]) + by
    lines = np.concatenate([others, others.mean(axis=1, keepdims=True)], axis=1).ravel()
    gaps = lines[None] - marks[:, None]
    mark, line = np.unravel_index(np.abs(gaps).argmin(), gaps.shape)
    if not abs(gaps[mark, line]) < reach:
        return by, ()
    return by + float(gaps[mark, line]), (float(lines[line]),)
