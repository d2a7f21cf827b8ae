"""Drawn path as places on the body, which stay the same when the map is edited.

Settings and files contain paths as points of the map. ``PathOnBody`` carries them from one map of a skin to another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import PathKind, draw_path

Points = tuple[tuple[float, float], ...]
"""Points on a map [m], as in ``ControlSettings.path``."""
_SAME_SHAPE = 1e-6
"""Largest distance between two drawings of a raster that are regarded as the same [m]."""
_ROUNDING = 1e-12
"""Distance on the map within which a point has not moved [m]."""
_SAMPLES = 400
"""Number of points of a path that are looked up."""


@dataclass(frozen=True, eq=False)
class PathOnBody:
    """Places on the body of the points of a path.

    A point off the skin has no place on the body. It is stored relative to the nearest patch and moves with it.

    Attributes:
        kind: Meaning of the points.
        count: Number of points that define the path; the rows after them are the corners of a raster's lines.
        points: (k, 2) points on the map on which the path was drawn [m].
        patch: (k,) patch of each point, the nearest one for a point off the skin.
        face: (k,) face of the patch; -1 off the skin.
        weights: (k, 3) weights of the face's corners.
        plane: (k, 2) points on the charts of their patches [m].
    """

    kind: PathKind
    count: int
    points: FloatArray
    patch: IntArray
    face: IntArray
    weights: FloatArray
    plane: FloatArray

    @classmethod
    def of(cls, kind: PathKind, path: Points, map_: TactileMap) -> PathOnBody:
        """Return the places of a path with at least one point that was drawn on a map."""
        points = np.array(path)
        if kind == "raster" and len(path) > 1:
            points = np.concatenate([points, draw_path(kind, points).points])
        patch, face, weights = map_.to_body_many(points)
        for k in np.flatnonzero(face < 0):
            patch[k] = np.argmin([np.linalg.norm(uv - points[k], axis=1).min() for uv in map_.uv])
        plane = np.array([map_.layout.placements[n].back(one[None])[0] for n, one in zip(patch, points, strict=True)])
        return cls(kind, len(path), points, patch, face, weights, plane)

    def on_map(self, map_: TactileMap) -> tuple[PathKind, Points]:
        """Return kind and points of the path on a map of the same skin.

        A raster becomes a polyline on a map on which its lines are not parallel to the axes or in another order.
        """
        points = np.empty((len(self.patch), 2))
        on_skin = self.face >= 0
        points[on_skin] = map_.to_map_many(self.patch[on_skin], self.face[on_skin], self.weights[on_skin])
        for k in np.flatnonzero(~on_skin):
            points[k] = map_.layout.placements[self.patch[k]].apply(self.plane[k : k + 1])[0]
        unmoved = np.abs(points - self.points).max(axis=1) < _ROUNDING
        points[unmoved] = self.points[unmoved]
        kind = self.kind
        corners = points[self.count :]
        points = points[: self.count]
        if len(corners):
            lines = draw_path(kind, points).points
            if lines.shape != corners.shape or np.abs(lines - corners).max() > _SAME_SHAPE:
                kind = "polyline"
                points = corners
        return kind, tuple((x, y) for x, y in points.tolist())


def share_off_skin(kind: PathKind, path: Points, map_: TactileMap) -> float:
    """Return the share of the length of a path that is off the skin; 0 or 1 for a single point or a path too far away.

    Cost: 3 ms.
    """
    points = np.array(path)
    if len(path) > 1:
        try:
            drawn = draw_path(kind, path)
        except MapError:
            return 1.0
        points = np.array([drawn.at(way)[0] for way in np.linspace(0.0, drawn.length, _SAMPLES)])
    return float((map_.to_body_many(points)[1] < 0).mean())
