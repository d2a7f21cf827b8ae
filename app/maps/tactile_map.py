"""The tactile map: a one-to-one correspondence between the skin and the plane, asked in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.geometry.topology import boundary_loops
from app.maps.chart import Chart
from app.maps.layout import MapLayout
from app.maps.locate import PlaneLocator
from app.skin.skin import Skin


@dataclass(frozen=True, eq=False)
class TactileMap:
    """Skin, charts and layout, and what follows from them.

    Attributes:
        skin: What is mapped.
        charts: One for each patch, in order.
        layout: Where they lie.
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

    @cached_property
    def uv(self) -> tuple[FloatArray, ...]:
        """For each patch the map coordinates (k, 2) [m] of its chart's points."""
        pairs = zip(self.charts, self.layout.placements, strict=True)
        return tuple(readonly(placement.apply(chart.plane)) for chart, placement in pairs)

    @cached_property
    def taxel_points(self) -> FloatArray:
        """(taxels, 2) [m] where each taxel lies on the map."""
        parts = [
            np.einsum("kc,kcd->kd", patch.taxels.weights, uv[chart.faces[patch.taxels.faces]])
            for patch, chart, uv in zip(self.skin.patches, self.charts, self.uv, strict=True)
        ]
        return readonly(np.concatenate(parts) if parts else np.zeros((0, 2)))

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 2) lower-left and upper-right corner of everything on the map [m]."""
        points = np.concatenate(self.uv) if self.uv else np.zeros((1, 2))
        return readonly(np.stack([points.min(axis=0), points.max(axis=0)]))

    @cached_property
    def outlines(self) -> tuple[FloatArray, ...]:
        """For each patch its border (b, 2) [m], closed (the first point is not repeated)."""
        return tuple(
            readonly(uv[boundary_loops(chart.faces)[0]]) for chart, uv in zip(self.charts, self.uv, strict=True)
        )

    @cached_property
    def seams(self) -> tuple[FloatArray, ...]:
        """For each patch the border segments (s, 2, 2) [m] that are joined to another border segment on the body."""
        return tuple(readonly(_seam_segments(chart, uv)) for chart, uv in zip(self.charts, self.uv, strict=True))

    def to_map(self, at: SurfacePoint) -> FloatArray:
        """The map point (2,) [m] of a place on the body; on a seam, that of the copy its face belongs to."""
        return np.asarray(at.weights) @ self.uv[at.patch][self.charts[at.patch].faces[at.face]]

    def to_map_many(self, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
        """Map points (k, 2) [m] of places given by patch (k,), face (k,) and weights (k, 3)."""
        return np.einsum("kc,kcd->kd", weights, self._triangles[self._starts[patch] + face])

    def to_body(self, point: FloatArray) -> SurfacePoint | None:
        """The place on the body behind a map point (2,) [m]; None outside all patches.

        Exact: the containing triangle, not the nearest taxels. Cost: about 50 µs, of 100,000 at once 0.6 µs each.
        """
        patch, face, weights = self.to_body_many(np.asarray(point, dtype=np.float64).reshape(1, 2))
        if face[0] < 0:
            return None
        a, b, c = weights[0]
        return SurfacePoint(int(patch[0]), int(face[0]), (float(a), float(b), float(c)))

    def to_body_many(self, points: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Patch (k,), face (k,) and weights (k, 3) behind map points (k, 2) [m]; patch and face are -1 outside."""
        triangle, weights = self._locator.query(points)
        patch = np.where(triangle >= 0, np.searchsorted(self._starts, triangle, side="right") - 1, -1)
        return patch, np.where(triangle >= 0, triangle - self._starts[patch], -1), weights

    @cached_property
    def _starts(self) -> IntArray:
        """(patches + 1,) number of each patch's first triangle when all are numbered through."""
        return np.cumsum([0, *(len(chart.faces) for chart in self.charts)])

    @cached_property
    def _triangles(self) -> FloatArray:
        """(t, 3, 2) all triangles on the map [m]."""
        triangles = [uv[chart.faces] for chart, uv in zip(self.charts, self.uv, strict=True)]
        return np.concatenate(triangles) if triangles else np.zeros((0, 3, 2))

    @cached_property
    def _locator(self) -> PlaneLocator:
        return PlaneLocator(self._triangles)


def _seam_segments(chart: Chart, uv: FloatArray) -> FloatArray:
    loop = boundary_loops(chart.faces)[0]
    sides = np.stack([loop, np.roll(loop, -1)], axis=1)
    count = len(chart.vertex_of)
    on_body = np.sort(chart.vertex_of[sides], axis=1) @ [count, 1]
    cut = np.sort(chart.seams, axis=1) @ [count, 1]
    return uv[sides[np.isin(on_body, cut)]]
