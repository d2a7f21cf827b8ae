"""The tactile image: pressures on the map as a regular grid, by one sparse matrix built once."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from app.arrays import FloatArray, IntArray, readonly
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.image_force import behind, force_areas
from app.maps.interpolation.weights import interpolation_weights
from app.maps.tactile_map import TactileMap

MOST_PIXELS = 2**24


class TactileImage:
    """Pixels of a map; row 0 is at the top. Built once for a map and a resolution, then asked every frame.

    Args:
        map_: The map.
        resolution: Pixel size [m]; by default such that the image's longer side has ``width`` pixels.
        width: Pixels along the longer side when no resolution is given.
        interpolation: How to show what lies between taxels: ``barycentric``, ``nearest``, ``natural-neighbour`` or
            ``thin-plate``; see each for its cost and error.

    Attributes:
        map: What it shows.
        shape: Rows and columns.
        extent: (2, 2) lower-left and upper-right corner on the map [m].
        weights: Sparse (rows * columns, taxels) float32: the image of pressures is ``weights @ pressures``.
        inside: (rows, columns) whether a pixel's centre is on the skin.
        shown: (rows, columns) the same grown by a pixel.

    Raises:
        MapError: A resolution that is not above zero, or so fine that the image would have more than 2^24 pixels; an
            interpolation that does not exist.

    Cost: 0.1 s to build at 512 pixels across and 0.2 ms to render, with barycentric interpolation.
    """

    def __init__(
        self,
        map_: TactileMap,
        *,
        resolution: float | None = None,
        width: int = 512,
        interpolation: str = "barycentric",
    ) -> None:
        low, high = map_.bounds
        self.resolution = max(float((high - low).max()) / width, 1e-9) if resolution is None else resolution
        columns, rows = _pixels(high - low, self.resolution)
        self.shape = (rows, columns)
        size = self.resolution * np.array([columns, rows])
        corner = 0.5 * (low + high - size)
        self.extent = readonly(np.stack([corner, corner + size]))
        self.interpolation = interpolation
        centres = self.centres()
        self.map = map_
        self._patch, self._face, self._weights = map_.to_body_many(centres)
        self.inside = readonly((self._face >= 0).reshape(self.shape), bool)
        # Border pixels whose centre is just outside are shown too, so that a patch's edge is not ragged.
        shown = _padded(self._patch, self.shape)
        weights = interpolation_weights(map_, shown, centres, interpolation=interpolation)
        self.weights = weights.astype(np.float32)
        self.shown = readonly((shown >= 0).reshape(self.shape), bool)

    def centres(self) -> FloatArray:
        """(rows * columns, 2) map points of the pixels' centres [m]."""
        rows, columns = self.shape
        x = self.extent[0, 0] + (np.arange(columns) + 0.5) * self.resolution
        y = self.extent[1, 1] - (np.arange(rows) + 0.5) * self.resolution
        return np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=1)

    @property
    def places(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Patch and face (rows * columns,) and weights (rows * columns, 3) behind each pixel's centre; -1 off skin."""
        return self._patch, self._face, self._weights

    def render(self, pressures: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """(rows, columns) [kPa] from pressures (taxels,) [Pa]; 0 outside the skin."""
        image: np.ndarray[tuple[int, int], np.dtype[np.float32]] = (
            self.weights @ (1e-3 * np.asarray(pressures)).astype(np.float32)
        ).reshape(self.shape)
        return image

    @property
    def taxel_areas(self) -> FloatArray:
        """(taxels,) on the body [m²]."""
        return self.map.skin.areas

    @cached_property
    def pixel_areas(self) -> FloatArray:
        """(rows, columns) on the body [m²], such that the image shows exactly the force that the skin feels.

        See ``force_areas``. Cost: 20 ms at 512 pixels across, once; 100 ms with thin plates.
        """
        areas = force_areas(self.weights, behind(self.map, self._patch, self._face, self.resolution), self.taxel_areas)
        return readonly(areas.reshape(self.shape))

    def force(self, image: FloatArray) -> float:
        """The force [N] normal to the skin that an image (rows, columns) [kPa] shows, or a part of one.

        Of a rendered image that is sum(pressure * area) over the taxels to 1e-7, the precision of its pixels; of one
        in double precision (``weights @ pressures``) to 1e-12. Blank all pixels but a region's to get that region's.
        """
        return 1e3 * float(np.vdot(self.pixel_areas, np.asarray(image, dtype=np.float64)))

    def pixel(self, point: FloatArray) -> tuple[int, int]:
        """Row and column of the pixel that holds a map point (2,) [m]; it may lie outside the image."""
        column, up = np.floor((np.asarray(point) - self.extent[0]) / self.resolution).astype(int)
        return self.shape[0] - 1 - int(up), int(column)

    def back_project(self, row: int, column: int) -> SurfacePoint | None:
        """The place on the body behind a pixel's centre, from a table; None where the pixel is not on the skin."""
        pixel = row * self.shape[1] + column
        if not (0 <= row < self.shape[0] and 0 <= column < self.shape[1]) or self._face[pixel] < 0:
            return None
        a, b, c = self._weights[pixel]
        return SurfacePoint(int(self._patch[pixel]), int(self._face[pixel]), (float(a), float(b), float(c)))


def _pixels(size: FloatArray, resolution: float) -> tuple[int, int]:
    """Columns and rows that hold ``size`` (2,) [m]."""
    if not 0 < resolution < np.inf:
        raise MapError("a pixel must have a size above zero", place="resolution", value=f"{resolution} m")
    # The hint less keeps a side that is a whole number of pixels from getting one more by rounding.
    counts = np.maximum(np.ceil(size / resolution - 1e-9), 1)
    if not counts.prod() <= MOST_PIXELS:
        raise MapError(
            "the image would have too many pixels",
            place="resolution",
            value=f"{resolution} m",
            remedy=f"Choose {np.sqrt(size.prod() / MOST_PIXELS):.1g} m or more",
        )
    return int(counts[0]), int(counts[1])


def vertex_weights(map_: TactileMap, *, interpolation: str = "barycentric") -> list[csr_matrix]:
    """For each patch sparse (surface vertices, taxels): the image's interpolation, for colouring the body.

    A vertex on a seam has several places on the map; it takes the mean of them, so that no seam shows in touch.
    """
    result = []
    for number, (patch, chart, uv) in enumerate(zip(map_.skin.patches, map_.charts, map_.uv, strict=True)):
        copies = interpolation_weights(map_, np.full(len(uv), number), uv, interpolation=interpolation)
        count = len(patch.surface.vertices)
        gather = coo_matrix((np.ones(len(uv)), (chart.vertex_of, np.arange(len(uv)))), shape=(count, len(uv))).tocsr()
        share = 1.0 / np.maximum(np.asarray(gather.sum(axis=1)).ravel(), 1)
        result.append((diags(share) @ gather @ copies).tocsr())
    return result


def _padded(patch: IntArray, shape: tuple[int, int]) -> IntArray:
    """Patch of each pixel, each patch grown by one pixel all around."""
    grid = np.pad(patch.reshape(shape), 1, constant_values=-1)
    grown = grid[1:-1, 1:-1].copy()
    for row, column in ((0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (0, 2), (2, 0), (2, 2)):
        beside = grid[row : row + shape[0], column : column + shape[1]]
        grown = np.where(grown >= 0, grown, beside)
    return grown.ravel()
