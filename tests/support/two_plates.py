"""Flat skin in two patches with a hand-made map, so that paths on it can be computed by hand."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly


@cache
def two_plates(*, gap: float = 0.04, scale: float = 1.0) -> TactileMap:
    """Return two squares of 0.1 m, flat on the link ``bar``, ``gap`` apart along x on the body and 0.02 m on the map.

    Args:
        gap: Distance on the body [m].
        scale: Scale of the second patch on the map.
    """
    plates = [_square(0.0), _square(0.1 + gap)]
    patches = [
        Patch(name, "bar", plate, place_evenly(plate, 100, seed=0)) for name, plate in zip("ab", plates, strict=True)
    ]
    map_ = build_map(Skin(tuple(patches)))
    return TactileMap(map_.skin, map_.charts, MapLayout((_upright(map_, 0, 0.0, 1.0), _upright(map_, 1, 0.12, scale))))


def _square(x: float) -> Mesh:
    steps = np.linspace(0, 0.1, 11)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(11), np.arange(11), indexing="ij"))
    a = (np.arange(10)[:, None] * 11 + np.arange(10)).ravel()
    faces = np.concatenate([np.stack([a, a + 11, a + 12], 1), np.stack([a, a + 12, a + 1], 1)])
    return Mesh(np.stack([x + steps[i], steps[j], np.zeros(121)], axis=1), faces)


def _upright(map_: TactileMap, number: int, x: float, scale: float) -> Placement:
    """Return the placement of a flat plate's chart with the orientation on the body and its corner at (x, 0)."""
    chart = map_.charts[number]
    surface = map_.skin.patches[number].surface
    body = surface.vertices[chart.vertex_of][:, :2]
    plane = chart.plane - chart.plane.mean(axis=0)
    turn = plane.T @ (body - body.mean(axis=0))
    assert np.linalg.det(turn) > 0, "seen from outside both turn the same way"
    angle = float(np.arctan2(turn[0, 1] - turn[1, 0], turn[0, 0] + turn[1, 1]))
    laid = Placement(angle=angle, scale=scale).apply(chart.plane)
    corner = laid.min(axis=0)
    return Placement(angle=angle, offset=(x - float(corner[0]), -float(corner[1])), scale=scale)
