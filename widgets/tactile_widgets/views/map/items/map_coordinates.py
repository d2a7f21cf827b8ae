"""From the view to the skin and back, without Qt: pixels, scene units, map metres, the body point and the words for it.

``MapCamera`` is what the viewport shows; zoom 1 frames the whole map.
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
"""The map's longer side in scene units. Hundreds, because Qt draws cosmetic points badly in a scene of size one."""


@dataclass(frozen=True)
class SceneTransform:
    """Places map metres (y up) in the scene (y down), the map's upper left corner at the scene's origin.

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
        """The frame whose longer side is ``SCENE_SIZE``; ``bounds``: (2, 2) smallest and largest [m]."""
        (left, bottom), (right, top) = np.asarray(bounds, dtype=np.float64)
        extent = max(right - left, top - bottom)
        scale = SCENE_SIZE / extent if extent > 0 else SCENE_SIZE
        return cls(float(left), float(top), float(scale), (float(right - left) * scale, float(top - bottom) * scale))

    def to_scene(self, points: FloatArray) -> FloatArray:
        """Map points (..., 2) [m] as scene points."""
        points = np.asarray(points, dtype=np.float64)
        return np.stack([(points[..., 0] - self.left), (self.top - points[..., 1])], axis=-1) * self.scale

    def to_map(self, points: FloatArray) -> FloatArray:
        """Scene points (..., 2) as map points [m]."""
        points = np.asarray(points, dtype=np.float64) / self.scale
        return np.stack([points[..., 0] + self.left, self.top - points[..., 1]], axis=-1)

    def placed(self, placement: Placement) -> FloatArray:
        """(3, 2) that takes a chart's points [m] into the scene: a row (x, y, 1) times this is the scene point."""
        corners = placement.apply(np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]))
        scene = self.to_scene(corners)
        return np.concatenate([scene[:2] - scene[2], scene[2:]])


def nearest_taxel(tactile_map: TactileMap, at: SurfacePoint) -> int | None:
    """Number of the taxel of the same patch that is nearest on the map; None for a patch without taxels."""
    first = tactile_map.skin.first[at.patch]
    end = tactile_map.skin.first[at.patch + 1]
    if first == end:
        return None
    away = tactile_map.taxel_points[first:end] - tactile_map.to_map(at)
    return int(first + np.argmin(np.einsum("kd,kd->k", away, away)))


def visible_map(tactile_map: TactileMap, numbers: Sequence[int]) -> TactileMap:
    """The map of these patches only: a press goes through hidden ones."""
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
    units: ReadingUnits = ReadingUnits.CALIBRATED,
    name: str = "",
    fault: str = "",
) -> str:
    """Patch, taxel with its id, module and channel, its pressure and the place on the map, for the hover readout.

    Args:
        tactile_map: The map.
        at: The place.
        pressures: (taxels,) [Pa].
        units: What they may be called.
        name: Of the patch, where a person gave it another than the skin's.
        fault: What is wrong with the taxel, in a word.
    """
    facts = [name or tactile_map.skin.patches[at.patch].name]
    taxel = nearest_taxel(tactile_map, at)
    if taxel is not None:
        facts.append(taxel_words(tactile_map.skin, taxel) + (f", {fault}" if fault else ""))
        if pressures is not None:
            facts.append(f"{format_three_digits(float(pressures[taxel]) / 1e3)}\u202f{units.unit}")
    x, y = 1e3 * tactile_map.to_map(at)
    facts.append(f"x {x:.1f}, y {y:.1f}\u202fmm")
    return "  ·  ".join(facts)


def format_three_digits(value: float) -> str:
    """Three significant digits without an exponent, and nothing finer than a hundredth."""
    magnitude = abs(value)
    decimals = 2 if magnitude < 9.995 else 1 if magnitude < 99.95 else 0
    return f"{value:.{decimals}f}"


def nice_floor(most: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is at most ``most``."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * next(step for step in (5, 2, 1) if step * power <= most * (1 + 1e-9)))


MARGIN_PX = 24.0
LOWEST_ZOOM = 0.5
HIGHEST_ZOOM = 60.0
_CLOSE_SHARE = 0.6
"""Of the room a box that is closed in on takes at least this share."""

Point = tuple[float, float]


@dataclass(frozen=True)
class MapCamera:
    """Which scene point is at the viewport's centre, and how much larger than framed it is drawn.

    Because zoom is relative to the framing, a resized viewport keeps showing the same part of the map.

    Attributes:
        content: Width and height of what there is to see [scene units].
        centre: Scene point at the viewport's centre.
        zoom: 1 frames the whole content.
        origin: Upper left corner of the content [scene units].
    """

    content: Point
    centre: Point
    zoom: float = 1.0
    origin: Point = (0.0, 0.0)

    @classmethod
    def framing(cls, content: Point, origin: Point = (0.0, 0.0)) -> MapCamera:
        """The camera that frames all of ``content``."""
        return cls(content, (origin[0] + content[0] / 2, origin[1] + content[1] / 2), origin=origin)

    def over(self, content: Point, origin: Point, viewport: Point) -> MapCamera:
        """The same picture in a ``viewport``, of a content that is no longer what it was."""
        other = replace(self, content=content, origin=origin, zoom=1.0)
        return replace(other, zoom=self.scale(viewport) / other.scale(viewport))

    def scale(self, viewport: Point) -> float:
        """Pixels per scene unit in a ``viewport`` of this width and height [px]; the aspect is kept."""
        room = (max(viewport[0] - 2 * MARGIN_PX, 1.0), max(viewport[1] - 2 * MARGIN_PX, 1.0))
        return self.zoom * min(room[0] / max(self.content[0], 1e-9), room[1] / max(self.content[1], 1e-9))

    def to_scene(self, pixel: Point, viewport: Point) -> Point:
        """The scene point under a pixel."""
        scale = self.scale(viewport)
        return (
            self.centre[0] + (pixel[0] - viewport[0] / 2) / scale,
            self.centre[1] + (pixel[1] - viewport[1] / 2) / scale,
        )

    def zoomed(self, factor: float, pixel: Point, viewport: Point) -> MapCamera:
        """Zoom by ``factor`` so that the scene point under ``pixel`` stays there, as long as it lies on the map."""
        anchor = self.to_scene(pixel, viewport)
        zoom = min(max(self.zoom * factor, min(LOWEST_ZOOM, self.zoom)), max(HIGHEST_ZOOM, self.zoom))
        ratio = self.zoom / zoom
        moved = (
            anchor[0] + (self.centre[0] - anchor[0]) * ratio,
            anchor[1] + (self.centre[1] - anchor[1]) * ratio,
        )
        return self._looking_at(moved, zoom)

    def panned(self, dx: float, dy: float, viewport: Point) -> MapCamera:
        """Drag the map by this many pixels; the centre never leaves the map, so it cannot get lost."""
        scale = self.scale(viewport)
        return self._looking_at((self.centre[0] - dx / scale, self.centre[1] - dy / scale), self.zoom)

    def closing_in(self, low: Point, high: Point) -> MapCamera:
        """Centred on a box [scene units], all of it in sight; never farther away than now unless it must be."""
        sizes = [max(b - a, 1e-9) for a, b in zip(low, high, strict=True)]
        fits = min(whole / size for whole, size in zip(self.content, sizes, strict=True))
        near = min(max(self.zoom, _CLOSE_SHARE * fits), fits)
        zoom = min(max(near, min(LOWEST_ZOOM, self.zoom)), max(HIGHEST_ZOOM, self.zoom))
        return self._looking_at(((low[0] + high[0]) / 2, (low[1] + high[1]) / 2), zoom)

    def _looking_at(self, centre: Point, zoom: float) -> MapCamera:
        # An edit may have taken the map away from under the centre: it goes no farther out, and is not pulled back.
        low = [min(start, now) for start, now in zip(self.origin, self.centre, strict=True)]
        ends = [start + size for start, size in zip(self.origin, self.content, strict=True)]
        high = [max(end, now) for end, now in zip(ends, self.centre, strict=True)]
        x, y = (min(max(centre[k], low[k]), high[k]) for k in range(2))
        return replace(self, centre=(x, y), zoom=zoom)
