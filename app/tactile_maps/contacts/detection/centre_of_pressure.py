"""Centre of pressure of a contact region on map and body, extent of the region, and uncertainty of readings.

``BackProjector`` projects a centre from the map to the body by the triangle that contains it. ``principal_axes`` is the
ellipse with the region's second moments. ``SensorUncertainty`` is the uncertainty of readings, from which
``error_budget`` derives that of force and place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.core.arrays import FloatArray, IntArray, length
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.closest_point import closest_point
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.triangle_walk import TriangleWalk
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.tactile.sensors.sensor_chain import plugin_noise
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

_LARGEST = 1e6
_NO_EFFECTS = SensorEffects()
_MODELS = {"foundation": 0.019, "depth": math.inf}
"""Relative standard uncertainty of the sum of pressure times area; other models conserve force. That of the foundation
is half of what 95 % of balls of 4 to 20 mm on the skin of the arm stay within."""
_NEAREST = 1e-9
"""Distance below which a centre is on a taxel [m]."""


@dataclass(frozen=True)
class SensorUncertainty:
    """Uncertainty of the readings of a skin.

    Attributes:
        noise: Standard deviation of a reading [Pa]; of a skin whose taxels differ, the median.
        gain: Standard deviation of the taxels' gains around 1.
        calibration: Standard deviation of a taxel's place along one axis [m]. Simulated taxels are where they are said
            to be; on real skins 0.002 (NAO, by self-touch) to 0.007 (iCub, by force sensors) were published.
        taxels: Noise of each taxel, where it was measured; then it counts instead of ``noise``.
        effects: Effects of the sensor, whose systematic errors ``error_budget`` derives.
        lag: Root mean square age of a reading [s].
        elapsed: Time that the offsets have drifted [s].
        model: Relative standard uncertainty of the sum of pressure times area as a force, by the contact model.
        lumps: Whether the contact model presses single points, each of which one pad holds as a whole or not at all.
        depth: Depth of the taxels where the contact model spreads forces down to it [m]; 0 at the surface.
        displaced: (taxels,) squared distances of pads from the places of their taxels [m²], where known.
        unknown: Whether the noise is not known: a real skin without tare.

    Raises:
        MapError: A number is out of range.
    """

    noise: float = 0.0
    gain: float = 0.0
    calibration: float = 0.0
    taxels: TaxelNoise | None = None
    effects: SensorEffects = _NO_EFFECTS
    lag: float = 0.0
    elapsed: float = 0.0
    model: float = 0.0
    lumps: bool = False
    depth: float = 0.0
    displaced: FloatArray | None = None
    unknown: bool = False

    def __post_init__(self) -> None:
        for name in ("noise", "gain", "calibration", "lag", "elapsed", "depth"):
            value = getattr(self, name)
            if not 0 <= value < _LARGEST:
                raise MapError("the uncertainty is out of range", place=name, value=value, remedy="Choose 0 or more")

    @classmethod
    def of_sensor(cls, sensor: SensorEffects, *, averaged: float = 0.0, model: str = "") -> SensorUncertainty:
        """Return the uncertainty of a simulated sensor, with that of the stages of plug-ins.

        A converter's step is off by anything up to half of it: its deviation is step / sqrt(12). A sample is read from
        ``delay`` until ``delay + 1 / rate`` after it was taken. The mean of a time is as old as the middle of it.

        Args:
            sensor: Effects of the sensor.
            averaged: Tick whose mean a reading is [s]; 0 for readings of an instant.
            model: Contact model that the readings come from.
        """
        noise = sensor.noise.sd if sensor.noise else 0.0
        step = sensor.quantisation.step if sensor.quantisation else 0.0
        noise = math.hypot(noise, step / math.sqrt(12), plugin_noise(sensor))
        delay = sensor.sampling.delay if sensor.sampling else 0.0
        period = 1 / sensor.sampling.rate if sensor.sampling else 0.0
        delay += 0.5 * max(averaged, period) if averaged else 0.0
        lag = math.sqrt(delay**2 + delay * period + period**2 / 3)
        gain = sensor.gain_spread.sd if sensor.gain_spread else 0.0
        return cls(noise, gain, effects=sensor, lag=lag, model=_MODELS.get(model, 0.0), lumps=model == "point")

    @classmethod
    def measured(cls, noise: TaxelNoise | None) -> SensorUncertainty:
        """Uncertainty of a real skin whose noise was measured; None for unknown noise."""
        return cls(unknown=True) if noise is None else cls(float(np.median(noise.sd)), taxels=noise)

    def noise_of(self, taxels: IntArray, areas: FloatArray) -> float:
        """Standard deviation of a reading of some taxels (k,) with these areas (k,) [Pa]."""
        return self.noise if self.taxels is None else self.taxels.mean_sd(taxels, areas)


class ContactLocation(NamedTuple):
    """A place on body and map.

    Attributes:
        at: Point on the skin.
        map_point: (2,) on the map [m].
        link_position: (3,) link frame [m].
        link_normal: (3,) outward unit normal, link frame.
        link_sides: (2, 3) two sides of its triangle, link frame [m].
        map_sides: (2, 2) the same on the map [m].
        torn: Whether it was found on the body, not on the map.
    """

    at: SurfacePoint
    map_point: FloatArray
    link_position: FloatArray
    link_normal: FloatArray
    link_sides: FloatArray
    map_sides: FloatArray
    torn: bool


class _Triangle(NamedTuple):
    """Data of one triangle of a patch, on body and map; see ``ContactLocation``."""

    body: FloatArray
    normals: FloatArray
    link_sides: FloatArray
    map_sides: FloatArray


class BackProjector:
    """Projection of centres of pressure from map to body. Mutable: ``use`` changes the map.

    Data of a patch are built when it is first touched: 5 ms for 10,000 triangles.

    Args:
        map_: The tactile map.
        body: (taxels, 3) positions on the body [m], each in its link's frame.

    Attributes:
        by_taxels: Whether a centre is projected to the mean of the three nearest taxels, weighted by the inverse of
            their distances on the map, instead of by the triangle that contains it. That mean is off the skin where it
            bends, and jumps where another taxel becomes the third.
    """

    def __init__(self, map_: TactileMap, body: FloatArray) -> None:
        self.by_taxels = False
        self._trees: dict[int, cKDTree] = {}  # of the taxels of a patch on the map
        self._skin = map_.skin
        self._body = body
        self._faces = np.concatenate([patch.taxels.faces for patch in map_.skin.patches]) if len(body) else body
        self._walks: dict[int, TriangleWalk] = {}
        self._triangles: dict[tuple[int, int], _Triangle] = {}  # those that were touched
        self._map = map_

    def use(self, map_: TactileMap) -> None:
        """Use another map of the same skin, possibly with other seams."""
        for patch, (old, new) in enumerate(zip(self._map.charts, map_.charts, strict=True)):
            if old.faces is not new.faces:
                self._walks.pop(patch, None)
        self._triangles.clear()
        self._trees.clear()
        self._map = map_

    def place(self, patch: int, centre: FloatArray, *, near: int) -> ContactLocation | None:
        """Return the place of a point of the map within ``patch``; None outside the patch.

        Args:
            patch: The patch.
            centre: (2,) point on the map [m].
            near: A triangle nearby, where the search begins. Cost: 15 µs, and 3 µs for each triangle on the way.
        """
        map_ = self._map
        walk = self._walks.get(patch)
        if walk is None:
            walk = self._walks[patch] = TriangleWalk(map_.charts[patch].faces)
        x, y = centre.tolist()
        found = walk.find(map_.uv[patch], (x, y), near)
        if found is None:  # a border bends between here and there
            back = map_.layout.placements[patch].back(centre[None])
            faces, weights = map_.charts[patch].locator.query(back)
            if faces[0] < 0:
                return None
            found = int(faces[0]), weights[0]
        place = self._at(patch, *found, map_point=centre, torn=False)
        return self._of_taxels(patch, place) if self.by_taxels else place

    def _of_taxels(self, patch: int, place: ContactLocation) -> ContactLocation:
        """Return the place with the mean of the three nearest taxels on the body. Cost: 60 µs."""
        first, last = self._skin.first[patch : patch + 2]
        tree = self._trees.get(patch)
        if tree is None:
            tree = self._trees[patch] = cKDTree(self._map.taxel_points[first:last])
        away, near = tree.query(place.map_point, k=min(3, int(last - first)))
        away = np.atleast_1d(away)
        near = np.atleast_1d(near)
        share = 1.0 / np.maximum(away, _NEAREST)
        share /= share.sum()
        normal = share @ self._skin.patches[patch].taxels.normals[near]
        size = length(normal)
        found = self.put_back(patch, share @ self._body[first + near])
        return found._replace(
            map_point=place.map_point,
            link_position=share @ self._body[first + near],
            link_normal=normal / size if size > 0 else place.link_normal,
            torn=False,
        )

    def put_back(self, patch: int, point: FloatArray) -> ContactLocation:
        """Return the place on ``patch`` closest to ``point`` (3,) [m], link frame. Cost: 60 µs."""
        faces, weights, _ = closest_point(self._skin.patches[patch].surface).query(point[None])
        corners = self._map.uv[patch][self._map.charts[patch].faces[faces[0]]]
        return self._at(patch, int(faces[0]), weights[0], map_point=weights[0] @ corners, torn=True)

    def face_of(self, taxel: int) -> int:
        """Return the triangle of its patch that contains a taxel."""
        return int(self._faces[taxel])

    def _at(self, patch: int, face: int, weights: FloatArray, *, map_point: FloatArray, torn: bool) -> ContactLocation:
        body, normals, link_sides, map_sides = self._triangles.get((patch, face)) or self._triangle(patch, face)
        normal = weights.dot(normals)
        size = length(normal)
        normal = normal / size if size > 0 else self._skin.patches[patch].surface.face_normals[face]
        a, b, c = weights.tolist()
        at = SurfacePoint(patch, face, (a, b, c))
        return ContactLocation(at, map_point, weights.dot(body), normal, link_sides, map_sides, torn)

    def _triangle(self, patch: int, face: int) -> _Triangle:
        surface = self._skin.patches[patch].surface
        own = surface.faces[face]
        chart = self._map.charts[patch].faces[face]
        body = surface.vertices[own]
        plane = self._map.uv[patch][chart]
        found = _Triangle(body, surface.vertex_normals[own], body[1:] - body[0], plane[1:] - plane[0])
        self._triangles[patch, face] = found
        return found


_Vector = tuple[float, float, float]


def principal_axes(
    offsets: FloatArray, share: FloatArray, spread: float, at: ContactLocation
) -> tuple[FloatArray, FloatArray]:
    """Return the half-axes of the ellipse with the same second moments of pressure, the longer first.

    A half-axis is twice the standard deviation along it, which is exact for an evenly pressed ellipse. Moments are
    computed in the tangent plane at the centre, so that a region that bends around the link appears shorter. The axes
    on the map follow from the differential of the containing triangle.

    Args:
        offsets: (k, 3) from the centre to the taxels [m], link frame.
        share: (k,) share of the force on each; they sum to 1.
        spread: Mean variance of a taxel's own area along one axis [m²].
        at: The centre.

    Returns:
        (2, 3) axes in the link frame and (2, 2) on the map [m]. Cost: 9 µs.
    """
    frame = np.array(_tangents(*at.link_normal.tolist(), *at.link_sides[0].tolist()))
    flat = offsets.dot(frame.T)
    (xx, xy), (_, yy) = (flat.T * share).dot(flat).tolist()
    x, y = share.dot(flat).tolist()
    xx = xx - x * x
    xy = xy - x * y
    yy = yy - y * y
    middle = 0.5 * (xx + yy)
    half = math.hypot(0.5 * (xx - yy), xy)
    angle = 0.5 * math.atan2(2 * xy, xx - yy)
    long = 2 * math.sqrt(max(middle + half, 0.0) + spread)
    short = 2 * math.sqrt(max(middle - half, 0.0) + spread)
    cosine = math.cos(angle)
    sine = math.sin(angle)
    axes = np.array(((long * cosine, long * sine), (-short * sine, short * cosine))).dot(frame)
    return axes, _carry(axes, at)


def _tangents(nx: float, ny: float, nz: float, x: float, y: float, z: float) -> tuple[_Vector, _Vector]:
    """Return two unit vectors perpendicular to the unit normal, the first along the projection of (x, y, z)."""
    along = x * nx + y * ny + z * nz
    x = x - along * nx
    y = y - along * ny
    z = z - along * nz
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-12:  # the side is along the normal: use any direction
        return _tangents(nx, ny, nz, *((1.0, 0.0, 0.0) if abs(nx) < 0.5 else (0.0, 1.0, 0.0)))
    x = x / length
    y = y / length
    z = z / length
    return (x, y, z), (ny * z - nz * y, nz * x - nx * z, nx * y - ny * x)


def _carry(axes: FloatArray, at: ContactLocation) -> FloatArray:
    """Return ``axes`` (2, 3) on the map (2, 2), by the differential of the triangle; zero if it has no area."""
    (a, b), (_, d) = at.link_sides.dot(at.link_sides.T).tolist()
    determinant = a * d - b * b
    if determinant <= 1e-13 * a * d:
        return np.zeros((2, 2))
    inverse = np.array(((d / determinant, -b / determinant), (-b / determinant, a / determinant)))
    return axes.dot(at.link_sides.T).dot(inverse).dot(at.map_sides)
