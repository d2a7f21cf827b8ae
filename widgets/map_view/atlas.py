"""The live image of a whole map: the patches' tiles side by side, wherever a person has put the patches. No Qt.

Moving, turning, mirroring or scaling a patch changes nothing here; another chart rebuilds its own tile only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from app.arrays import BoolArray, FloatArray, IntArray
from app.maps.chart import Chart
from app.maps.interpolation.triangles import stacked
from app.maps.tactile_map import TactileMap
from app.skin.skin import Skin
from widgets.map_view.tile import Tile

_SPARE = 8
_TOO_MANY = 4.0
"""As many times the pixels of the map as it was first packed, and they become larger."""


@dataclass(frozen=True)
class ImageLook:
    """How the live image is made.

    Attributes:
        interpolation: What lies between taxels; a name in ``INTERPOLATIONS``.
        pixels: Side of a square with as many pixels as the image has for a map as it was first packed.
    """

    interpolation: str = "barycentric"
    pixels: int = 512


class Atlas:
    """All tiles in one image, row 0 at the top. Built for charts, whatever their layout; asked every frame.

    Args:
        map_: Its charts are shown; its bounds give the size of a pixel.
        known: An atlas of the same skin: tiles of charts that are the same are taken from there, and the pixel's size.
        look: How it is made; a known one of another look is no help.

    Attributes:
        tiles: One for each patch.
        spare: A few of the atlases before, for a person who undoes.
        shape: Rows and columns.
        resolution: Side of a pixel [m].

    Cost: 0.15 s for 1000 taxels on 20,000 faces; with ``known``, that of the tiles that are new, and 5 ms.
    """

    def __init__(self, map_: TactileMap, *, known: Atlas | None = None, look: ImageLook = ImageLook()) -> None:
        known = known if known is not None and known.look == look else None
        self.look: ImageLook = look
        self.resolution: float = _resolution(map_, known, look.pixels)
        kept = (*known.tiles, *known.spare) if known is not None and known.resolution == self.resolution else ()
        found = {id(tile.chart): tile for tile in kept}
        self.tiles: tuple[Tile, ...] = tuple(
            found.get(id(chart)) or Tile.of(patch, chart, self.resolution, look.interpolation)
            for patch, chart in zip(map_.skin.patches, map_.charts, strict=True)
        )
        worn = {id(tile.chart) for tile in self.tiles}
        self.spare: tuple[Tile, ...] = tuple(tile for key, tile in found.items() if key not in worn)[:_SPARE]
        self._corners, self.shape = _shelved([tile.shape for tile in self.tiles])
        self._skin = map_.skin
        self._pixels = self._through([tile.pixels for tile in self.tiles])
        self._weights = _joined([tile.weights for tile in self.tiles], map_.skin)

    @property
    def charts(self) -> tuple[Chart, ...]:
        """What the tiles show."""
        return tuple(tile.chart for tile in self.tiles)

    @property
    def halo(self) -> tuple[IntArray, IntArray]:
        """Flat numbers of the pixels around the patches, and of those that they copy."""
        return self._through([tile.halo for tile in self.tiles]), self._through([tile.source for tile in self.tiles])

    def render(self, pressures: FloatArray, out: NDArray[np.float32]) -> None:
        """Write the pressures (taxels,) [Pa] into ``out`` (rows, columns) [kPa]. Cost: 0.3 ms."""
        out.reshape(-1)[self._pixels] = self._weights @ (1e-3 * np.asarray(pressures)).astype(np.float32)

    def window(self, number: int) -> tuple[slice, slice]:
        """Rows and columns of a patch's tile."""
        (row, column), (height, width) = self._corners[number], self.tiles[number].shape
        return slice(row, row + height), slice(column, column + width)

    @property
    def extent(self) -> FloatArray:
        """(2, 2) lower-left and upper-right corner of the image in its own plane [m]."""
        rows, columns = self.shape
        return np.array([[0.0, 0.0], [columns, rows]]) * self.resolution

    def plane(self, number: int) -> FloatArray:
        """(k, 2) where the points of a patch's chart lie in the image's own plane [m]."""
        tile, (row, column) = self.tiles[number], self._corners[number]
        corner = np.array([column, self.shape[0] - row]) * self.resolution
        return tile.chart.plane - tile.corner + corner

    # For grounds: what is behind each pixel.

    @cached_property
    def places(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Patch and face (pixels,) and weights (pixels, 3) behind each pixel's centre; -1 off the skin."""
        patch, face = np.full((2, *self.shape), -1, dtype=np.int64)
        weights = np.zeros((*self.shape, 3))
        for number, tile in enumerate(self.tiles):
            there = self.window(number)
            patch[there] = np.where(tile.inside, number, -1)
            face[there], weights[there] = tile.face, tile.bary
        return patch.ravel(), face.ravel(), weights.reshape(-1, 3)

    def centres(self) -> FloatArray:
        """(pixels, 2) chart points of the pixels' centres, each in its own tile's chart [m]; 0 off the tiles."""
        result = np.zeros((*self.shape, 2))
        for number, tile in enumerate(self.tiles):
            rows, columns = np.indices(tile.shape)
            result[self.window(number)] = tile.chart_points(np.stack([columns, rows], axis=-1))
        return result.reshape(-1, 2)

    @property
    def inside(self) -> BoolArray:
        """(rows, columns) pixels whose centre is on the skin."""
        return (self.places[0] >= 0).reshape(self.shape)

    @property
    def shown(self) -> BoolArray:
        """(rows, columns) the same grown by a pixel."""
        shown = np.zeros(self.shape, bool)
        shown.reshape(-1)[self._pixels] = True
        return shown

    def _through(self, numbers: Sequence[IntArray]) -> IntArray:
        """Flat numbers of the tiles as those of the image, one tile after the other."""
        parts = [np.zeros(0, np.int64)]
        for tile, own, (row, column) in zip(self.tiles, numbers, self._corners, strict=True):
            y, x = np.divmod(own, tile.shape[1])
            parts.append((y + row) * self.shape[1] + x + column)
        return np.concatenate(parts)


def _resolution(map_: TactileMap, known: Atlas | None, pixels: int) -> float:
    """Side of a pixel [m]; the known one while that does not make far too many."""
    if known is not None:
        area = sum(float(np.prod(np.ptp(chart.plane, axis=0))) for chart in map_.charts)
        if area <= _TOO_MANY * (pixels * known.resolution) ** 2:
            return known.resolution
        return float(np.sqrt(area)) / pixels
    return max(float(np.sqrt(np.prod(np.ptp(map_.bounds, axis=0)))) / pixels, 1e-9)


def _shelved(shapes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Row and column of each tile's first pixel, in rows of falling height, and the size of it all."""
    widest = max([*(width for _, width in shapes), round(1.1 * sum(h * w for h, w in shapes) ** 0.5), 1])
    corners: dict[int, tuple[int, int]] = {}
    top = column = tall = right = 0
    for number in sorted(range(len(shapes)), key=lambda k: -shapes[k][0]):
        height, width = shapes[number]
        if column + width > widest:
            top, column, tall = top + tall, 0, 0
        corners[number] = top, column
        column, tall = column + width, max(tall, height)
        right = max(right, column)
    return [corners[k] for k in range(len(shapes))], (max(top + tall, 1), max(right, 1))


def _joined(weights: Sequence[csr_matrix], skin: Skin) -> csr_matrix:
    """One matrix for all taxels, the tiles' pixels one below the other."""
    count = len(skin)
    blocks = [
        csr_matrix((part.data, part.indices + first, part.indptr), shape=(part.shape[0], count))
        for part, first in zip(weights, skin.first[:-1], strict=True)
    ]
    return stacked([csr_matrix((0, count), dtype=np.float32), *blocks]).astype(np.float32)
