"""Snapping: a gesture's move or turn, brought to what it nearly met."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.editing.document import MapDocument

STEP = math.radians(15)


@dataclass(frozen=True)
class Snap:
    """A move that lines up with something.

    Attributes:
        by: (x, y) to move [m].
        x: The upright lines met, by their x on the map [m], to be drawn as guides.
        y: The level lines met.
    """

    by: tuple[float, float]
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()


def snap_move(
    document: MapDocument, numbers: Iterable[int], by: FloatArray | tuple[float, float], *, reach: float
) -> Snap:
    """A move of the patches ``by`` (x, y), changed by less than ``reach`` so that edges or middles line up [m].

    What lines up are the sides and the middle of the moved patches' common box with those of every other visible
    patch, in x and in y each for itself.

    Args:
        document: As it was before the gesture.
        numbers: The patches that are moved.
        by: The move as the hand makes it [m].
        reach: How near counts, usually some pixels in metres; 0 for no snapping.
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
    """One coordinate's step, and where the line is that was met."""
    marks = np.array([own[0], own.mean(), own[1]]) + by
    lines = np.concatenate([others, others.mean(axis=1, keepdims=True)], axis=1).ravel()
    gaps = lines[None] - marks[:, None]
    mark, line = np.unravel_index(np.abs(gaps).argmin(), gaps.shape)
    if not abs(gaps[mark, line]) < reach:
        return by, ()
    return by + float(gaps[mark, line]), (float(lines[line]),)


def snap_angle(document: MapDocument, number: int, angle: float, *, step: float = STEP) -> float:
    """A turn by ``angle``, changed so that patch ``number`` ends at a multiple of ``step`` from upright [rad]."""
    start = document.layout.placements[document.chosen([number])[0]].angle
    return step * round((start + angle) / step) - start
