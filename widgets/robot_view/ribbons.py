"""Flat shapes that lie on a curved skin, as triangles: ribbons along lines, whole or in dashes, heads, and diamonds."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from widgets.robot_view.taxel_rings import axes_across

_GAP = 0.6
"""Of a dash, the length of the gap after it."""


def ribbon(
    points: FloatArray, normals: FloatArray, width: float | FloatArray, *, lift: float, dash: float = 0.0
) -> FloatArray:
    """(t, 3, 3) triangles of a ribbon along a line over a surface.

    Args:
        points: (k, 3) [m] of the line, at least one.
        normals: (k, 3) unit, of the surface there.
        width: Across [m]; of a whole line also (k - 1,), of each side.
        lift: How far above the surface [m].
        dash: Length of a dash [m]; 0 for none.
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    breaks = along
    if dash > 0:
        turns = np.arange(0.0, along[-1], (1 + _GAP) * dash)
        breaks = np.unique(np.clip(np.concatenate([along, turns, turns + dash]), 0, along[-1]))
    place, up = (np.stack([np.interp(breaks, along, part[:, k]) for k in range(3)], 1) for part in (points, normals))
    place = place + lift * up
    step, middle = np.diff(place, axis=0), 0.5 * (breaks[1:] + breaks[:-1])
    shown = np.linalg.norm(step, axis=1) > 0
    if dash > 0:
        shown &= middle % ((1 + _GAP) * dash) < dash
    widths = np.broadcast_to(np.asarray(width, dtype=np.float64), len(step))
    aside = _unit(np.cross(up[1:] + up[:-1], step))
    # At a bend both sides end alike, or there would be a notch.
    ends = _unit(np.concatenate([aside[:1], _unit(aside[1:] + aside[:-1]), aside[-1:]]))
    before, after = 0.5 * widths[:, None] * ends[:-1], 0.5 * widths[:, None] * ends[1:]
    corners = np.stack([place[:-1] - before, place[1:] - after, place[1:] + after, place[:-1] + before], axis=1)
    return quads(corners[shown])


def _unit(vectors: FloatArray) -> FloatArray:
    """(k, 3) of length 1, or 0 where they were."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def heads(points: FloatArray, normals: FloatArray, size: float, *, every: float, lift: float) -> FloatArray:
    """(t, 3, 3) triangles that point along a line (k, 3) over a surface.

    Args:
        points: Of the line [m].
        normals: (k, 3) unit, of the surface there.
        size: Length and width of each [m].
        every: From one to the next [m]; on a short line there is one, in its middle.
        lift: How far above the surface [m].
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    back = np.arange(min(every / 3, along[-1] / 2), along[-1] - size, every)
    ends = (np.stack([np.interp(at, along, points[:, k]) for k in range(3)], 1) for at in (back, back + size))
    tail, tip = ends
    up = np.stack([np.interp(back, along, normals[:, k]) for k in range(3)], 1)
    aside = np.cross(up, tip - tail)
    aside *= 0.5 * size / np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
    return np.stack([tail - aside, tip, tail + aside], axis=1) + lift * up[:, None]


def diamonds(points: FloatArray, normals: FloatArray, half: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of diamonds around ``points`` (k, 3), half their diagonals ``half`` (k,) [m]."""
    across, up = (half[:, None] * axis for axis in axes_across(normals))
    return quads(np.stack([points + across, points + up, points - across, points - up], axis=1))


def quads(corners: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of quadrilaterals (k, 4, 3), two after each other."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
