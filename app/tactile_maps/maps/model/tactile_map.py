"""The tactile map: a one-to-one correspondence between the skin and the plane, evaluated in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.skin.model.skin import Skin

SEAM_RATIO = 2.0
"""Ratio of map distance to body distance above which two points of the skin are separated by a seam."""
_SLACK = 1e-9
"""Tolerance of a patch's box for points on its side, as a share of the patch's size."""


@dataclass(frozen=True, eq=False)
class TactileMap:
    """Skin, charts and layout of a tactile map, with derived quantities.

    Attributes:
        skin: The mapped skin.
        charts: One per patch, in order.
        layout: Placements of the charts.

    Example:
        >>> at = tactile_map.to_body(tactile_map.taxel_points[30])
        >>> error = tactile_map.to_map(at) - tactile_map.taxel_points[30]
        >>> float(abs(error).max()) < 1e-9
        True
    """

    skin: Skin
    charts: tuple[Chart, ...]
    layout: MapLayout

    def __post_init__(self) -> None:
        counts = {len(self.skin.patches), len(self.charts), len(self.layout.placements)}
        if len(counts) != 1:
            raise MapError("skin, charts and layout disagree in the number of patches", value=sorted(counts))
        for patch, chart in zip(self.skin.patches, self.charts, strict=True):
            if len(patch.surface.faces) != len(chart.faces):
                raise MapError("a chart does not have its surface's faces", place=patch.name, value=len(chart.faces))

    def without_caches(self) -> TactileMap:
        """Return the same map without cached values, for callers that keep many maps, such as every edit."""
        return TactileMap(self.skin, self.charts, self.layout)

    @cached_property
    def uv(self) -> tuple[FloatArray, ...]:
        """Map coordinates (k, 2) [m] of the chart points of each patch."""
        pairs = zip(self.charts, self.layout.placements, strict=True)
        return tuple(readonly(placement.apply(chart.plane)) for chart, placement in pairs)

    @cached_property
    def taxel_points(self) -> FloatArray:
        """(taxels, 2) map points of the taxels [m]."""
        parts = [
            np.einsum("kc,kcd->kd", patch.taxels.weights, uv[chart.faces[patch.taxels.faces]])
            for patch, chart, uv in zip(self.skin.patches, self.charts, self.uv, strict=True)
        ]
        return readonly(np.concatenate(parts) if parts else np.zeros((0, 2)))

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 2) lower-left and upper-right corner of the map [m]."""
        if not len(self.boxes):
            return readonly(np.zeros((2, 2)))
        return readonly(np.stack([self.boxes[:, 0].min(axis=0), self.boxes[:, 1].max(axis=0)]))

    @cached_property
    def boxes(self) -> FloatArray:
        """(patches, 2, 2) lower-left and upper-right corner of each patch on the map [m]."""
        return readonly(np.array([[line.min(axis=0), line.max(axis=0)] for line in self.outlines]).reshape(-1, 2, 2))

    @cached_property
    def outlines(self) -> tuple[FloatArray, ...]:
        """Closed border (b, 2) [m] of each patch; the first point is not repeated."""
        return tuple(readonly(uv[chart.border]) for chart, uv in zip(self.charts, self.uv, strict=True))

    @cached_property
    def seams(self) -> tuple[FloatArray, ...]:
        """Border segments (s, 2, 2) [m] of each patch that coincide with another one on the body."""
        return tuple(readonly(uv[chart.seam_edges]) for chart, uv in zip(self.charts, self.uv, strict=True))

    def to_map(self, at: SurfacePoint) -> FloatArray:
        """Return the map point (2,) [m] of a point on the body; on a seam, that of its face's copy."""
        return np.array(at.weights).dot(self.uv[at.patch].take(self.charts[at.patch].faces[at.face], axis=0))

    def to_map_many(self, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
        """Return map points (k, 2) [m] of patch (k,), face (k,) and weights (k, 3)."""
        return np.einsum("kc,kcd->kd", weights, self._triangles[self._starts[patch] + face])

    def to_body(self, point: FloatArray) -> SurfacePoint | None:
        """Return the point on the body at a map point (2,) [m]; None outside all patches.

        Exact: by the containing triangle, not by the nearest taxels. Cost: about 80 µs; for 100,000 points 0.6 µs each.
        Moving patches needs no recomputation.
        """
        patch, face, weights = self.to_body_many(np.asarray(point, dtype=np.float64).reshape(1, 2))
        if face[0] < 0:
            return None
        a, b, c = weights[0]
        return SurfacePoint(int(patch[0]), int(face[0]), (float(a), float(b), float(c)))

    def to_body_many(self, points: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Return patch (k,), face (k,) and weights (k, 3) at map points (k, 2) [m]; patch and face are -1 outside."""
        patch, face = np.full((2, len(points)), -1, dtype=np.int64)
        weights = np.zeros((len(points), 3))
        for number, (chart, placement) in enumerate(zip(self.charts, self.layout.placements, strict=True)):
            low, high = self.boxes[number]
            slack = _SLACK * float((high - low).max())
            near = np.flatnonzero(((points >= low - slack) & (points <= high + slack)).all(axis=1))
            if len(near):
                found, inside = chart.locator.query(placement.back(points[near]))
                held = found >= 0
                patch[near[held]] = number
                face[near[held]] = found[held]
                weights[near[held]] = inside[held]
        return patch, face, weights

    @cached_property
    def _starts(self) -> IntArray:
        """(patches + 1,) index of each patch's first triangle among all."""
        return np.cumsum([0, *(len(chart.faces) for chart in self.charts)])

    @cached_property
    def _triangles(self) -> FloatArray:
        """(t, 3, 2) all triangles on the map [m]."""
        triangles = [uv[chart.faces] for chart, uv in zip(self.charts, self.uv, strict=True)]
        return np.concatenate(triangles) if triangles else np.zeros((0, 3, 2))


@dataclass(frozen=True, eq=False)
class BodyPoint:
    """A point of the body at a map point.

    Attributes:
        at: Patch, face and weights, as used for contacts, targets and pins.
        link: Name of the covered link.
        link_position: (3,) [m], frame of the link.
        link_normal: (3,) outward unit normal, frame of the link.
    """

    at: SurfacePoint
    link: str
    link_position: FloatArray
    link_normal: FloatArray


def back_project(map_: TactileMap, point: FloatArray) -> BodyPoint:
    """Return the point of the body at a map point. ``Configuration.pose(link)`` transforms it to world coordinates.

    Args:
        map_: The map.
        point: (2,) map point [m].

    Raises:
        MapError: The point is outside all patches.

    Example:
        >>> place = tm.back_project(tactile_map, tactile_map.taxel_points[30])
        >>> place.link, place.link_position.shape
        ('hand', (3,))

    Cost: 0.1 ms; ``TactileMap.to_body_many`` is faster for many points.
    """
    at = map_.to_body(point)
    if at is None:
        raise MapError(
            "this point of the map is outside all patches",
            value=np.asarray(point).tolist(),
            remedy="Choose one inside a patch, such as one of the map's taxel_points",
        )
    skin = map_.skin
    return BodyPoint(at, skin.link(at), readonly(skin.position(at)), readonly(skin.normal(at)))
