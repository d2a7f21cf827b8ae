"""A map with additional cuts at the place of contact, so that a path around it crosses seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import IntArray
from tactile_maps.flattening.cut import SeamPlan, shortest_edge_path
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.prepare import PreparedScene

LENGTH = 0.06
APART = 0.007
"""Length of a cut, and distance between cuts [m on the original map]."""
_CORNERS = 7
"""Number of places through which a cut is led, so that it is about as straight as the edges of the triangles permit."""


def with_slits(prepared: PreparedScene, place: SurfacePoint, count: int) -> PreparedScene:
    """Return the same scene with a map of its skin that has ``count`` parallel cuts about a place.

    The cuts are vertical on the original map. Further cuts that connect them to the border are added automatically.

    Args:
        prepared: Robot, skin and map.
        place: Middle of all cuts.
        count: Number of cuts; 0 returns the scene unchanged.

    Raises:
        MapError: The cut skin cannot be flattened.

    Cost: 1 s for 15,000 faces.
    """
    if not count:
        return prepared
    patch = prepared.skin.patches[place.patch]
    drawn = np.concatenate([_slit(prepared.map, place, APART * (k - (count - 1) / 2)) for k in range(count)])
    plan = SeamPlan(drawn=np.unique(drawn, axis=0))
    return replace(prepared, map=build_map(prepared.skin, seams={patch.name: plan}))


def _slit(map_: TactileMap, place: SurfacePoint, aside: float) -> IntArray:
    """(s, 2) edges of the body along a vertical line of the map, displaced sideways from a place [m]."""
    x, y = map_.to_map(place)
    upright = np.linspace(-LENGTH / 2, LENGTH / 2, _CORNERS)
    points = np.stack([np.full(_CORNERS, x + aside), y + upright], axis=1)
    near = cKDTree(map_.uv[place.patch]).query(points)[1]
    through = map_.charts[place.patch].vertex_of[near].tolist()
    return shortest_edge_path(map_.skin.patches[place.patch].surface, list(dict.fromkeys(through)))
