"""Conversion between pixels, scene units, map points and skin locations, and their description; without Qt.

Scene units are the coordinates of the ``QGraphicsScene``. ``MapCamera`` is the part of it that the viewport shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.document.taxel_search import taxel_words

SCENE_SIZE = 1000.0
"""Longer side of the map [scene units]; hundreds, because Qt draws cosmetic points badly in a scene of size one."""


@dataclass(frozen=True)
class SceneTransform:
    """Transform between map points (y up) and scene points (y down); the map's upper left corner is the origin.

    Attributes:
        left: Smallest map x [m].
        top: Largest map y [m].
        scale: Scene units per metre.
        size: Width and height of the map [scene units].
    """

    left: float
    top: float
    scale: float
    size: tuple[float, float]

    @classmethod
    def around(cls, bounds: FloatArray) -> SceneTransform:
        """Return the transform of a map with these bounds, (2, 2) minimum and maximum [m], to ``SCENE_SIZE``."""
        (left, bottom), (right, top) = np.asarray(bounds, dtype=np.float64)
        extent = max(right - left, top - bottom)
        scale = SCENE_SIZE / extent if extent > 0 else SCENE_SIZE
        return cls(float(left), float(top), float(scale), (float(right - left) * scale, float(top - bottom) * scale))

    def to_scene(self, points: FloatArray) -> FloatArray:
        """Convert map points (..., 2) [m] to scene points."""
        points = np.asarray(points, dtype=np.float64)
        return np.stack([(points[..., 0] - self.left), (self.top - points[..., 1])], axis=-1) * self.scale

    def to_map(self, points: FloatArray) -> FloatArray:
        """Convert scene points (..., 2) to map points [m]."""
        points = np.asarray(points, dtype=np.float64) / self.scale
        return np.stack([points[..., 0] + self.left, self.top - points[..., 1]], axis=-1)

    def placed(self, placement: Placement) -> FloatArray:
        """(3, 2) matrix from a chart's points [m] to scene points: a row (x, y, 1) times this is the scene point."""
        corners = placement.apply(np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]))
        scene = self.to_scene(corners)
        return np.concatenate([scene[:2] - scene[2], scene[2:]])


def nearest_taxel(tactile_map: TactileMap, at: SurfacePoint) -> int | None:
    """Return the taxel of the same patch that is nearest on the map; None for a patch without taxels."""
    first = tactile_map.skin.first[at.patch]
    end = tactile_map.skin.first[at.patch + 1]
    if first == end:
        return None
    away = tactile_map.taxel_points[first:end] - tactile_map.to_map(at)
    return int(first + np.argmin(np.einsum("kd,kd->k", away, away)))


def visible_map(tactile_map: TactileMap, numbers: Sequence[int]) -> TactileMap:
    """Return the map of these patches only, so that a press ignores hidden ones."""
    if len(numbers) == len(tactile_map.charts):
        return tactile_map
    patches = tactile_map.skin.patches
    placements = tactile_map.layout.placements
    return TactileMap(
        Skin(tuple(patches[k] for k in numbers)),
        tuple(tactile_map.charts[k] for k in numbers),
        MapLayout(tuple(placements[k] for k in numbers)),
    )


def readout_text(
    tactile_map: TactileMap,
    at: SurfacePoint,
    pressures: FloatArray | None,
    *,
    shear: FloatArray | None = None,
    units: ReadingUnits = ReadingUnits.CALIBRATED,
    name: str = "",
    fault: str = "",
) -> str:
    """Describe a skin location: patch, taxel with its id, module and channel, pressure and map point.

    Args:
        tactile_map: The map.
        at: Skin location.
        pressures: (taxels,) [Pa]; None for no pressure.
        shear: (taxels, 2) traction along the skin [Pa]; None if it is not measured.
        units: Units of the readings.
        name: Name of the patch, if the user renamed it.
        fault: Description of the taxel's fault.
    """
    facts = [name or tactile_map.skin.patches[at.patch].name]
    taxel = nearest_taxel(tactile_map, at)
    if taxel is not None:
        facts.append(taxel_words(tactile_map.skin, taxel) + (f", {fault}" if fault else ""))
        if pressures is not None:
            facts.append(f"{format_three_digits(float(pressures[taxel]) / 1e3)}\u202f{units.unit}")
        if shear is not None:
            traction = float(np.linalg.norm(shear[taxel])) / 1e3
            facts.append(f"shear {format_three_digits(traction)}\u202f{units.unit}")
    x, y = 1e3 * tactile_map.to_map(at)
    facts.append(f"x {x:.1f}, y {y:.1f}\u202fmm")
    return "  ·  ".join(facts)


def format_three_digits(value: float) -> str:
    """Format with three significant digits and at most two decimals, without an exponent."""
    magnitude = abs(value)
    decimals = 2 if magnitude < 9.995 else 1 if magnitude < 99.95 else 0
    return f"{value:.{decimals}f}"


def nice_floor(most: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is at most ``most``."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * next(step for step in (5, 2, 1) if step * power <= most * (1 + 1e-9)))


MARGIN_PX = 24.0
LOWEST_ZOOM = 0.5
HIGHEST_ZOOM = 60.0
_NEARLY = 0.1
"""Largest difference of centre and zoom with which the whole content still counts as in view, as a fraction."""
_CLOSE_SHARE = 0.6
"""Minimum fraction of the viewport that a box fills after ``closing_in``."""

Point = tuple[float, float]


@dataclass(frozen=True)
class MapCamera:
    """Scene point at the viewport's centre, and zoom relative to the whole content.

    Because zoom is relative, a resized viewport keeps showing the same part of the map.

    Attributes:
        content: Width and height of the content [scene units].
        centre: Scene point at the viewport's centre.
        zoom: 1 if the content just fits into the viewport.
        origin: Upper left corner of the content [scene units].
    """

    content: Point
    centre: Point
    zoom: float = 1.0
    origin: Point = (0.0, 0.0)

    @classmethod
    def framing(cls, content: Point, origin: Point = (0.0, 0.0)) -> MapCamera:
        """Return the camera that shows all of ``content``."""
        return cls(content, (origin[0] + content[0] / 2, origin[1] + content[1] / 2), origin=origin)

    def with_margins(self, right: float, top: float, viewport: Point) -> MapCamera:
        """Return the camera that frames the content with more space at its right and above it [px]."""
        room = (max(viewport[0] - right, 1.0), max(viewport[1] - top, 1.0))
        scale = MapCamera.framing(self.content).scale(room)
        content = (self.content[0] + right / scale, self.content[1] + top / scale)
        return MapCamera.framing(content, (self.origin[0], self.origin[1] - top / scale))

    @property
    def framed(self) -> bool:
        """Whether the camera shows the whole content, apart from what small edits change."""
        middle = MapCamera.framing(self.content, self.origin).centre
        near = zip(self.centre, middle, self.content, strict=True)
        return all(abs(at - centre) <= _NEARLY * size for at, centre, size in near) and (
            1 - _NEARLY <= self.zoom <= 1 + _NEARLY
        )

    def over(self, content: Point, origin: Point, viewport: Point) -> MapCamera:
        """Return the camera that shows the same part of changed content in a viewport."""
        other = replace(self, content=content, origin=origin, zoom=1.0)
        return replace(other, zoom=self.scale(viewport) / other.scale(viewport))

    def scale(self, viewport: Point) -> float:
        """Pixels per scene unit in a viewport of this width and height [px]; the aspect ratio is kept."""
        room = (max(viewport[0] - 2 * MARGIN_PX, 1.0), max(viewport[1] - 2 * MARGIN_PX, 1.0))
        return self.zoom * min(room[0] / max(self.content[0], 1e-9), room[1] / max(self.content[1], 1e-9))

    def to_scene(self, pixel: Point, viewport: Point) -> Point:
        """Return the scene point under a pixel."""
        scale = self.scale(viewport)
        return (
            self.centre[0] + (pixel[0] - viewport[0] / 2) / scale,
            self.centre[1] + (pixel[1] - viewport[1] / 2) / scale,
        )

    def zoomed(self, factor: float, pixel: Point, viewport: Point) -> MapCamera:
        """Zoom by ``factor`` around the scene point under ``pixel``, if it is on the map."""
        anchor = self.to_scene(pixel, viewport)
        zoom = self._limited(self.zoom * factor)
        ratio = self.zoom / zoom
        moved = (
            anchor[0] + (self.centre[0] - anchor[0]) * ratio,
            anchor[1] + (self.centre[1] - anchor[1]) * ratio,
        )
        return self._looking_at(moved, zoom)

    def panned(self, dx: float, dy: float, viewport: Point) -> MapCamera:
        """Drag the map by this many pixels; the centre stays on the map, so that the map cannot get lost."""
        scale = self.scale(viewport)
        return self._looking_at((self.centre[0] - dx / scale, self.centre[1] - dy / scale), self.zoom)

    def closing_in(self, low: Point, high: Point) -> MapCamera:
        """Centre the view on a box [scene units] and show all of it; zooms out only if necessary."""
        sizes = [max(b - a, 1e-9) for a, b in zip(low, high, strict=True)]
        fits = min(whole / size for whole, size in zip(self.content, sizes, strict=True))
        zoom = self._limited(min(max(self.zoom, _CLOSE_SHARE * fits), fits))
        return self._looking_at(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2), zoom)

    def _limited(self, zoom: float) -> float:
        return min(max(zoom, min(LOWEST_ZOOM, self.zoom)), max(HIGHEST_ZOOM, self.zoom))

    def _looking_at(self, centre: Point, zoom: float) -> MapCamera:
        # An edit may have moved the map away from the centre: it then moves no farther out, but is not moved back.
        low = [min(start, now) for start, now in zip(self.origin, self.centre, strict=True)]
        ends = [start + size for start, size in zip(self.origin, self.content, strict=True)]
        high = [max(end, now) for end, now in zip(ends, self.centre, strict=True)]
        x, y = (min(max(centre[k], low[k]), high[k]) for k in range(2))
        return replace(self, centre=(x, y), zoom=zoom)
