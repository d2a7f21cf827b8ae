"""Flat shapes that lie on a curved skin, as triangles: ribbons along lines, whole or in dashes, and diamonds."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from widgets.robot_view.taxel_rings import axes_across

_GAP = 0.6
"""Of a dash, the length of the gap after it."""


def ribbon(points: FloatArray, normals: FloatArray, width: float, *, lift: float, dash: float = 0.0) -> FloatArray:
    """(t, 3, 3) triangles of a ribbon along a line over a surface.

    Args:
        points: (k, 3) [m] of the line, at least one.
        normals: (k, 3) unit, of the surface there.
        width: Across [m].
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
    aside = np.cross(up[1:] + up[:-1], step)
    aside *= 0.5 * width / np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
    here, there, aside = place[:-1][shown], place[1:][shown], aside[shown]
    return quads(np.stack([here - aside, there - aside, there + aside, here + aside], axis=1))


def diamonds(points: FloatArray, normals: FloatArray, half: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of diamonds around ``points`` (k, 3), half their diagonals ``half`` (k,) [m]."""
    across, up = (half[:, None] * axis for axis in axes_across(normals))
    return quads(np.stack([points + across, points + up, points - across, points - up], axis=1))


def quads(corners: FloatArray) -> FloatArray:
    """(2 k, 3, 3) triangles of quadrilaterals (k, 4, 3), two after each other."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
