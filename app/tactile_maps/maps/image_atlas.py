"""The image of a map that is shown live: a tile for each patch, all tiles in one atlas.

A tile is in its chart's own frame, so moving, turning, mirroring or scaling a patch changes nothing here; another chart
rebuilds its own tile only.
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
"""How far the rim's colours are carried outwards, so that a smoothly drawn patch border never blends with nothing."""
PAD = 4
"""Free pixels around the patch: room for the halo, and for contours to close in."""


@dataclass(frozen=True, eq=False)
class AtlasTile:
    """The pixels of one patch; row 0 is at the top. Flat numbers are row * width + column.

    Attributes:
        chart: What it shows.
        resolution: Side of a pixel [m].
        corner: (2,) the chart's point at the upper left corner of the first pixel [m].
        inside: (h, w) pixels whose centre is on the chart.
        pixels: (k,) flat numbers of the pixels that show touch: those inside, and their neighbours.
        weights: Sparse (k, taxels of the patch): what each of them shows of each taxel.
        halo: (j,) flat numbers of pixels just outside.
        source: (j,) flat number of the pixel that each of them copies.
        face: (h, w) the chart's face behind each pixel; -1 outside.
        bary: (h, w, 3) weights of its corners.
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
        """Build it. Cost: 60 ms for 10,000 faces, 500 taxels and 300² pixels.

        Raises:
            MapError: As ``TactileImage``.
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
        """Chart points (..., 2) [m] of places (..., 2) as column and row, the first pixel's centre being (0, 0)."""
        return self.corner + (places + 0.5) * self.resolution * [1.0, -1.0]


def halo_of(inside: BoolArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Flat numbers of the pixels just outside, and of the inside pixel nearest to each."""
    if inside.all() or not inside.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    distance, nearest = distance_transform_edt(~inside, return_indices=True)
    halo = np.flatnonzero((distance > 0) & (distance <= HALO_PX))
    rows = nearest[0].ravel()[halo]
    columns = nearest[1].ravel()[halo]
    return halo, np.ravel_multi_index((rows, columns), inside.shape)


_SPARE = 8
_FEW = 0.25
"""Up to this share of all weights, writing only the pixels that change is the faster way."""
_MAX_GROWTH = 4.0
"""As many times the pixels of the map as it was first packed, and they become larger."""


@dataclass(frozen=True)
class ImageSettings:
    """How the live image is made.

    Attributes:
        interpolation: What lies between taxels; a name in ``INTERPOLATIONS``.
        pixels: Side of a square with as many pixels as the image has for a map as it was first packed.
    """

    interpolation: str = "barycentric"
    pixels: int = 512


class ImageAtlas:
    """All tiles in one image, row 0 at the top. Built for charts, whatever their layout; asked every frame.

    Args:
        map_: Its charts are shown; its bounds give the size of a pixel.
        known: An atlas of the same skin: tiles of charts that are the same are taken from there, and the pixel's size.
        look: How it is made; a known one of another look is no help.

    Attributes:
        skin: Whose map it shows.
        look: As above.
        tiles: One for each patch.
        spare: A few of the atlases before, for a person who undoes.
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
        """What the tiles show."""
        return tuple(tile.chart for tile in self.tiles)

    @property
    def halo(self) -> tuple[IntArray, IntArray]:
        """Flat numbers of the pixels around the patches, and of those that they copy."""
        return self._through([tile.halo for tile in self.tiles]), self._through([tile.source for tile in self.tiles])

    def render(
        self, pressures: FloatArray, out: NDArray[np.float32], *, changed: IntArray | None = None
    ) -> IntArray | None:
        """Write the pressures (taxels,) [Pa] into ``out`` (rows, columns) [kPa]; the flat numbers of what was written.

        Args:
            pressures: Of all taxels.
            out: Where to.
            changed: (k,) taxels whose pressure may not be the one that ``out`` shows; None for all of them, and where
                so many show in much of the image, all is written, and None returned.

        Cost: 0.3 ms; 0.05 ms for a touch of a few taxels.
        """
        kilopascals = (1e-3 * np.asarray(pressures)).astype(np.float32)
        if changed is not None:
            ends = self._taxel_rows.indptr
            if int((ends[changed + 1] - ends[changed]).sum()) < _FEW * self._taxel_rows.nnz:
                rows = np.unique(self._taxel_rows[:, changed].indices)
                written = self._pixels[rows]
                out.reshape(-1)[written] = self._weights[rows] @ kilopascals
                return written
        out.reshape(-1)[self._pixels] = self._weights @ kilopascals
        return None

    @cached_property
    def _taxel_rows(self) -> csc_matrix:
        """Which rows of the weights each taxel has a part in."""
        return self._weights.tocsc()

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
            face[there] = tile.face
            weights[there] = tile.bary
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


def _resolution(map_: TactileMap, known: ImageAtlas | None, pixels: int) -> float:
    """Side of a pixel [m]; the known one while that does not make far too many."""
    if known is not None:
        area = sum(float(np.prod(np.ptp(chart.plane, axis=0))) for chart in map_.charts)
        if area <= _MAX_GROWTH * (pixels * known.resolution) ** 2:
            return known.resolution
        return float(np.sqrt(area)) / pixels
    return max(float(np.sqrt(np.prod(np.ptp(map_.bounds, axis=0)))) / pixels, 1e-9)


def _shelf_packing(shapes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Row and column of each tile's first pixel, in rows of falling height, and the size of it all."""
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
    """One matrix for all taxels, the tiles' pixels one below the other."""
    count = len(skin)
    blocks = [
        csr_matrix((part.data, part.indices + first, part.indptr), shape=(part.shape[0], count))
        for part, first in zip(weights, skin.first[:-1], strict=True)
    ]
    return stack_rows([csr_matrix((0, count), dtype=np.float32), *blocks]).astype(np.float32)
