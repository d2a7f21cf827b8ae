"""Distortion energies: the symmetric Dirichlet energy, mixed with an energy of angles alone.

Per face, with singular values s1 >= s2 of the map's differential, per unit of area:
    lengths: s1² + s2² + 1/s1² + 1/s2² (Smith and Schaefer 2015),
    angles:  2 (s1/s2 + s2/s1) (twice MIPS, Hormann and Greiner 2000).
Both are 4 without distortion and infinite before a triangle can flip. Hessian: the analytic eigensystem of isotropic
energies (Smith, de Goes and Kim 2019) with negative modes set to zero, so that every step goes downhill.

The rest shapes come first: each face in its own plane, faces without area adjusted. Then the pattern of the Hessian:
the positions of the 2 x 2 blocks of a mesh's faces in a sparse matrix, which are the same at every step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from tactile_maps.core.arrays import FloatArray, IntArray, dot
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.point_location import owner_and_rank

MOLLIFICATION = 1e-5
"""Share of the mean edge length by which two sides of a face must exceed the third."""


@dataclass(frozen=True, eq=False)
class RestTriangles:
    """Faces in their own planes: corner 0 at the origin, corner 1 at (base, 0), corner 2 at (along, across).

    Attributes:
        base: (m,) > 0.
        along: (m,).
        across: (m,) > 0.
        mollified: Number of faces without area, which were enlarged a little.
    """

    base: FloatArray
    along: FloatArray
    across: FloatArray
    mollified: int

    @property
    def areas(self) -> FloatArray:
        """(m,) face areas, in the squared unit of the positions."""
        return 0.5 * self.base * self.across


def rest_triangles(positions: FloatArray, faces: IntArray) -> RestTriangles:
    """Lay each face of ``positions`` (k, 3), ``faces`` (m, 3) in a plane of its own.

    A face that is a line or a point has no shape to compare a map with. Its sides are lengthened by an equal amount
    until they form a triangle (local intrinsic mollification, Sharp and Crane 2020); no vertex moves.
    """
    a, b, c = (np.ascontiguousarray(positions[corner].T) for corner in faces.T)
    first = b - a
    second = c - a
    third = c - b
    base = _length(first)
    height = _length((first[[1, 2, 0]] * second[[2, 0, 1]]) - (first[[2, 0, 1]] * second[[1, 2, 0]]))
    safe = np.where(base > 0, base, 1.0)
    along = (first * second).sum(axis=0) / safe
    across = height / safe
    sides = np.stack([base, _length(third), _length(second)])
    # The two shorter sides must exceed the longest by the margin.
    lacking = MOLLIFICATION * sides.mean() - (sides.sum(axis=0) - 2 * sides.max(axis=0))
    thin = lacking > 0
    if thin.any():
        base[thin], along[thin], across[thin] = _triangle_from_sides((sides[:, thin] + lacking[thin]).T)
    return RestTriangles(base, along, across, int(thin.sum()))


def _length(vectors: FloatArray) -> FloatArray:
    """Return the lengths (m,) of ``vectors`` (3, m); three times faster than norms of rows."""
    x, y, z = vectors
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _triangle_from_sides(sides: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return base, along and across of triangles with ``sides`` (t, 3) from corner k to k + 1; Kahan's stable area."""
    c, b, a = np.sort(sides, axis=1).T
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    base = sides[:, 0]
    along = (base**2 + sides[:, 2] ** 2 - sides[:, 1] ** 2) / (2 * base)
    return base, along, 0.5 * np.sqrt(square) / base


_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


class HessianPattern:
    """Pattern of upper triangles (2k, 2k) with a 2 x 2 block for each vertex and each edge of a mesh.

    Args:
        connectivity: Connectivity of the mesh.
        count: Number of vertices k.

    Cost: one sort of 3 m edges; filling takes 10 ns per entry.
    """

    def __init__(self, connectivity: Connectivity, count: int) -> None:
        self._faces = connectivity.faces
        self._count = count
        edges = connectivity.edges
        # Edges by their higher vertex: each is a block in that vertex's two columns, above its diagonal block.
        order = np.lexsort((edges[:, 0], edges[:, 1]))
        self._lower = np.bincount(edges[:, 1], minlength=count)
        first = np.concatenate([[0], np.cumsum(self._lower)])
        self._rank = np.empty(len(order), dtype=np.int64)
        self._rank[order] = np.arange(len(order)) - first[edges[order, 1]]
        self._edges = edges
        self._edge_of = connectivity.edge_of
        self._sorted = edges[order, 0]
        # The two columns of a vertex have two entries per edge, and one and two of its diagonal block.
        lengths = np.stack([2 * self._lower + 1, 2 * self._lower + 2], axis=1).ravel()
        self.columns = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)

    @cached_property
    def rows(self) -> NDArray[np.int32]:
        """(nnz,) row of each entry, ascending in each column."""
        result = np.empty(int(self.columns[-1]), dtype=np.int32)
        diagonal = np.arange(self._count)
        for column in range(2):
            start = self.columns[column:-1:2].astype(np.int64)
            for row in range(2):
                owner, step = owner_and_rank(self._lower)
                result[start[owner] + 2 * step + row] = 2 * self._sorted + row
                if row <= column:
                    result[start + 2 * self._lower + row] = 2 * diagonal + row
        return result

    @cached_property
    def _slots(self) -> IntArray:
        """Data index of every entry of every block, in the order in which ``matrix`` lists them."""
        starts = self.columns.astype(np.int64)
        parts = []
        for k, other in _PAIRS:
            if k == other:
                v = self._faces[:, k]
                parts += [starts[2 * v + j] + 2 * self._lower[v] + i for i, j in ((0, 0), (0, 1), (1, 1))]
                continue
            edge = self._edge_of[:, {(0, 1): 0, (1, 2): 1, (0, 2): 2}[k, other]]
            high = self._edges[edge, 1]
            turned = self._faces[:, k] > self._faces[:, other]
            for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
                row = np.where(turned, j, i)
                column = np.where(turned, i, j)
                parts.append(starts[2 * high + column] + 2 * self._rank[edge] + row)
        return np.concatenate(parts)

    def matrix(self, blocks: Mapping[tuple[int, int], tuple[FloatArray, ...]]) -> csc_matrix:
        """Return the sum over the faces of ``blocks``: for corners (k, l) the entries (xx, xy, yx, yy), each (m,)."""
        values: list[FloatArray] = []
        for pair in _PAIRS:
            xx, xy, yx, yy = blocks[pair]
            values += [xx, xy, yy] if pair[0] == pair[1] else [xx, xy, yx, yy]
        data = np.bincount(self._slots, np.concatenate(values), minlength=len(self.rows))
        size = 2 * self._count
        return csc_matrix((data, self.rows, self.columns), shape=(size, size))


class SymmetricDirichlet:
    """Energy of maps of one triangulated disk. Built once from the rest shape, evaluated for planes.

    Args:
        rest: The disk at rest, scaled to about unit area.
        lengths: 1 keeps lengths (symmetric Dirichlet), 0 keeps angles whatever the areas; values between mix both.

    Attributes:
        faces: (m, 3) of the disk.
        areas: (m,) of the faces at rest.
        mollified: Number of faces without area, which were enlarged a little, see ``rest_triangles``.
    """

    def __init__(self, rest: Mesh, *, lengths: float = 1.0) -> None:
        shape = rest_triangles(rest.vertices, rest.faces)
        self.faces = rest.faces
        self.areas = shape.areas
        self.mollified = shape.mollified
        self._rest = rest
        self._lengths = lengths
        self._count = len(rest.vertices)
        self._base = 1 / shape.base
        self._along = shape.along
        self._across = 1 / shape.across
        self._weight = shape.areas / shape.areas.sum()
        self._corners = np.ascontiguousarray(rest.faces.T)
        self._pattern: HessianPattern | None = None

    def jacobians(self, plane: FloatArray) -> FloatArray:
        """Return the differential (m, 2, 2) of the map on each face, from the rest frame to the plane."""
        return np.stack(self._jacobian(plane), axis=1).reshape(-1, 2, 2)

    def _jacobian(self, plane: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return entries xx, xy, yx, yy, each (m,): one array per entry is several times faster than small matrices."""
        x, y = self._at_corners(plane)
        xx = (x[1] - x[0]) * self._base
        yx = (y[1] - y[0]) * self._base
        xy = (x[2] - x[0] - xx * self._along) * self._across
        yy = (y[2] - y[0] - yx * self._along) * self._across
        return xx, xy, yx, yy

    def _at_corners(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x and y, each (3, m), of ``points`` (k, 2) at the faces' corners."""
        return points[:, 0].take(self._corners), points[:, 1].take(self._corners)

    def energy(self, plane: FloatArray) -> float:
        """Return the mean energy by area; inf if a face has no positive area."""
        xx, xy, yx, yy = self._jacobian(plane)
        determinant = xx * yy - xy * yx
        if not (determinant > 0).all():
            return float("inf")
        squares = xx * xx + xy * xy + yx * yx + yy * yy
        with np.errstate(over="ignore"):  # the energy of a face of almost no area may overflow to inf
            inverse = 1 / determinant
            lengths = 1 + inverse * inverse
            angles = 2 * inverse
            return dot(self._weight, squares * (self._lengths * lengths + (1 - self._lengths) * angles))

    def energy_at_best_scale(self, plane: FloatArray) -> float:
        """Return the least mean energy of lengths over all scales of ``plane``; inf if a face has no positive area.

        With a = mean(s1² + s2²) and b = mean(1/s1² + 1/s2²), a c² + b / c² is least at 2 sqrt(a b).
        """
        xx, xy, yx, yy = self._jacobian(plane)
        determinant = xx * yy - xy * yx
        if not (determinant > 0).all():
            return float("inf")
        squares = xx * xx + xy * xy + yx * yx + yy * yy
        with np.errstate(over="ignore"):
            stretched = dot(self._weight, squares)
            squeezed = dot(self._weight, squares * determinant**-2)
            return float(2 * np.sqrt(stretched) * np.sqrt(squeezed))

    def gradient(self, plane: FloatArray) -> FloatArray:
        """Return the gradient (2k,) of the mean energy; x and y of a vertex are adjacent."""
        u, s, v = _rotations_and_values(*self._jacobian(plane))
        return self._gradient(u, self._slopes(*s), self._hats(v))

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Return the gradient (2k,) and the upper triangle of the projected Hessian (2k, 2k)."""
        u, s, v = _rotations_and_values(*self._jacobian(plane))
        hats = self._hats(v)
        gradient = self._gradient(u, self._slopes(*s), hats)
        curvatures = self._curvatures(*s)
        if self._pattern is None:
            self._pattern = HessianPattern(self._rest.connectivity, self._count)
        return gradient, self._pattern.matrix(_blocks(u, curvatures, hats))

    def _hats(self, v: tuple[FloatArray, FloatArray]) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Return the gradients of the hat functions of corners 1 and 2 in the frame of the right singular vectors."""
        cosine, sine = v
        x = self._base
        y = -self._along * self._base * self._across
        return (cosine * x + sine * y, cosine * y - sine * x), (sine * self._across, cosine * self._across)

    def _slopes(self, s1: FloatArray, s2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return weighted derivatives per face along s1 and s2."""
        long = self._lengths * self._weight
        round_ = (1 - self._lengths) * self._weight
        i1 = 1 / s1
        i2 = 1 / s2
        first = 2 * long * (s1 - i1 * i1 * i1) + 2 * round_ * (i2 - s2 * i1 * i1)
        return first, 2 * long * (s2 - i2 * i2 * i2) + 2 * round_ * (i1 - s1 * i2 * i2)

    def _curvatures(self, s1: FloatArray, s2: FloatArray) -> tuple[FloatArray, ...]:
        """Return weighted curvatures >= 0 per face: 11, 12 and 22 of stretching, then the modes twist and flip."""
        long = self._lengths * self._weight
        round_ = (1 - self._lengths) * self._weight
        i1 = 1 / s1
        i2 = 1 / s2
        product = s1 * s2
        inverse = 1 / product
        squares = inverse * inverse
        cubes = squares * inverse
        twist = long * (2 - 2 * (s1 * s1 - product + s2 * s2) * cubes) - 2 * round_ * (s1 - s2) ** 2 * squares
        flip = long * (2 + 2 * (s1 * s1 + product + s2 * s2) * cubes) + 2 * round_ * (s1 + s2) ** 2 * squares
        first = long * _curvature(s1, i1) + 4 * round_ * s2 * i1 * i1 * i1
        second = long * _curvature(s2, i2) + 4 * round_ * s1 * i2 * i2 * i2
        mixed = -2 * round_ * (i1 * i1 + i2 * i2)
        return *_without_negative(first, mixed, second), np.maximum(twist, 0.0), flip

    def _gradient(
        self,
        u: tuple[FloatArray, FloatArray],
        slopes: tuple[FloatArray, ...],
        hats: tuple[tuple[FloatArray, FloatArray], ...],
    ) -> FloatArray:
        cosine, sine = u
        forces = [(slopes[0] * p, slopes[1] * q) for p, q in hats]
        x = np.stack([cosine * a - sine * b for a, b in forces])
        y = np.stack([sine * a + cosine * b for a, b in forces])
        result = np.empty((self._count, 2))
        for axis, part in enumerate((x, y)):
            corners = np.concatenate([-part.sum(axis=0), part[0], part[1]])
            result[:, axis] = np.bincount(self._corners.ravel(), corners, minlength=self._count)
        return result.ravel()

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """Return the step length at which the first face loses its area; inf if none does."""
        (x, y), (dx, dy) = self._at_corners(plane), self._at_corners(step)
        x1 = x[1] - x[0]
        y1 = y[1] - y[0]
        x2 = x[2] - x[0]
        y2 = y[2] - y[0]
        u1 = dx[1] - dx[0]
        v1 = dy[1] - dy[0]
        u2 = dx[2] - dx[0]
        v2 = dy[2] - dy[0]
        c = x1 * y2 - y1 * x2
        b = x1 * v2 - y1 * u2 + u1 * y2 - v1 * x2
        a = u1 * v2 - v1 * u2
        under = b * b - 4 * a * c
        # The stable form of the smaller positive root of a t² + b t + c with c > 0.
        denominator = -b + np.sqrt(np.maximum(under, 0.0))
        real = (under >= 0) & (denominator > 0)
        # A root beyond the largest number is infinity: a step of 1e-280 does not collapse a face.
        with np.errstate(over="ignore"):
            times = 2 * c[real] / denominator[real]
        return float(times.min()) if len(times) else float("inf")


def rotation_svd(matrices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rotations u (m, 2, 2), values s (m, 2) and rotations vt with u diag(s) vt = ``matrices`` (m, 2, 2).

    The values are s1 >= |s2|, and s2 has the sign of the determinant. Closed form (Blinn 1996), vectorised.
    """
    (xx, xy), (yx, yy) = np.moveaxis(matrices, 0, -1)
    u, s, v = _rotations_and_values(xx, xy, yx, yy)
    return _matrices(u), np.stack(s, axis=1), _matrices(v).swapaxes(1, 2)


def _rotations_and_values(
    xx: FloatArray, xy: FloatArray, yx: FloatArray, yy: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Return cosine and sine of u, the two values, cosine and sine of v, each (m,), with u diag(s) v' the matrix.

    The matrix is a scaled rotation by u - v plus a scaled reflection by u + v. Both directions are unit vectors, and
    half of their sum follows from the half-angle formulas; arc functions take twice the time.
    """
    spun = np.hypot(xx + yy, yx - xy)
    flipped = np.hypot(xx - yy, xy + yx)
    c, s = _directions(xx + yy, yx - xy, spun)
    d, t = _directions(xx - yy, xy + yx, flipped)
    largest = (spun + flipped) / 2
    # The smaller value follows from the determinant: the difference of the two would lose its digits.
    smallest = (xx * yy - xy * yx) / np.where(largest > 0, largest, 1.0)
    cosine, sine = _halved(c * d - s * t, s * d + c * t)
    return (cosine, sine), (largest, smallest), (cosine * c + sine * s, sine * c - cosine * s)


def _directions(x: FloatArray, y: FloatArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cosine and sine, each (m,), of vectors with known lengths; those of the x axis for zero length."""
    held = length > np.finfo(float).tiny
    if not held.all():
        x = np.where(held, x, 1.0)
        y = np.where(held, y, 0.0)
        length = np.where(held, length, 1.0)
    return x / length, y / length


def _halved(cosine: FloatArray, sine: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cosine and sine of half the angles, each by the formula without cancellation."""
    larger = np.sqrt(0.5 * (1 + np.abs(cosine)))
    smaller = 0.5 * sine / larger
    ahead = cosine >= 0
    return np.where(ahead, larger, np.abs(smaller)), np.where(ahead, smaller, np.copysign(larger, sine))


def _matrices(rotation: tuple[FloatArray, FloatArray]) -> FloatArray:
    cosine, sine = rotation
    return np.stack([cosine, -sine, sine, cosine], axis=1).reshape(-1, 2, 2)


def _curvature(s: FloatArray, inverse: FloatArray) -> FloatArray:
    """Return the curvature of s² + 1/s² per unit area, reduced for compressed faces.

    From far below one, Newton steps on 1/s² increase s by only a third. The chord to s = 1 has the curvature
    2 (1 + s) (1 + s²) / s³ and would jump there in one step, too far if the neighbours of a face keep it compressed.
    The geometric mean of both takes half the rounds of Newton's (measured: 14 -> 7 on a bump, 13 -> 6 on a waved tube,
    21 -> 14 on a deep cup). The optimum is the same, since it depends only on the gradient.
    """
    square = inverse * inverse
    true = 2 + 6 * square * square
    return np.where(s < 1, np.sqrt(true * 2 * (1 + s) * (1 + s * s) * square * inverse), true)


def _without_negative(a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Set a negative eigenvalue of symmetric [[a, b], [b, c]] to zero; with a + c > 0 there is at most one."""
    bad = a * c < b * b
    if not bad.any():
        return a, b, c
    half = 0.5 * (a[bad] - c[bad])
    mean = 0.5 * (a[bad] + c[bad])
    radius = np.hypot(half, b[bad])
    top = (mean + radius) / (2 * radius)
    a = a.copy()
    b = b.copy()
    c = c.copy()
    a[bad] = top * (radius + half)
    b[bad] = top * b[bad]
    c[bad] = top * (radius - half)
    return a, b, c


def _blocks(
    u: tuple[FloatArray, FloatArray],
    curvatures: tuple[FloatArray, ...],
    hats: tuple[tuple[FloatArray, FloatArray], ...],
) -> dict[tuple[int, int], tuple[FloatArray, ...]]:
    """Return the 2 x 2 blocks (xx, xy, yx, yy), each entry (m,), of corners (k, l), k <= l, of every face."""
    first, mixed, second, twist, flip = curvatures
    spin = 0.5 * (flip + twist)
    swap = 0.5 * (flip - twist)
    blocks: dict[tuple[int, int], tuple[FloatArray, ...]] = {}
    for pair in ((1, 1), (1, 2), (2, 2)):
        (p, q), (r, t) = (hats[corner - 1] for corner in pair)
        pr = p * r
        qt = q * t
        pt = p * t
        qr = q * r
        inner = first * pr + spin * qt, mixed * pt + swap * qr, mixed * qr + swap * pt, second * qt + spin * pr
        blocks[pair] = _turned(u, *inner)
    a = blocks[1, 1]
    b = blocks[1, 2]
    c = blocks[2, 2]
    # The three hat functions sum to one, so the blocks of each row sum to zero.
    blocks[0, 1] = -(a[0] + b[0]), -(a[1] + b[2]), -(a[2] + b[1]), -(a[3] + b[3])
    blocks[0, 2] = tuple(-(x + y) for x, y in zip(b, c, strict=True))
    d = blocks[0, 1]
    e = blocks[0, 2]
    blocks[0, 0] = -(d[0] + e[0]), -(d[2] + e[2]), -(d[1] + e[1]), -(d[3] + e[3])
    return blocks


def _turned(
    u: tuple[FloatArray, FloatArray], xx: FloatArray, xy: FloatArray, yx: FloatArray, yy: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the entries of u [[xx, xy], [yx, yy]] u'."""
    c, s = u
    ax = c * xx - s * yx
    ay = c * xy - s * yy
    bx = s * xx + c * yx
    by = s * xy + c * yy
    return ax * c - ay * s, ax * s + ay * c, bx * c - by * s, bx * s + by * c
