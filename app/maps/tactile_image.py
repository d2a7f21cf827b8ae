"""The tactile image: pressures on the map as a regular grid, by one sparse matrix built once."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from app.arrays import FloatArray, IntArray, readonly
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.interpolation import interpolation_weights
from app.maps.tactile_map import TactileMap

MOST_PIXELS = 2**24


class TactileImage:
    """Pixels of a map; row 0 is at the top. Built once for a map and a resolution, then asked every frame.

    Args:
        map_: The map.
        resolution: Pixel size [m]; by default such that the image's longer side has ``width`` pixels.
        width: Pixels along the longer side when no resolution is given.

    Raises:
        MapError: A resolution that is not above zero, or so fine that the image would have more than 2^24 pixels.

    Cost: 0.2 s to build at 512 pixels across; 0.3 ms to render.
    """

    def __init__(self, map_: TactileMap, *, resolution: float | None = None, width: int = 512) -> None:
        low, high = map_.bounds
        self.resolution = max(float((high - low).max()) / width, 1e-9) if resolution is None else resolution
        columns, rows = _pixels(high - low, self.resolution)
        self.shape = (rows, columns)
        size = self.resolution * np.array([columns, rows])
        corner = 0.5 * (low + high - size)
        self.extent = readonly(np.stack([corner, corner + size]))
        self._patch, self._face, self._weights = map_.to_body_many(self.centres())
        self.inside = readonly((self._face >= 0).reshape(self.shape), bool)
        # Border pixels whose centre is just outside are shown too, so that a patch's edge is not ragged.
        shown = _padded(self._patch, self.shape)
        self.weights = interpolation_weights(map_, shown, self.centres()).astype(np.float32)
        self.shown = readonly((shown >= 0).reshape(self.shape), bool)

    def centres(self) -> FloatArray:
        """(rows * columns, 2) map points of the pixels' centres [m]."""
        rows, columns = self.shape
        x = self.extent[0, 0] + (np.arange(columns) + 0.5) * self.resolution
        y = self.extent[1, 1] - (np.arange(rows) + 0.5) * self.resolution
        return np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=1)

    def render(self, pressures: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """(rows, columns) [kPa] from pressures (taxels,) [Pa]; 0 outside the skin."""
        image: np.ndarray[tuple[int, int], np.dtype[np.float32]] = (
            self.weights @ (1e-3 * np.asarray(pressures)).astype(np.float32)
        ).reshape(self.shape)
        return image

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


def vertex_weights(map_: TactileMap) -> list[csr_matrix]:
    """For each patch sparse (surface vertices, taxels): the image's interpolation, for colouring the body.

    A vertex on a seam has several places on the map; it takes the mean of them, so that no seam shows in touch.
    """
    result = []
    for number, (patch, chart, uv) in enumerate(zip(map_.skin.patches, map_.charts, map_.uv, strict=True)):
        copies = interpolation_weights(map_, np.full(len(uv), number), uv)
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
