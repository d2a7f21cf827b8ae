"""A skin mapped with further cuts just where it is touched: a path around there leads over seams."""

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
"""Of a cut, and from one to the next [m on the map as it was]."""
_CORNERS = 7
"""Places that a cut is led through, so that it is about as straight as the triangles' edges permit."""


def with_slits(prepared: PreparedScene, place: SurfacePoint, count: int) -> PreparedScene:
    """The same scene with another map of its skin, cut ``count`` times beside each other about a place.

    The cuts stand upright on the map as it was. What else has to be cut, so that each hangs together with the border,
    is added as always; where it leads is not asked.

    Args:
        prepared: Robot, skin and map.
        place: The middle of all cuts.
        count: How many; none leaves the map as it is.

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
    """(s, 2) edges of the body along an upright line of the map, so far aside of a place [m]."""
    x, y = map_.to_map(place)
    upright = np.linspace(-LENGTH / 2, LENGTH / 2, _CORNERS)
    points = np.stack([np.full(_CORNERS, x + aside), y + upright], axis=1)
    near = cKDTree(map_.uv[place.patch]).query(points)[1]
    through = map_.charts[place.patch].vertex_of[near].tolist()
    return shortest_edge_path(map_.skin.patches[place.patch].surface, list(dict.fromkeys(through)))
