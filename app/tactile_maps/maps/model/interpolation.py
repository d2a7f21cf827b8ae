"""Interpolation of pressure between taxels: four methods, each a sparse matrix from the taxels of a patch to points.

``TaxelTriangles`` is shared by all: the triangulated taxels of a patch, without triangles that would bridge a gap, and
the extrapolation beyond their border. The methods have one signature: ``barycentric`` (linear between the three taxels
around a point; the default), ``nearest``, ``natural_neighbour`` (a taxel is weighted by the area that the point would
take from its Voronoi cell) and ``thin_plate`` (around each taxel the smoothest surface through its neighbours, blended
between taxels). ``interpolation_weights`` applies one of them to a whole map, patch by patch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags, eye
from scipy.spatial import Delaunay, QhullError, cKDTree
from scipy.special import xlogy

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.geometry.surface.point_location import PointLocator
from tactile_maps.maps.model.tactile_map import TactileMap

LONGEST_SIDE = 2.5
"""Longest side of a triangle, in median spacings; longer triangles bridge a gap and are dropped."""
_THINNEST_TRIANGLE = 1e-4
"""Height over longest side below which a triangle counts as a line; points in it are extrapolated from its
neighbours."""
_NEAR_SIDES = 6
_CHUNK = 32768


class TaxelTriangles:
    """Delaunay triangles of a patch's taxels, without those that bridge a gap. Built once, queried often.

    Args:
        sites: (n, 2) map points of the taxels, at least one [m].

    Attributes:
        sites: (n, 2) map points of the taxels [m].
        faces: (t, 3) taxels, counter-clockwise; none if all are collinear.
        beyond: (t, 3) the triangle across the side opposite each corner, or -1 at the border.

    Cost: 5 ms for 1000 taxels.
    """

    def __init__(self, sites: FloatArray) -> None:
        self.sites = readonly(sites)
        faces, beyond = _triangulated(self.sites)
        self.faces = readonly(faces, np.int64)
        self.beyond = readonly(beyond, np.int64)
        self._locator = PointLocator(self.sites[self.faces])
        alone = np.setdiff1d(np.arange(len(sites)), self.faces)
        border = Connectivity(self.faces).boundary_edges
        self._sides = np.concatenate([border, np.stack([alone, alone], axis=1)]).astype(np.int64)
        self._middles = cKDTree(self.sites[self._sides].mean(axis=1))

    def locate(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the triangle (k,) that contains each of ``points`` (k, 2), or -1, and the weights (k, 3) in it."""
        return self._locator.query(points)

    def beyond_border(self, points: FloatArray) -> csr_matrix:
        """Return sparse weights (k, n) of the closest border point, between the two taxels of its side.

        Used outside the triangles (the rim of a patch, a gap too wide to bridge), where taxels are on one side only.
        """
        near = min(_NEAR_SIDES, len(self._sides))
        sides = self._middles.query(points, near)[1].reshape(len(points), near)
        start, end = (self.sites[self._sides[sides, k]] for k in range(2))
        along = end - start
        square = (along**2).sum(axis=-1)
        share = ((points[:, None] - start) * along).sum(axis=-1) / np.where(square > 0, square, 1.0)
        share = np.clip(share, 0.0, 1.0)
        distance = np.linalg.norm(start + share[..., None] * along - points[:, None], axis=-1)
        pick = np.arange(len(points)), distance.argmin(axis=1) if len(points) else np.zeros(0, dtype=np.int64)
        return sparse_rows(self._sides[sides[pick]], np.stack([1 - share[pick], share[pick]], axis=1), len(self.sites))


def sparse_rows(taxels: IntArray, weights: FloatArray, count: int) -> csr_matrix:
    """Return a sparse matrix (k, count) from ``taxels`` (k, c) and their ``weights`` (k, c)."""
    starts = np.arange(len(taxels) + 1) * taxels.shape[1]
    matrix = csr_matrix((weights.ravel(), taxels.ravel(), starts), shape=(len(taxels), count))
    matrix.sum_duplicates()
    return matrix


def merge_rows(held: IntArray, inner: csr_matrix, outer: csr_matrix) -> csr_matrix:
    """Return rows of ``inner`` where ``held`` (k,) is not negative and of ``outer`` elsewhere, each in order."""
    inside = held >= 0
    order = np.where(inside, np.cumsum(inside) - 1, inner.shape[0] + np.cumsum(~inside) - 1)
    return stack_rows([inner, outer])[order]


def in_chunks(held: BoolArray) -> list[IntArray]:
    """Return the indices of ``held`` points (k,) in chunks, to limit the memory of intermediate results."""
    numbers = np.flatnonzero(held)
    return [numbers[start : start + _CHUNK] for start in range(0, max(len(numbers), 1), _CHUNK)]


def stack_rows(blocks: list[csr_matrix]) -> csr_matrix:
    """Stack blocks with equal numbers of columns vertically."""
    counts = np.concatenate([np.diff(block.indptr) for block in blocks])
    data, columns = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("data", "indices"))
    shape = len(counts), blocks[0].shape[1]
    return csr_matrix((data, columns, np.concatenate([[0], np.cumsum(counts)])), shape=shape)


def _triangulated(sites: FloatArray) -> tuple[IntArray, IntArray]:
    """Return triangles (t, 3) and their neighbours (t, 3)."""
    none = np.zeros((0, 3), dtype=np.int64)
    if len(sites) < 3:
        return none, none
    try:
        found = Delaunay(sites)
    except QhullError:
        return none, none
    corners = sites[found.simplices]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    across = cross(first, second)
    kept = longest <= LONGEST_SIDE * np.median(cKDTree(sites).query(sites, 2)[0][:, 1])
    kept &= across > _THINNEST_TRIANGLE * longest**2
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    beyond = np.where(found.neighbors >= 0, number[found.neighbors], -1)
    return found.simplices[kept].astype(np.int64), beyond[kept]


def barycentric(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Return sparse weights (k, n): three per point, >= 0; continuous, and exact for a linear field.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.0043 on smooth waves, 0.020 under a ball, steep at its rim.

    Cost: 45 ms to build 256 x 256 pixels from 1000 taxels, then 0.09 ms a frame.
    """
    face, weights = triangles.locate(points)
    held = face >= 0
    inner = sparse_rows(triangles.faces[face[held]], weights[held], len(triangles.sites))
    return merge_rows(face, inner, triangles.beyond_border(points[~held]))


def nearest(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Return sparse weights (k, n): one per point; shows only measured values, in cells with sharp borders.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.031 on smooth waves, 0.037 under a ball, steep at its rim.

    Cost: 35 ms to build 256 x 256 pixels from 1000 taxels, then 0.05 ms a frame.
    """
    taxels = cKDTree(triangles.sites).query(points)[1].reshape(-1, 1)
    return sparse_rows(taxels.astype(np.int64), np.ones(taxels.shape), len(triangles.sites))


_FLAT = 1e-7
"""Distance from a taxel or the border, as a share of the triangle, below which interpolation is linear."""
_LINE = 1e-14
_ROUNDING = 1e-6


def natural_neighbour(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Return sparse weights (k, n): about five per point, >= 0; smooth except at taxels, exact for a linear field.

    Sibson's weights (1981), computed exactly, not by counting pixels. Laplace's weights (the length of the common
    border instead of the area) were tried: equal cost, 10 % larger error, and creases along every circumcircle. Of the
    four methods this one passes the least noise of the taxels: 0.65 of it, barycentric 0.71.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.0041 on smooth waves, 0.020 under a ball, steep at its rim.

    Cost: 180 ms to build 256 x 256 pixels from 1000 taxels, then 0.3 ms a frame.
    """
    face, linear = triangles.locate(points)
    held = face >= 0
    inner = [_sibson(triangles, points[part], face[part], linear[part]) for part in in_chunks(held)]
    return merge_rows(face, stack_rows(inner), triangles.beyond_border(points[~held]))


def _sibson(triangles: TaxelTriangles, points: FloatArray, face: IntArray, linear: FloatArray) -> csr_matrix:
    """Return areas taken from Voronoi cells, for all points at once, by the shoelace formula about each point.

    The part that a point takes from a cell is bounded by old Voronoi vertices (circumcentres of the triangles that
    inserting the point would dissolve, its star) and new ones (circumcentres of the point and a side of the star).
    Every edge of a part belongs to one side of those triangles, so each side contributes to its two ends and no polygon
    has to be sorted.
    """
    centres = _circumcentres(*np.swapaxes(triangles.sites[triangles.faces], 0, 1))
    shape = len(points), len(triangles.sites)
    taken = csr_matrix(shape)
    flat = linear.max(axis=1, initial=0.0) > 1 - _FLAT
    for owner, here, after, start, end in _sides(triangles, centres, points, face, np.flatnonzero(~flat)):
        origin = points[owner]
        rim = after < 0
        a = triangles.sites[start] - origin
        b = triangles.sites[end] - origin
        flat[owner[rim & (cross(a, b) <= _FLAT * ((a - b) ** 2).sum(axis=1))]] = True
        vertex = np.where(rim[:, None], _circumcentres(np.zeros_like(a), a, b), centres[after] - origin)
        between = cross(centres[here] - origin, vertex)
        # The new edge between a point and its neighbour is on their bisector, with one end on each side of it.
        areas = 0.5 * rim * cross(a, vertex) - between, between - 0.5 * rim * cross(b, vertex)
        places = np.concatenate([owner, owner]), np.concatenate([start, end])
        taken = taken + coo_matrix((np.concatenate(areas), places), shape=shape).tocsr()
    total = np.asarray(taken.sum(axis=1)).ravel()
    row = np.repeat(np.arange(len(points)), np.diff(taken.indptr))
    # Rounding may select wrong triangles among needles, which shows as negative areas.
    flat[row[taken.data < -_ROUNDING * np.abs(total[row])]] = True
    # Towards the border areas grow without bound, and the weights approach those of the triangle.
    scale = np.divide(1.0, total, out=np.zeros(len(points)), where=~flat)
    return (diags(scale) @ taken + sparse_rows(triangles.faces[face], linear * flat[:, None], shape[1])).tocsr()


Sides = tuple[IntArray, IntArray, IntArray, IntArray, IntArray]


def _sides(
    triangles: TaxelTriangles, centres: FloatArray, points: FloatArray, face: IntArray, asked: IntArray
) -> Iterator[Sides]:
    """Yield the sides of each point's star, triangle by triangle outwards from the one that contains it.

    Yields:
        Point, triangle, the triangle beyond if that is in the star as well (the side then comes once, from within) or
        -1, and the two ends of the side, counter-clockwise around the triangle.
    """
    corner = triangles.sites[triangles.faces[:, 0]]
    centre = centres - corner
    owner = asked
    here = face[asked]
    came = np.full(len(asked), -1, dtype=np.int64)
    while len(owner):
        beyond = triangles.beyond[here]
        row, side = np.nonzero((beyond < 0) | (beyond != came[:, None]))
        ends = triangles.faces[here[row]]
        start, end = (ends[np.arange(len(row)), (side + turn) % 3] for turn in (1, 2))
        owner = owner[row]
        here = here[row]
        after = beyond[row, side]
        arm = points[owner] - corner[after]
        inside = (after >= 0) & ((arm * (arm - 2 * centre[after])).sum(axis=1) < 0)
        inside &= _ahead(points[owner], triangles.sites[start], triangles.sites[end])
        yield owner, here, np.where(inside, after, -1), start, end
        owner, here, came = owner[inside], after[inside], here[inside]


def _ahead(points: FloatArray, start: FloatArray, end: FloatArray) -> BoolArray:
    """Return whether crossing a side leads away from the point, so that no walk circles a taxel."""
    return cross(start - points, end - points) > -_FLAT * ((start - end) ** 2).sum(axis=1)


def _circumcentres(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the circumcentres (t, 2) of triangles, or the first corner of a triangle that is a line by rounding."""
    b = b - a
    c = c - a
    doubled = 2 * cross(b, c)
    bb = (b**2).sum(axis=1)
    cc = (c**2).sum(axis=1)
    away = np.stack([c[:, 1] * bb - b[:, 1] * cc, b[:, 0] * cc - c[:, 0] * bb], axis=1)
    return a + away / np.where(np.abs(doubled) <= _LINE * (bb + cc), np.inf, doubled)[:, None]


STENCIL = 16
"""Number of taxels in each plate."""
_THINNEST_PLATE = 1e-3
"""Width or spacing of a plate's taxels, as a share of its size, below which the plate is not solved."""
_PLATES_AT_ONCE = 4096


def thin_plate(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Return sparse weights (k, n): about 25 per point, some negative; the most accurate method for smooth fields.

    A thin plate spline (Duchon 1977) through each taxel's 16 nearest along the triangles is one small linear system,
    solved once; the plates of a triangle's three corners are blended by barycentric weights. The field is therefore
    continuous, interpolates every reading, is exact for a linear field, and remains a sparse matrix.
    It overshoots next to a steep edge and passes 0.83 of the taxels' noise, barycentric 0.71.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.0005 on smooth waves, 0.017 under a ball, steep at its rim.

    Cost: 240 ms to build 256 x 256 pixels from 1000 taxels, then 0.8 ms a frame.
    """
    face, linear = triangles.locate(points)
    held = face >= 0
    plates = _Plates(triangles)
    inner = [_blended(plates, points[part], triangles.faces[face[part]], linear[part]) for part in in_chunks(held)]
    return merge_rows(face, stack_rows(inner), triangles.beyond_border(points[~held]))


def _blended(plates: _Plates, points: FloatArray, corners: IntArray, linear: FloatArray) -> csr_matrix:
    shape = len(points), len(plates.sound)
    flat: BoolArray = ~np.all(plates.sound[corners], axis=1)
    row, corner = np.nonzero((linear > 0) & ~flat[:, None])
    taxel = corners[row, corner]
    share = linear[row, corner]
    order = np.argsort(taxel, kind="stable")
    row = row[order]
    taxel = taxel[order]
    share = share[order]
    weights = np.zeros((len(row), STENCIL))
    starts = np.searchsorted(taxel, np.arange(shape[1] + 1))
    for plate in np.flatnonzero(np.diff(starts)).tolist():
        asked = slice(starts[plate], starts[plate + 1])
        weights[asked] = plates.weights(plate, points[row[asked]])
    weights *= share[:, None]
    places = np.repeat(row, STENCIL), plates.stencils[taxel].ravel()
    curved = coo_matrix((weights.ravel(), places), shape=shape).tocsr()
    return (curved + sparse_rows(corners, linear * flat[:, None], shape[1])).tocsr()


class _Plates:
    """Thin plates around all taxels, each in coordinates relative to its taxel, in units of its radius.

    Args:
        triangles: Triangles of the taxels.

    Attributes:
        stencils: (n, STENCIL) taxels of each plate.
        sound: (n,) whether the plate was solved.
    """

    def __init__(self, triangles: TaxelTriangles) -> None:
        sites = triangles.sites
        self.stencils = _stencils(triangles)
        self._middle = sites
        away = sites[self.stencils] - sites[:, None]
        reach = np.linalg.norm(away, axis=2).max(axis=1)
        self._reach = np.where(reach > 0, reach, 1.0)
        self._places = away / self._reach[:, None, None]
        self._solutions = np.zeros((len(sites), STENCIL + 3, STENCIL))
        self.sound = np.zeros(len(sites), dtype=bool)
        used = self.stencils != self.stencils[:, :1]
        used[:, 0] = True
        for start in range(0, len(sites), _PLATES_AT_ONCE):
            chunk = slice(start, start + _PLATES_AT_ONCE)
            self._solutions[chunk], self.sound[chunk] = _solved(self._places[chunk], used[chunk])

    def weights(self, plate: int, points: FloatArray) -> FloatArray:
        """Return weights (k, STENCIL) of the plate's taxels at ``points`` (k, 2)."""
        asked = (points - self._middle[plate]) / self._reach[plate]
        bending = _kernel(asked[:, None] - self._places[plate])
        solution = self._solutions[plate]
        return np.asarray(bending @ solution[:STENCIL] + asked @ solution[-2:] + solution[STENCIL])


def _stencils(triangles: TaxelTriangles) -> IntArray:
    """Return each taxel's nearest (n, STENCIL) within three rings of triangles, itself first and as padding.

    Neighbours are found along triangles, so that no plate bridges a gap.
    """
    count = len(triangles.sites)
    pairs = triangles.faces[:, [0, 1, 1, 2, 2, 0, 1, 0, 2, 1, 0, 2]].reshape(-1, 2)
    step = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count)).tocsr()
    step = csr_matrix((step + eye(count)).sign())
    reached = (step @ step @ step).tocoo()
    away = np.linalg.norm(triangles.sites[reached.row] - triangles.sites[reached.col], axis=1)
    order = np.lexsort((reached.col, away, reached.row))
    row = reached.row[order]
    column = reached.col[order]
    rank = np.arange(len(row)) - np.searchsorted(row, row)
    stencils = np.repeat(np.arange(count)[:, None], STENCIL, axis=1)
    near = rank < STENCIL
    stencils[row[near], rank[near]] = column[near]
    return stencils


def _solved(places: FloatArray, used: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return matrices (n, STENCIL + 3, STENCIL) from (bending, 1, position) to weights, and solved plates (n,).

    Padded entries are separate unknowns, so that all systems have the same size.
    """
    both = used[:, :, None] & used[:, None]
    own = np.eye(STENCIL, dtype=bool)
    apart = places[:, :, None] - places[:, None]
    closest = np.where(both & ~own, np.linalg.norm(apart, axis=3), np.inf).min(axis=(1, 2))
    sound = np.minimum(closest, _width(places)) > _THINNEST_PLATE
    plane = np.concatenate([np.ones((*used.shape, 1)), places], axis=2) * used[:, :, None]
    kernel = np.where(both, _kernel(apart), own)
    corner = np.zeros((len(places), 3, 3))
    system = np.block([[kernel, plane], [plane.swapaxes(1, 2), corner]])
    solutions = np.zeros((len(places), STENCIL + 3, STENCIL))
    solutions[sound] = np.linalg.inv(system[sound])[:, :, :STENCIL] * used[sound][:, None]
    return solutions, sound


def _width(places: FloatArray) -> FloatArray:
    """Return the smaller singular value (n,) of ``places`` (n, c, 2): their deviation from a line."""
    (xx, xy), (_, yy) = np.moveaxis(places.swapaxes(1, 2) @ places, 0, -1)
    return np.asarray(np.sqrt(np.maximum(0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy), 0.0)))


def _kernel(apart: FloatArray) -> FloatArray:
    """Return r² log r for ``apart`` (..., 2), the deflection of a thin plate under a point load."""
    square = (apart**2).sum(axis=-1)
    return np.asarray(0.5 * xlogy(square, square))


Interpolation = Callable[[TaxelTriangles, FloatArray], csr_matrix]

INTERPOLATIONS: Mapping[str, Interpolation] = {
    "barycentric": barycentric,
    "nearest": nearest,
    "natural-neighbour": natural_neighbour,
    "thin-plate": thin_plate,
}


def interpolation_weights(
    map_: TactileMap, patch: IntArray, points: FloatArray, *, interpolation: str = "barycentric"
) -> csr_matrix:
    """Return sparse weights (k, taxels): each row sums to one for a point on a patch, and is empty for patch -1.

    Interpolates between the taxels of the point's patch by the given method. Outside their triangles (the rim of the
    patch, and gaps too wide to bridge) the value of the closest border point is used: continuous, never from another
    patch and within the range of the taxels there.

    Args:
        map_: The map.
        patch: (k,) patch of each point, -1 for none.
        points: (k, 2) [m].
        interpolation: A name in ``INTERPOLATIONS``.

    Raises:
        MapError: Unknown interpolation.

    Cost: see each method; applying the matrix costs half a nanosecond per entry.
    """
    if interpolation not in INTERPOLATIONS:
        choice = f"Choose {', '.join(INTERPOLATIONS)}"
        raise MapError("unknown interpolation", place="interpolation", value=interpolation, remedy=choice)
    # The last, empty row is for points on no patch.
    blocks = []
    row_of = np.full(len(points), -1, dtype=np.int64)
    rows = 0
    for number, (first, last) in enumerate(zip(map_.skin.first[:-1], map_.skin.first[1:], strict=True)):
        asked = np.flatnonzero(patch == number)
        if len(asked) and last > first:
            found = INTERPOLATIONS[interpolation](TaxelTriangles(map_.taxel_points[first:last]), points[asked])
            entries = found.data, found.indices + first, found.indptr
            blocks.append(csr_matrix(entries, shape=(len(asked), len(map_.skin))))
            row_of[asked] = rows + np.arange(len(asked))
            rows += len(asked)
    matrix = stack_rows([*blocks, csr_matrix((1, len(map_.skin)))])[row_of]
    matrix.eliminate_zeros()
    return matrix
