"""Image of a map for continuous display: a tile for each patch, all tiles in one atlas.

A tile is in the frame of its chart, so moving, rotating, mirroring or scaling a patch changes nothing here; another
chart rebuilds only its own tile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csc_matrix, csr_matrix

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.flattening.chart import Chart
from tactile_maps.maps.model.interpolation import stack_rows
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin

HALO_PX = 3.0
"""Width of the halo around a patch that repeats its border colours, so that smooth drawing never blends with the
background."""
PAD = 4
"""Free pixels around the patch, for the halo and for closed contours."""


@dataclass(frozen=True, eq=False)
class AtlasTile:
    """Pixels of one patch; row 0 is at the top. Flat indices are row * width + column.

    Attributes:
        chart: The chart of the patch.
        resolution: Side of a pixel [m].
        corner: (2,) chart point at the upper left corner of the first pixel [m].
        inside: (h, w) whether a pixel's centre is on the chart.
        pixels: (k,) flat indices of pixels that show touch: those inside and their neighbours.
        weights: Sparse (k, taxels of the patch): interpolation weights of these pixels.
        halo: (j,) flat indices of pixels just outside.
        source: (j,) flat index of the pixel that each of them copies.
        face: (h, w) face of the chart at each pixel; -1 outside.
        bary: (h, w, 3) barycentric weights in it.
    """

    chart: Chart
    resolution: float
    corner: FloatArray
    inside: BoolArray
    pixels: IntArray
    weights: csr_matrix
    halo: IntArray
    source: IntArray
    face: IntArray
    bary: FloatArray

    @classmethod
    def of(cls, patch: Patch, chart: Chart, resolution: float, interpolation: str = "barycentric") -> AtlasTile:
        """Build the tile of a patch. Cost: 60 ms for 10,000 faces, 500 taxels and 300² pixels.

        Raises:
            MapError: Same as for ``TactileImage``.
        """
        alone = TactileMap(Skin((patch,)), (chart,), MapLayout((Placement(),)))
        image = TactileImage(alone, resolution=resolution, interpolation=interpolation)
        _, face, bary = image.places
        shown = np.pad(image.shown, PAD)
        halo, source = halo_of(shown)
        (left, _), (_, top) = image.extent
        return cls(
            chart,
            resolution,
            np.array([left - PAD * resolution, top + PAD * resolution]),
            np.pad(image.inside, PAD),
            np.flatnonzero(shown),
            image.weights[np.flatnonzero(image.shown)],
            halo,
            source,
            np.pad(face.reshape(image.shape), PAD, constant_values=-1),
            np.pad(bary.reshape(*image.shape, 3), ((PAD, PAD), (PAD, PAD), (0, 0))),
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        height, width = self.inside.shape
        return height, width

    def chart_points(self, places: FloatArray) -> FloatArray:
        """Return chart points (..., 2) [m] of pixel positions (column, row), counted from the first pixel's centre."""
        return self.corner + (places + 0.5) * self.resolution * [1.0, -1.0]


def halo_of(inside: BoolArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return flat indices of the pixels just outside, and of the inside pixel nearest to each."""
    if inside.all() or not inside.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    distance, nearest = distance_transform_edt(~inside, return_indices=True)
    halo = np.flatnonzero((distance > 0) & (distance <= HALO_PX))
    rows = nearest[0].ravel()[halo]
    columns = nearest[1].ravel()[halo]
    return halo, np.ravel_multi_index((rows, columns), inside.shape)


_SPARE = 8
_FEW = 0.25
"""Share of all weights up to which writing only the changed pixels is faster."""
_MAX_GROWTH = 4.0
"""Growth of the number of pixels since the first packing above which pixels become larger."""


@dataclass(frozen=True)
class ImageSettings:
    """Settings of the displayed image.

    Attributes:
        interpolation: Method between taxels; a name in ``INTERPOLATIONS``.
        pixels: Side of a square with as many pixels as the image of the map has when first packed.
    """

    interpolation: str = "barycentric"
    pixels: int = 512


class ImageAtlas:
    """All tiles in one image, row 0 at the top. Built for charts, independent of their layout; rendered every frame.

    Args:
        map_: The map; its bounds determine the size of a pixel.
        known: An earlier atlas of the same skin, from which the tiles of unchanged charts and the pixel size are
            reused.
        look: Settings; an earlier atlas with other settings is ignored.

    Attributes:
        skin: Whose map it shows.
        look: Settings.
        tiles: One tile per patch.
        spare: A few tiles of earlier atlases, for undo.
        shape: Rows and columns.
        resolution: Side of a pixel [m].

    Cost: 0.15 s for 1000 taxels on 20,000 faces; with ``known``, that of the tiles that are new, and 5 ms.
    """

    def __init__(
        self, map_: TactileMap, *, known: ImageAtlas | None = None, look: ImageSettings = ImageSettings()
    ) -> None:
        known = known if known is not None and known.look == look else None
        self.skin: Skin = map_.skin
        self.look: ImageSettings = look
        self.resolution: float = _resolution(map_, known, look.pixels)
        kept = (*known.tiles, *known.spare) if known is not None and known.resolution == self.resolution else ()
        found = {id(tile.chart): tile for tile in kept}
        self.tiles: tuple[AtlasTile, ...] = tuple(
            found.get(id(chart)) or AtlasTile.of(patch, chart, self.resolution, look.interpolation)
            for patch, chart in zip(map_.skin.patches, map_.charts, strict=True)
        )
        used = {id(tile.chart) for tile in self.tiles}
        self.spare: tuple[AtlasTile, ...] = tuple(tile for key, tile in found.items() if key not in used)[:_SPARE]
        self._corners, self.shape = _shelf_packing([tile.shape for tile in self.tiles])
        self._pixels = self._through([tile.pixels for tile in self.tiles])
        self._weights = _stacked_weights([tile.weights for tile in self.tiles], map_.skin)

    @property
    def charts(self) -> tuple[Chart, ...]:
        """Charts of the tiles."""
        return tuple(tile.chart for tile in self.tiles)

    def has_charts(self, charts: Sequence[Chart]) -> bool:
        """Whether the tiles show exactly these charts."""
        return all(tile.chart is chart for tile, chart in zip(self.tiles, charts, strict=True))

    @property
    def halo(self) -> tuple[IntArray, IntArray]:
        """Flat indices of the pixels around the patches, and of those that they copy."""
        return self._through([tile.halo for tile in self.tiles]), self._through([tile.source for tile in self.tiles])

    def render(
        self, pressures: FloatArray, out: NDArray[np.float32], *, changed: IntArray | None = None
    ) -> IntArray | None:
        """Write the pressures (taxels,) [Pa] into ``out`` (rows, columns) [kPa]; return the written flat indices.

        Args:
            pressures: Pressures of all taxels.
            out: Target image.
            changed: (k,) taxels whose pressure may differ from ``out``; None for all. If they affect much of the image,
                all of it is written and None is returned.

        Cost: 0.3 ms; 0.05 ms for a touch of a few taxels.
        """
        kilopascals = (1e-3 * np.asarray(pressures)).astype(np.float32)
        if changed is not None:
            ends = self._taxel_rows.indptr
            if int((ends[changed + 1] - ends[changed]).sum()) < _FEW * self._taxel_rows.nnz:
                affected = np.zeros(len(self._pixels), bool)  # np.unique takes 3 ms
                affected[self._taxel_rows[:, changed].indices] = True
                rows = np.flatnonzero(affected)
                written = self._pixels[rows]
                out.reshape(-1)[written] = self._weights[rows] @ kilopascals
                return written
        out.reshape(-1)[self._pixels] = self._weights @ kilopascals
        return None

    @cached_property
    def _taxel_rows(self) -> csc_matrix:
        """The weights by column, to find the rows that each taxel affects."""
        return self._weights.tocsc()

    def window(self, number: int) -> tuple[slice, slice]:
        """Return the rows and columns of a patch's tile."""
        (row, column), (height, width) = self._corners[number], self.tiles[number].shape
        return slice(row, row + height), slice(column, column + width)

    @property
    def extent(self) -> FloatArray:
        """(2, 2) lower-left and upper-right corner of the image in its plane [m]."""
        rows, columns = self.shape
        return np.array([[0.0, 0.0], [columns, rows]]) * self.resolution

    def plane(self, number: int) -> FloatArray:
        """Return the points (k, 2) of a patch's chart in the plane of the image [m]."""
        tile, (row, column) = self.tiles[number], self._corners[number]
        corner = np.array([column, self.shape[0] - row]) * self.resolution
        return tile.chart.plane - tile.corner + corner

    # For base layers: the skin at each pixel.

    @cached_property
    def places(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Patch and face (pixels,) and weights (pixels, 3) at each pixel's centre; -1 off the skin."""
        patch, face = np.full((2, *self.shape), -1, dtype=np.int64)
        weights = np.zeros((*self.shape, 3))
        for number, tile in enumerate(self.tiles):
            there = self.window(number)
            patch[there] = np.where(tile.inside, number, -1)
            face[there] = tile.face
            weights[there] = tile.bary
        return patch.ravel(), face.ravel(), weights.reshape(-1, 3)

    def centres(self) -> FloatArray:
        """Return the pixel centres (pixels, 2) in the charts of their tiles [m]; 0 off the tiles."""
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
        """(rows, columns) the same, dilated by a pixel."""
        shown = np.zeros(self.shape, bool)
        shown.reshape(-1)[self._pixels] = True
        return shown

    def _through(self, numbers: Sequence[IntArray]) -> IntArray:
        """Convert flat indices of the tiles to those of the image, one tile after the other."""
        parts = [np.zeros(0, np.int64)]
        for tile, own, (row, column) in zip(self.tiles, numbers, self._corners, strict=True):
            y, x = np.divmod(own, tile.shape[1])
            parts.append((y + row) * self.shape[1] + x + column)
        return np.concatenate(parts)


def _resolution(map_: TactileMap, known: ImageAtlas | None, pixels: int) -> float:
    """Return the side of a pixel [m]: the known one unless that gives far too many pixels."""
    if known is not None:
        area = sum(float(np.prod(np.ptp(chart.plane, axis=0))) for chart in map_.charts)
        if area <= _MAX_GROWTH * (pixels * known.resolution) ** 2:
            return known.resolution
        return float(np.sqrt(area)) / pixels
    return max(float(np.sqrt(np.prod(np.ptp(map_.bounds, axis=0)))) / pixels, 1e-9)


def _shelf_packing(shapes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Return row and column of each tile's first pixel, in rows of decreasing height, and the total size."""
    widest = max([*(width for _, width in shapes), round(1.1 * sum(h * w for h, w in shapes) ** 0.5), 1])
    corners: dict[int, tuple[int, int]] = {}
    top = column = tall = right = 0
    for number in sorted(range(len(shapes)), key=lambda k: -shapes[k][0]):
        height, width = shapes[number]
        if column + width > widest:
            top = top + tall
            column = 0
            tall = 0
        corners[number] = top, column
        column = column + width
        tall = max(tall, height)
        right = max(right, column)
    return [corners[k] for k in range(len(shapes))], (max(top + tall, 1), max(right, 1))


def _stacked_weights(weights: Sequence[csr_matrix], skin: Skin) -> csr_matrix:
    """Return one matrix for all taxels, with the pixels of the tiles stacked."""
    count = len(skin)
    blocks = [
        csr_matrix((part.data, part.indices + first, part.indptr), shape=(part.shape[0], count))
        for part, first in zip(weights, skin.first[:-1], strict=True)
    ]
    return stack_rows([csr_matrix((0, count), dtype=np.float32), *blocks]).astype(np.float32)
