"""Distortion of each face, and patterns that visualise it, as plain numbers without colours.

``distortion`` computes the change of angles, areas and lengths of each face; ``stretch`` is one measure of it over a
map; ``nested_patches`` finds patches inside another. Two textures visualise stretch: a checkerboard is regular on the
map, so the body shows how the map stretches it; circles are round on the body, so the map shows their images (Tissot
1881).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, assert_never

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.symmetric_dirichlet import rest_triangles, rotation_svd
from tactile_maps.geometry.surface.plane import winding_numbers
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch


@dataclass(frozen=True)
class DistortionSummary:
    """Distribution of a measure over the skin's area."""

    median: float
    p95: float
    max: float


@dataclass(frozen=True, eq=False)
class Distortion(ArrayFields):
    """Distortion of every face of a map, numbered through the patches.

    Attributes:
        stretch: (t, 2) singular values s1 >= s2 >= 0 of the map's differential.
        flipped: (t,) faces without positive area on the map.
        areas: (t,) face areas on the body [m²].
    """

    stretch: FloatArray
    flipped: BoolArray
    areas: FloatArray

    @property
    def angle(self) -> FloatArray:
        """(t,) s1 / s2: ratio of the stretches; 1 preserves angles, inf is a line."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.nan_to_num(self.stretch[:, 0] / self.stretch[:, 1], nan=np.inf, posinf=np.inf)

    @property
    def area(self) -> FloatArray:
        """(t,) s1 s2: ratio of areas, regardless of orientation."""
        return self.stretch.prod(axis=1)

    @property
    def isometry(self) -> FloatArray:
        """(t,) max(s1, 1 / s2): largest change of length; 1 preserves lengths."""
        with np.errstate(divide="ignore"):
            return np.maximum(self.stretch[:, 0], 1 / self.stretch[:, 1])

    @property
    def energy(self) -> FloatArray:
        """(t,) symmetric Dirichlet s1² + s2² + 1/s1² + 1/s2² (Smith and Schaefer 2015); 4 is an isometry."""
        with np.errstate(divide="ignore"):
            return (self.stretch**2 + self.stretch**-2.0).sum(axis=1)

    @property
    def mean_energy(self) -> float:
        """Mean by area, which flattening minimises. Raises ``MapError`` without faces."""
        self._check_faces()
        return float(np.average(self.energy, weights=self.areas))

    def spread(self, values: FloatArray) -> DistortionSummary:
        """Return median, 95th percentile and maximum of face values (t,), weighted by area.

        Raises:
            MapError: There are no faces.
        """
        self._check_faces()
        order = np.argsort(values)
        share = (np.cumsum(self.areas[order]) - 0.5 * self.areas[order]) / self.areas.sum()
        # Selected, not interpolated: next to an infinite value interpolation would give nan.
        median, p95 = values[order[np.minimum(np.searchsorted(share, [0.5, 0.95]), len(order) - 1)]]
        return DistortionSummary(float(median), float(p95), float(values.max()))

    def _check_faces(self) -> None:
        if not len(self.areas):
            raise MapError("a map without faces has no distortion", remedy="Measure a map of some patch")


def distortion(map_: TactileMap) -> Distortion:
    """Compare every face on the map with the same face on the body. Cost: 15 ms for 20,000 faces."""
    stretch = []
    turned = []
    areas = []
    for patch, chart, placement in zip(map_.skin.patches, map_.charts, map_.layout.placements, strict=True):
        rest = rest_triangles(patch.surface.vertices[chart.vertex_of], chart.faces)
        corner = placement.scale * chart.plane[chart.faces]
        first = corner[:, 1] - corner[:, 0]
        second = corner[:, 2] - corner[:, 0]
        along = first / rest.base[:, None]
        across = (second - rest.along[:, None] * along) / rest.across[:, None]
        stretch.append(np.abs(rotation_svd(np.stack([along, across], axis=2))[1]))
        turned.append(flipped(chart.plane, chart.faces))
        areas.append(rest.areas)
    return Distortion(np.concatenate(stretch), np.concatenate(turned), np.concatenate(areas))


DistortionMeasure: TypeAlias = Literal["angle", "area", "isometry"]
"""Property of ``Distortion``: s1 / s2, s1 s2, or max(s1, 1 / s2)."""


@dataclass(frozen=True, eq=False)
class Stretch(ArrayFields):
    """A measure of stretch over a map; 1 is no change.

    Attributes:
        measure: Name of the measure.
        faces: (t,) value of every face, numbered through the patches; areas below 1 are smaller on the map.
        flipped: (t,) faces that are upside down.
        spread: Distribution by area of the larger of value and inverse, as in the quality report.
    """

    measure: DistortionMeasure
    faces: FloatArray
    flipped: BoolArray
    spread: DistortionSummary


def stretch(map_: TactileMap, measure: DistortionMeasure) -> Stretch:
    """Measure every face of ``map_``. Cost: 15 ms for 20,000 faces."""
    found = distortion(map_)
    if measure == "angle":
        faces = found.angle
    elif measure == "area":
        faces = found.area
    elif measure == "isometry":
        faces = found.isometry
    else:
        assert_never(measure)
    with np.errstate(divide="ignore"):
        folded = np.maximum(faces, 1 / faces)
    return Stretch(measure, faces, found.flipped, found.spread(folded))


def nested_patches(borders: Sequence[Sequence[FloatArray]], insides: Sequence[FloatArray]) -> FloatArray:
    """Find patches inside another; borders need not meet, and holes are not inside.

    Args:
        borders: Closed borders (n, 2) [m] of each patch.
        insides: A point (2,) inside each patch [m].

    Returns:
        (k, 2) the point of the inner patch, once for each patch around it.
    """
    places = np.reshape(insides, (-1, 2))
    found = [np.zeros((0, 2))]
    for number, border in enumerate(borders):
        around = np.sum([winding_numbers(loop, places) for loop in border], axis=0) != 0
        around[number] = False
        found.append(places[around])
    return np.concatenate(found)


def checkerboard(points: FloatArray, *, side: float, blur: float) -> FloatArray:
    """Return the darkness (k,) of a checkerboard on the map at map points (k, 2), from 0 to 1.

    Args:
        points: Points on the map [m]; the board has the map's origin, so that it does not move with the patches.
        side: Side of a square [m].
        blur: Width of the transition at its edges [m]; a pixel, against aliasing.
    """
    _check_size(side, "side of a square")
    phase = (points / side) % 2.0
    # Distance to the nearest line across x, then y; positive within even squares.
    signed = side * (0.5 - np.abs(np.abs(phase - 1.0) - 0.5)) * np.where(phase < 1.0, 1.0, -1.0)
    nearest = np.abs(signed).min(axis=1) * np.sign(signed[:, 0]) * np.sign(signed[:, 1])
    return np.asarray(np.clip(0.5 + nearest / blur, 0, 1))


class TissotCircles:
    """Equal circles distributed over the skin, round on the body. Built once for a skin.

    Args:
        patches: Patches of the skin.
        radius: Radius of a circle [m].
        spacing: Least distance between centres [m].

    Cost: 40 ms for 10,000 vertices.
    """

    def __init__(self, patches: Sequence[Patch], *, radius: float, spacing: float) -> None:
        _check_size(radius, "radius of a circle")
        self._patches = patches
        self._radius = radius
        chosen = [spaced_subset(patch.surface.vertices, spacing) for patch in patches]
        self.middles = tuple(readonly(patch.surface.vertices[c]) for patch, c in zip(patches, chosen, strict=True))
        """Centres (c, 3) of the circles of each patch [m], link frame."""
        self._normals = [patch.surface.vertex_normals[c] for patch, c in zip(patches, chosen, strict=True)]
        self._trees = [cKDTree(middles) for middles in self.middles]

    def cover(self, patch: IntArray, face: IntArray, weights: FloatArray, *, blur: float) -> FloatArray:
        """Return the darkness (k,) of the circles at points of the skin, from 0 to 1; 0 where ``patch`` is negative.

        Args:
            patch: (k,) patch of each point.
            face: (k,) face of the patch's surface.
            weights: (k, 3) barycentric.
            blur: Width of the transition at a circle's edge [m], on the body.
        """
        result = np.zeros(len(patch))
        for number, surface in enumerate(part.surface for part in self._patches):
            own = np.flatnonzero(patch == number)
            away, nearest = self._trees[number].query(surface.points(face[own], weights[own]))
            # Not through a thin wall: the far side faces the other way.
            same_side = np.einsum("kd,kd->k", surface.face_normals[face[own]], self._normals[number][nearest]) > 0
            result[own] = np.clip(0.5 + (self._radius - away) / blur, 0, 1) * same_side
        return result


def spaced_subset(points: FloatArray, spacing: float) -> IntArray:
    """Select ``points`` (k, d) greedily in order, with at least ``spacing`` between any two; return their indices."""
    _check_size(spacing, "spacing")
    free = np.ones(len(points), bool)
    chosen = []
    tree = cKDTree(points)
    for number in range(len(points)):
        if free[number]:
            chosen.append(number)
            free[tree.query_ball_point(points[number], spacing)] = False
    return np.array(chosen, dtype=np.int64)


def _check_size(size: float, name: str) -> None:
    if not 0 < size < np.inf:
        raise MapError("the size of a pattern must be above zero", place=name, value=f"{size} m")
