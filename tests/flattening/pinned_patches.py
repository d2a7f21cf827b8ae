"""Patches and pins for the tests of dragging."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.support.surfaces import cap, sheet


@cache
def dome():
    """A hemisphere of 1,014 faces and its map."""
    surface = cap(np.pi / 2, rings=13, radius=0.05)
    return surface, flatten(surface)


@cache
def waves():
    """A waved sheet of 3,000 faces and its map."""
    surface = sheet(50, 30, width=0.2, height=0.12, shape=lambda x, y: 0.008 * np.sin(50 * x) * np.cos(60 * y))
    return surface, flatten(surface)


def at(chart, vertex):
    """A point of the chart as a place of the body."""
    face = int(np.flatnonzero((chart.faces == vertex).any(axis=1))[0])
    return SurfacePoint(0, face, tuple((chart.faces[face] == vertex).astype(float).tolist()))


def far_points(plane, count):
    """The middle vertex and others far from it and each other."""
    chosen = [int(np.argmin(np.linalg.norm(plane - plane.mean(axis=0), axis=1)))]
    while len(chosen) < count:
        chosen.append(int(np.linalg.norm(plane[:, None] - plane[chosen], axis=2).min(axis=1).argmax()))
    return chosen


def pinned(surface, chart, count=5, **how):
    """A patch held where it is by ``count`` pins, and the places of these."""
    patch = PinnedPatch(surface, chart, **how)
    chosen = far_points(chart.plane, count)
    numbers = [patch.add(at(chart, vertex)) for vertex in chosen]
    return patch, numbers, chart.plane[chosen].copy()
