"""The map that stretches and shrinks least: projected Newton on the symmetric Dirichlet energy.

Energy (Smith and Schaefer 2015), by face with singular values s1, s2 of the map's differential:
    area (s1² + s2² + 1/s1² + 1/s2²), 4 per unit area for an isometry, infinite before a triangle can flip.
Hessian: the analytic eigensystem of isotropic energies (Smith, de Goes and Kim 2019), negative modes set to zero, so
that every step goes downhill. Each step is limited to 0.9 of the way to the first triangle without area.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from app.arrays import FloatArray, IntArray
from app.errors import MapError
from app.maps.rest import rest_triangles

_ARMIJO = 1e-4
_SAFE = 0.9


@dataclass(frozen=True, eq=False)
class Iterate:
    """One round of the minimiser.

    Attributes:
        plane: (k, 2) vertex positions on the plane.
        energy: Mean symmetric Dirichlet energy by area; 4 is an isometry.
        seconds: Wall time since the start.
        step: Length of the accepted step, 0 to 1; 0 where no step was possible.
    """

    plane: FloatArray
    energy: float
    seconds: float
    step: float


class SymmetricDirichlet:
    """The energy of maps of one triangulated disk. Built once from the rest shape; all questions are about a plane.

    Args:
        positions: (k, 3) rest positions; scale them to about unit area.
        faces: (m, 3).

    Attributes:
        faces: As given.
        areas: (m,) of the faces at rest.
        count: Number of vertices.
        mollified: How many faces had no area and were given a little, see ``rest``.
    """

    def __init__(self, positions: FloatArray, faces: IntArray) -> None:
        rest = rest_triangles(positions, faces)
        inverse = np.zeros((len(faces), 2, 2))
        inverse[:, 0, 0], inverse[:, 1, 1] = 1 / rest.base, 1 / rest.across
        inverse[:, 0, 1] = -rest.along / (rest.base * rest.across)
        # Rows of edges times inverse = gradient of the three hat functions: J = plane[face].T @ gradient.
        self._gradient = np.concatenate([-inverse.sum(axis=1)[:, None, :], inverse], axis=1)
        self.faces, self.areas, self.count, self.mollified = faces, rest.areas, len(positions), rest.mollified
        self._pattern()

    def jacobians(self, plane: FloatArray) -> FloatArray:
        """(m, 2, 2) differential of the map on each face, rest frame to plane."""
        return np.einsum("fki,fkj->fij", plane[self.faces], self._gradient)

    def energy(self, plane: FloatArray) -> float:
        """Mean energy by area; inf where a face has no positive area."""
        return self._energy_of(self.jacobians(plane))

    def _energy_of(self, jacobian: FloatArray) -> float:
        determinant = _determinants(jacobian)
        if not (determinant > 0).all():
            return float("inf")
        squares = (jacobian**2).sum(axis=(1, 2))
        with np.errstate(over="ignore"):  # a face of almost no area costs more than the largest number: inf is right
            return float((self.areas * squares * (1 + determinant**-2)).sum() / self.areas.sum())

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Gradient (2k,) and the projected Hessian (2k, 2k) of the mean energy; x and y of a vertex side by side."""
        u, s, vt = rotation_svd(self.jacobians(plane))
        weight = self.areas / self.areas.sum()
        slope = 2 * s - 2 * s**-3
        stress = np.einsum("fij,fj,fjk->fik", u, slope, vt)
        local = np.einsum("fij,fkj->fki", stress * weight[:, None, None], self._gradient)
        gradient = np.bincount(self._dofs.ravel(), local.ravel(), minlength=2 * self.count)
        modes, curvatures = _eigensystem(u, s, vt)
        # Each mode's matrix, seen through the face's six coordinates: (m, 4 modes, 6).
        rows = np.einsum("fqij,fkj->fqki", modes, self._gradient).reshape(len(s), 4, 6)
        blocks = np.einsum("fqa,fq,fqb->fab", rows, curvatures * weight[:, None], rows, optimize=True)
        data = np.bincount(self._slot, blocks.ravel(), minlength=len(self._rows))
        size = 2 * self.count
        return gradient.astype(np.float64), csc_matrix((data, self._rows, self._columns), shape=(size, size))

    def _pattern(self) -> None:
        """Where each face's 6 x 6 block goes in the sparse matrix; the same in every iteration."""
        self._dofs = (2 * self.faces[:, :, None] + np.arange(2)).reshape(-1, 6)
        size = 2 * self.count
        column = np.repeat(self._dofs, 6, axis=1).ravel()
        row = np.tile(self._dofs, (1, 6)).ravel()
        keys, self._slot = np.unique(column * size + row, return_inverse=True)
        self._rows = (keys % size).astype(np.int32)
        self._columns = np.searchsorted(keys // size, np.arange(size + 1)).astype(np.int32)

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """How far along ``step`` (k, 2) the first face loses its area; inf if none does."""
        p, d = plane[self.faces], step[self.faces]
        p1, p2, d1, d2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], d[:, 1] - d[:, 0], d[:, 2] - d[:, 0]
        c = p1[:, 0] * p2[:, 1] - p1[:, 1] * p2[:, 0]
        b = p1[:, 0] * d2[:, 1] - p1[:, 1] * d2[:, 0] + d1[:, 0] * p2[:, 1] - d1[:, 1] * p2[:, 0]
        a = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
        root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
        # The stable form of the smaller positive root of a t² + b t + c with c > 0.
        denominator = -b + root
        real = (b * b - 4 * a * c >= 0) & (denominator > 0)
        times = 2 * c[real] / denominator[real]
        return float(times.min()) if len(times) else float("inf")


class Energy(Protocol):
    """What ``minimise`` asks of an energy."""

    def energy(self, plane: FloatArray, /) -> float:
        """At a map; inf where the map is not allowed."""

    def derivatives(self, plane: FloatArray, /) -> tuple[FloatArray, csc_matrix]:
        """Gradient and positive semidefinite Hessian."""

    def largest_step(self, plane: FloatArray, step: FloatArray, /) -> float:
        """How far the energy is finite along a step, or more."""


def minimise(
    problem: Energy,
    plane: FloatArray,
    *,
    tolerance: float = 1e-4,
    rounds: int = 100,
    clock: Callable[[], float] = time.perf_counter,
) -> Iterator[Iterate]:
    """Yield ever better maps, from a valid one until a round gains less than ``tolerance`` of what could be gained.

    Args:
        problem: What to make small; 4 is the least possible.
        plane: (k, 2) a map without flips.
        tolerance: Relative decrease of (energy - 4) that still counts as progress.
        rounds: At most so many.
        clock: Seconds.

    Raises:
        MapError: The start has flips, or the numbers are too far apart to solve for a step.

    Cost: about 4 µs a face and round, nearly all of it factorisation.
    """
    start = clock()
    energy = problem.energy(plane)
    if not np.isfinite(energy):
        raise MapError("the first map has flipped triangles", remedy="The surface has triangles too thin to lay flat")
    yield Iterate(plane, energy, clock() - start, 1.0)
    for _ in range(rounds):
        gradient, hessian = problem.derivatives(plane)
        step = _newton_step(hessian, gradient)
        better, length = _line_search(problem, plane, step, energy, float(gradient @ step.ravel()))
        gained = energy - problem.energy(better)
        plane, energy = better, energy - gained
        yield Iterate(plane, energy, clock() - start, length)
        if gained <= tolerance * max(energy - 4, 1e-9):
            return


def _newton_step(hessian: csc_matrix, gradient: FloatArray) -> FloatArray:
    """(k, 2) downhill; the three rigid motions, which cost nothing, are held by a hint of the diagonal."""
    hessian.setdiag(hessian.diagonal() + 1e-9 * hessian.diagonal().mean())
    try:
        factor = splu(hessian, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    except RuntimeError as error:
        raise MapError("the map is too distorted to be improved", value=error, remedy="Use method tutte") from error
    return -np.asarray(factor.solve(gradient)).reshape(-1, 2)


def _line_search(
    problem: Energy, plane: FloatArray, step: FloatArray, energy: float, slope: float
) -> tuple[FloatArray, float]:
    length = min(1.0, _SAFE * problem.largest_step(plane, step))
    while length > 1e-10:
        candidate = plane + length * step
        if problem.energy(candidate) <= energy + _ARMIJO * length * slope:
            return candidate, length
        length *= 0.5
    return plane, 0.0


def rotation_svd(matrices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotations u (m, 2, 2), values s (m, 2) and rotations vt with u diag(s) vt = ``matrices`` (m, 2, 2).

    The values are s1 >= |s2|, and s2 has the determinant's sign. In closed form (Blinn 1996); no loop, no library.
    """
    (a, b), (c, d) = np.moveaxis(matrices, 0, -1)
    same, other = np.hypot(a + d, c - b) / 2, np.hypot(a - d, b + c) / 2
    turn, twist = np.arctan2(c - b, a + d), np.arctan2(b + c, a - d)
    largest = same + other
    # The smaller value by the determinant: the difference same - other would lose its digits.
    smallest = _determinants(matrices) / np.where(largest > 0, largest, 1.0)
    return _rotations(0.5 * (turn + twist)), np.stack([largest, smallest], axis=1), _rotations(0.5 * (turn - twist))


def _rotations(angles: FloatArray) -> FloatArray:
    cosine, sine = np.cos(angles), np.sin(angles)
    return np.stack([cosine, -sine, sine, cosine], axis=1).reshape(-1, 2, 2)


def _determinants(matrices: FloatArray) -> FloatArray:
    return matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]


def _eigensystem(u: FloatArray, s: FloatArray, vt: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The energy's four modes (m, 4, 2, 2), as 2 x 2 matrices, and their curvatures (m, 4), not negative."""
    half = np.sqrt(0.5)
    shapes = np.array([[[1, 0], [0, 0]], [[0, 0], [0, 1]], [[0, -half], [half, 0]], [[0, half], [half, 0]]])
    modes = np.einsum("fij,qjk,fkl->fqil", u, shapes, vt, optimize=True)
    s1, s2 = s[:, 0], s[:, 1]
    cubes = (s1 * s2) ** 3
    twist = 2 - 2 * (s1**2 - s1 * s2 + s2**2) / cubes
    flip = 2 + 2 * (s1**2 + s1 * s2 + s2**2) / cubes
    values = np.stack([2 + 6 * s1**-4, 2 + 6 * s2**-4, np.maximum(twist, 0.0), flip], axis=1)
    return modes, values
