"""The tactile image: pressures on the map as a regular grid, by one sparse matrix built once.

First the body area of each pixel, so that the image preserves the force; then the image; last the errors of position
and force.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.linalg import cg

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.maps.model.interpolation import interpolation_weights
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin

_PRECISION = 1e-15
_ROUNDS = 400


def body_area_of_pixels(map_: TactileMap, patch: IntArray, face: IntArray, resolution: float) -> FloatArray:
    """Return the body area (k,) of pixels of side ``resolution`` [m] with centres in faces (k,); 0 for face -1.

    It is exactly ``resolution² / (s1 s2)``: on a face the map scales areas by the ratio of the face's two areas.
    """
    areas = np.zeros(len(face))
    for number, (own, chart, uv) in enumerate(zip(map_.skin.patches, map_.charts, map_.uv, strict=True)):
        first, second = (uv[chart.faces[:, k]] - uv[chart.faces[:, 0]] for k in (1, 2))
        on_map = 0.5 * np.abs(cross(first, second))
        here = np.flatnonzero((patch == number) & (face >= 0))
        areas[here] = own.surface.face_areas[face[here]] / on_map[face[here]]
    return resolution**2 * areas


def force_areas(weights: csr_matrix, areas: FloatArray, taxel_areas: FloatArray) -> FloatArray:
    """Return pixel areas (k,) [m²] close to ``areas`` with which the image has exactly the force of the taxels.

    Pixels divide the skin into squares, taxels into cells, and interpolation distributes each reading over its
    neighbours. So the pixel areas times the image miss the force by some per cent. The image is W y, and its force is
    correct for every y if and only if Wᵀ A = a. Of all such A the one nearest to the geometric areas D is used (least
    sum of (A - D)² / D), which is A = D (W f): each pixel's area times a factor, interpolated like the pressure itself
    from one factor f per taxel, the solution of (Wᵀ D W) f = a. It is 1 where cells, squares and map agree.

    Args:
        weights: (k, n) W, in its own precision.
        areas: (k,) D [m²]; 0 for pixels off the skin, which remain 0.
        taxel_areas: (n,) a [m²].

    With at least about six pixels per taxel, 98 % of the factors are between 0.3 and 2.3, those far from 1 at the rim.
    With two or fewer they vary by tens: the total force is still correct, but not that of a part of the image. A taxel
    that no pixel shows contributes neither to the image nor to its force. With fewer pixels than taxels the areas are
    the least squares solution.
    """
    exact = weights.astype(np.float64)
    mass = (exact.T @ diags(areas) @ exact).tocsr()
    shown = mass.diagonal() > 0
    if not shown.any():
        return np.zeros(len(areas))
    mass = mass[shown][:, shown]
    targets = taxel_areas[shown]
    scale = 1 / np.sqrt(mass.diagonal())
    factors = scale * cg(diags(scale) @ mass @ diags(scale), scale * targets, rtol=_PRECISION, maxiter=_ROUNDS)[0]
    return np.asarray(areas * (exact[:, shown] @ factors))


MOST_PIXELS = 2**24


class TactileImage:
    """Image of a map; row 0 is at the top. Built once for a map and a resolution, then rendered every frame.

    Args:
        map_: The map.
        resolution: Pixel size [m]; by default the longer side of the image has ``width`` pixels.
        width: Pixels along the longer side when no resolution is given.
        interpolation: Method between taxels: ``barycentric``, ``nearest``, ``natural-neighbour`` or
            ``thin-plate``; see each for its cost and error.

    Attributes:
        map: The map.
        shape: Rows and columns.
        extent: (2, 2) lower-left and upper-right corner on the map [m].
        weights: Sparse (rows * columns, taxels) float32: the image of pressures is ``weights @ pressures``.
        inside: (rows, columns) whether a pixel's centre is on the skin.
        shown: (rows, columns) the same, dilated by a pixel.

    Raises:
        MapError: The resolution is not above zero or gives more than 2^24 pixels, or the interpolation is unknown.

    Example:
        >>> image = tm.TactileImage(tactile_map, width=128)
        >>> pressures = tm.press_skin(skin, skin.taxel_point(30), force=3.0)
        >>> print(f"{image.render(pressures).max():.0f} kPa, {image.force(image.render(pressures)):.2f} N")
        6 kPa, 3.00 N

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
        # Border pixels whose centre is just outside are shown too, which smooths the edge of a patch.
        shown = _padded(self._patch, self.shape)
        weights = interpolation_weights(map_, shown, centres, interpolation=interpolation)
        self.weights = weights.astype(np.float32)
        self.shown = readonly((shown >= 0).reshape(self.shape), bool)

    def centres(self) -> FloatArray:
        """Return map points (rows * columns, 2) of the pixels' centres [m]."""
        rows, columns = self.shape
        x = self.extent[0, 0] + (np.arange(columns) + 0.5) * self.resolution
        y = self.extent[1, 1] - (np.arange(rows) + 0.5) * self.resolution
        return np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=1)

    @property
    def places(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Patch and face (rows * columns,) and weights (rows * columns, 3) at each pixel's centre; -1 off the skin."""
        return self._patch, self._face, self._weights

    def render(self, pressures: FloatArray) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """Return the image (rows, columns) [kPa] of pressures (taxels,) [Pa]; 0 outside the skin."""
        image: np.ndarray[tuple[int, int], np.dtype[np.float32]] = (
            self.weights @ (1e-3 * np.asarray(pressures)).astype(np.float32)
        ).reshape(self.shape)
        return image

    @property
    def taxel_areas(self) -> FloatArray:
        """(taxels,) taxel areas on the body [m²]."""
        return self.map.skin.areas

    @cached_property
    def pixel_areas(self) -> FloatArray:
        """(rows, columns) pixel areas [m²] with which the image has exactly the force on the skin.

        See ``force_areas``. Cost: 20 ms at 512 pixels across, once; 100 ms with thin plates.
        """
        areas = force_areas(
            self.weights, body_area_of_pixels(self.map, self._patch, self._face, self.resolution), self.taxel_areas
        )
        return readonly(areas.reshape(self.shape))

    def force(self, image: FloatArray) -> float:
        """Return the normal force [N] shown by an image (rows, columns) [kPa], or by a part of one.

        For a rendered image it equals sum(pressure * area) over the taxels to 1e-7, the precision of its pixels; for
        one in double precision (``weights @ pressures``) to 1e-12. Set all pixels outside a region to zero for its
        force.
        """
        return 1e3 * float(np.vdot(self.pixel_areas, np.asarray(image, dtype=np.float64)))

    def pixel(self, point: FloatArray) -> tuple[int, int]:
        """Return row and column of the pixel that contains a map point (2,) [m]; it may be outside the image."""
        column, up = np.floor((np.asarray(point) - self.extent[0]) / self.resolution).astype(int)
        return self.shape[0] - 1 - int(up), int(column)

    def back_project(self, row: int, column: int) -> SurfacePoint | None:
        """Return the point on the body at a pixel's centre, by look-up; None if the pixel is not on the skin."""
        pixel = row * self.shape[1] + column
        if not (0 <= row < self.shape[0] and 0 <= column < self.shape[1]) or self._face[pixel] < 0:
            return None
        a, b, c = self._weights[pixel]
        return SurfacePoint(int(self._patch[pixel]), int(self._face[pixel]), (float(a), float(b), float(c)))


def _pixels(size: FloatArray, resolution: float) -> tuple[int, int]:
    """Return columns and rows that cover ``size`` (2,) [m]."""
    if not 0 < resolution < np.inf:
        raise MapError("the pixel size must be above zero", place="resolution", value=f"{resolution} m")
    # The small tolerance prevents an extra pixel by rounding if a side is a whole number of pixels.
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
    """Return for each patch sparse barycentric weights (surface vertices, taxels), to colour the body.

    A vertex on a seam has several map points; their mean is used, so that seams are not visible in the pressure.
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
    """Return the patch of each pixel, each patch dilated by one pixel."""
    grid = np.pad(patch.reshape(shape), 1, constant_values=-1)
    grown = grid[1:-1, 1:-1].copy()
    for row, column in ((0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (0, 2), (2, 0), (2, 2)):
        neighbour = grid[row : row + shape[0], column : column + shape[1]]
        grown = np.where(grown >= 0, grown, neighbour)
    return grown.ravel()


def round_trip_mm(map_: TactileMap, image: TactileImage) -> FloatArray:
    """Return the distance (n,) between each taxel and its round trip body -> map -> centre of the pixel -> body [mm].

    It is inf where the pixel's centre is off the taxel's patch. Cost: 2 ms for 1000 taxels.
    """
    low = image.extent[0]
    steps = np.floor((map_.taxel_points - low) / image.resolution)
    centres = low + (steps + 0.5) * image.resolution
    patch, face, weights = map_.to_body_many(centres)
    back = surface_positions(map_.skin, patch, face, weights)
    back[patch != map_.skin.patch_of] = np.inf
    return 1e3 * np.linalg.norm(back - map_.skin.positions, axis=1)


def force_error(image: TactileImage) -> FloatArray:
    """Return the relative error (n,) of the force in the image when one taxel alone is loaded; -1 if it shows none.

    Force in the image: sum over the pixels of pressure times area; true force: pressure times the taxel's area. The
    largest error bounds that of any touch. Cost: 3 ms, plus the pixel areas.
    """
    shown = image.weights.T.astype(np.float64) @ image.pixel_areas.ravel()
    return np.asarray(shown) / image.taxel_areas - 1


def surface_positions(skin: Skin, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
    """Return positions (k, 3) [m], link frames, of patch (k,), face (k,) and weights (k, 3); NaN for patch -1."""
    result = np.full((len(patch), 3), np.nan)
    for number, own in enumerate(skin.patches):
        here = patch == number
        result[here] = own.surface.points(face[here], weights[here])
    return result
