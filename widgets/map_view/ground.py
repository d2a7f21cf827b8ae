"""What bare skin looks like on the map under an overlay, as pixels, with its legend in numbers. Knows no Qt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint
from app.maps.overlay import BodyCircles, Measure, Stretch, checker, stretch
from app.maps.tactile_map import TactileMap
from widgets.colours import PressureScale, StretchScale, words32
from widgets.map_view.atlas import Atlas
from widgets.map_view.map_hit import nice_length, three_digits
from widgets.overlays import Ground

SCALE = StretchScale()
_LIGHT, _SHADE = PressureScale().table[0].astype(np.float64), np.array([172.0, 181.0, 191.0])
"""Of the textures: the bare skin's own neutral, and one darker."""
FLIPPED = (224, 49, 49)
_PATTERNS_ACROSS = 20.0
THIN = "\u2009"


@dataclass(frozen=True, eq=False)
class GroundPicture:
    """The ground of one map.

    Attributes:
        kind: Which.
        pixels: (h, w) 0xffRRGGBB; only those on the skin mean anything.
        stretch: What is shown, where it is stretch.
        note: What the legend says about it.
    """

    kind: Ground
    pixels: NDArray[np.uint32]
    note: str
    stretch: Stretch | None = None

    def tell(self, map_: TactileMap, at: SurfacePoint) -> str:
        """The stretch of the face at a place, in words; empty for a texture."""
        if self.stretch is None:
            return ""
        face = at.face + sum(len(chart.faces) for chart in map_.charts[: at.patch])
        return f"{self.stretch.measure}s ×{three_digits(float(self.stretch.faces[face]))}"


def paint_ground(kind: Ground, map_: TactileMap, image: Atlas) -> GroundPicture | None:
    """Make the ground of ``map_`` on its ``image``; None for pressure, whose ground is plain. Cost: 20 to 80 ms.

    Textures are those of the patches at their true size; stretch is that of the map as it is arranged.
    """
    if kind is Ground.PRESSURE:
        return None
    if kind is Ground.ANGLE:
        return _stretched(kind, map_, image, "angle")
    if kind is Ground.AREA:
        return _stretched(kind, map_, image, "area")
    size = pattern_size(map_)
    length = f"{1e3 * size:g}{THIN}mm"
    if kind is Ground.CHECKER:
        dark = checker(image.centres(), side=size, blur=image.resolution)
        return GroundPicture(kind, _shaded(dark, image), f"Squares of {length}, laid flat")
    if kind is Ground.CIRCLES:
        circles = BodyCircles(map_.skin.patches, radius=size / 2, spacing=1.5 * size)
        dark = circles.cover(*image.places, blur=image.resolution)
        return GroundPicture(kind, _shaded(dark, image), f"Circles {length} across on the body")
    assert_never(kind)


def pattern_size(map_: TactileMap) -> float:
    """Side of a square, or width of a circle [m]: a round number, about a twentieth of the map."""
    area = sum(patch.surface.area for patch in map_.skin.patches)
    most = float(np.sqrt(area)) / _PATTERNS_ACROSS
    return 1e-3 * nice_length(1e3 * most)


def _stretched(kind: Ground, map_: TactileMap, image: Atlas, measure: Measure) -> GroundPicture:
    found = stretch(map_, measure)
    patch, face, _ = image.places
    first = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    palette = SCALE.rgb(found.faces)
    palette[found.flipped] = FLIPPED
    colours = words32(palette)[np.maximum(first[patch] + face, 0)]
    spread = found.spread
    numbers = f"Median ×{spread.median:.2f}   95{THIN}% ×{spread.p95:.2f}   max ×{three_digits(spread.max)}"
    return GroundPicture(kind, _carried_out(colours, image), numbers, found)


def _shaded(dark: FloatArray, image: Atlas) -> NDArray[np.uint32]:
    colours = _LIGHT + dark[:, None] * (_SHADE - _LIGHT)
    return _carried_out(words32(colours.round().astype(np.uint8)), image)


def _carried_out(colours: NDArray[np.uint32], image: Atlas) -> NDArray[np.uint32]:
    """(h, w): border pixels whose centre is beside the skin take the colour of a neighbour on it."""
    grid = colours.reshape(image.shape).copy()
    bare = image.shown & ~image.inside
    rows, columns = np.nonzero(bare)
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        y, x = np.clip(rows + dy, 0, image.shape[0] - 1), np.clip(columns + dx, 0, image.shape[1] - 1)
        found = image.inside[y, x] & bare[rows, columns]
        grid[rows[found], columns[found]] = grid[y[found], x[found]]
        bare[rows[found], columns[found]] = False
    return grid
