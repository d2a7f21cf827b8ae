"""The disk of a cut patch, normalised to unit area and centred, with its first one-to-one map.

The first map is Tutte's (1963): border on a circle, every inner vertex at the mean of its neighbours. Weights are
uniform, never cotangents: only with positive weights can no triangle flip, whatever its shape. Cost: one sparse
factorisation, 5 ms for 10,000 faces. Limits: the tip of a deep body shrinks towards a point, down to the smallest
number.

Where Tutte's map is very uneven, three more are tried: Tutte's balanced once (Yoshizawa, Belyaev and Seidel 2004); the
least squares conformal map (Lévy et al. 2002; libigl), which keeps angles and leaves the border free; and the
projection along the mean normal. Cost: one factorisation, 26 ms for 10,000 faces. Limits: areas; flips and overlaps on
deep bodies, which ``flatten`` then repairs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.sparse_ldl import SparseLDL
from tactile_maps.flattening.bijectivity import crossings
from tactile_maps.flattening.cut import CutSurface
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh, edge_lengths
from tactile_maps.geometry.surface.plane import cross


def flatten_by_tutte(disk: Disk) -> Iterator[FloatArray]:
    """Yield the map of the method ``tutte``."""
    yield tutte(disk.rest)


def tutte(disk: Mesh) -> FloatArray:
    """Map a disk to the unit circle.

    Args:
        disk: Mesh with one boundary loop; only border lengths are used.

    Returns:
        (k, 2) positions; faces are counter-clockwise.
    """
    return _solve_interior(boundary_on_circle(disk), np.ones(len(disk.edges)), disk.connectivity)


def stretch_balanced(disk: Mesh, plane: FloatArray) -> FloatArray:
    """Return a valid map with the same border and longer edges where they were too short.

    The weight of each edge is proportional to its relative length (Yoshizawa et al. 2004, made symmetric).
    """
    on_body = disk.edge_lengths
    on_map = edge_lengths(plane, disk.edges)
    tiny = np.finfo(float).tiny
    pull = np.maximum(on_map, tiny) / np.maximum(on_body, 1e-9 * on_body.max())
    return _solve_interior(boundary_on_circle(disk), np.maximum(pull / pull.max(), 1e-12), disk.connectivity)


def boundary_on_circle(disk: Mesh) -> FloatArray:
    """Return (k, 2) with the border on the unit circle, arcs as long as on the body; inner vertices at the origin."""
    (loop,), positions = disk.connectivity.boundary_loops, disk.vertices
    steps = np.linalg.norm(positions[np.roll(loop, -1)] - positions[loop], axis=1)
    # Coinciding corners would share a point of the circle; a small share of the mean step separates them.
    steps = np.maximum(steps, 1e-6 * steps.mean())
    angle = 2 * np.pi * np.concatenate([[0.0], np.cumsum(steps)[:-1]]) / steps.sum()
    plane = np.zeros((len(positions), 2))
    plane[loop] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return plane


def _solve_interior(plane: FloatArray, pull: FloatArray, connectivity: Connectivity) -> FloatArray:
    """Return the equilibrium of the inner vertices for edge weights ``pull``; the border is fixed."""
    count = len(plane)
    inner = np.ones(count, dtype=bool)
    inner[connectivity.boundary_loops[0]] = False
    if not inner.any():
        return plane
    number = np.cumsum(inner) - 1
    size = int(inner.sum())
    low, high = connectivity.edges.T
    total = np.bincount(low, pull, count) + np.bincount(high, pull, count)
    free = inner[low] & inner[high]
    rows = np.concatenate([number[low[free]], np.arange(size)])
    columns = number[high[free]]
    columns = np.concatenate([columns, np.arange(size)])
    data = np.concatenate([-pull[free], total[inner]])
    matrix = csc_matrix(coo_matrix((data, (rows, columns)), shape=(size, size)))
    matrix.sort_indices()
    right = np.zeros((count, 2))
    for here, there in ((low, high), (high, low)):
        held = inner[here] & ~inner[there]
        for axis in range(2):
            right[:, axis] += np.bincount(here[held], pull[held] * plane[there[held], axis], count)
    factor = SparseLDL()
    result = plane.copy()
    try:
        factor.update(matrix)
        result[inner] = factor.solve(right[inner])
    except ArithmeticError as error:
        raise MapError("the initial map cannot be computed", value=error, remedy="Split the patch") from error
    return result


def flatten_by_lscm(disk: Disk) -> Iterator[FloatArray]:
    """Yield the map of the method ``lscm``."""
    yield lscm(disk.rest)


def lscm(disk: Mesh) -> FloatArray:
    """Return the conformal map (k, 2); two distant border vertices are fixed, which determines the scale.

    Raises:
        RuntimeError: libigl could not solve it.
    """
    loop = disk.connectivity.boundary_loops[0]
    border = disk.vertices[loop]
    one = int(np.linalg.norm(border - border.mean(axis=0), axis=1).argmax())
    other = int(np.linalg.norm(border - border[one], axis=1).argmax())
    distance = float(np.linalg.norm(border[other] - border[one]))
    ends = np.array([[0.0, 0.0], [distance or 1.0, 0.0]])
    plane, _ = igl.lscm(disk.vertices, disk.faces, loop[[one, other]], ends)
    return np.asarray(plane)


def projection(disk: Mesh) -> FloatArray:
    """Return the disk (k, 2) projected along its mean normal; the origin without one, as on half a closed tube."""
    normal = disk.face_areas @ disk.face_normals
    size = float(np.linalg.norm(normal))
    if not size > 0:
        return np.zeros((len(disk.vertices), 2))
    along = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    along /= np.linalg.norm(along)
    return np.stack([disk.vertices @ along, disk.vertices @ np.cross(normal / size, along)], axis=1)


_STRAINED = 100.0
"""Mean energy of Tutte's map above which other initial maps are tried."""
_SLENDER = 30.0
"""Ratio of border length to diameter of the first map above which a patch counts as slender."""


@dataclass(frozen=True, eq=False)
class Disk:
    """A triangulated disk in space.

    Attributes:
        rest: Vertices of the cut, centred and scaled to unit area, so that tolerances do not depend on the unit of
            length; consistently oriented, without unused vertices.
    """

    rest: Mesh

    @property
    def positions(self) -> FloatArray:
        """(k, 3) vertex positions."""
        return self.rest.vertices

    @property
    def faces(self) -> IntArray:
        """(m, 3)."""
        return self.rest.faces

    @staticmethod
    def of(surface: Mesh, cut: CutSurface) -> Disk:
        """Return the disk that ``cut`` makes of ``surface``, which must have an area."""
        positions = surface.vertices[cut.vertex_of]
        return Disk(Mesh.of(cut.connectivity, (positions - positions.mean(axis=0)) / np.sqrt(surface.area)))

    @cached_property
    def loop(self) -> IntArray:
        """(b,) border vertices in order."""
        (loop,) = self.rest.connectivity.boundary_loops
        return loop

    @cached_property
    def energy(self) -> SymmetricDirichlet:
        """Symmetric Dirichlet energy of maps of the disk."""
        return SymmetricDirichlet(self.rest)

    @cached_property
    def start(self) -> FloatArray:
        """(k, 2) a one-to-one map of unit area: Tutte's, or the best of four where that is very uneven.

        Balancing Tutte's map helps on deep cups. On strips a thousand times longer than wide, which a circle can only
        compress, the conformal map is nearly the best already; where even that is lost in rounding, the projection of a
        nearly flat surface is. Both count only if they are one-to-one.
        """
        first = self.scaled(tutte(self.rest))
        if self.energy.energy(first) < _STRAINED:
            return first
        tried = [first, self.scaled(stretch_balanced(self.rest, first)), *self._conformal()]
        best = min(tried, key=self.energy.energy)
        if self.energy.energy(best) < _STRAINED:
            return best
        return min([best, *self._one_to_one(projection(self.rest))], key=self.energy.energy)

    @cached_property
    def taut(self) -> FloatArray:
        """(k, 2) ``start``, enlarged for slender patches until its diameter is the border's length on the body.

        A needle compressed into a small circle buckles when it grows, as a rod under pressure does; its folds cost so
        little that they remain and overlap. Starting too long it shrinks straight, and in fewer rounds.
        """
        border = self.positions[self.loop]
        length = float(np.linalg.norm(border - np.roll(border, 1, axis=0), axis=1).sum())
        diameter = float(np.ptp(self.start, axis=0).max())
        return self.start * (length / diameter) if length > _SLENDER * diameter else self.start

    def _conformal(self) -> list[FloatArray]:
        try:
            return self._one_to_one(lscm(self.rest))
        except RuntimeError:  # how libigl reports a singular system
            return []

    def _one_to_one(self, plane: FloatArray) -> list[FloatArray]:
        """Return ``plane`` at unit area if it is one-to-one, otherwise nothing."""
        scaled = self.scaled(plane)
        sound = np.isfinite(self.energy.energy(scaled)) and not crossings(scaled[self.loop])
        return [scaled] if sound else []

    def scaled(self, plane: FloatArray) -> FloatArray:
        """Return ``plane`` (k, 2) scaled to unit area, seen from the front."""
        area = self.area(plane)
        seen = plane * [1.0, -1.0] if area < 0 else plane
        return seen / np.sqrt(abs(area)) if area else plane

    def area(self, plane: FloatArray) -> float:
        """Return the signed area inside the border on ``plane`` (k, 2)."""
        here = plane[self.loop]
        after = np.roll(here, -1, axis=0)
        return float(0.5 * cross(here, after).sum())
