"""Newton minimiser from a valid map to the optimum; each factorisation serves several steps.

A factorisation costs ten times a gradient. After a Newton step its Hessian remains the metric of a few limited-memory
quasi-Newton steps (BFGS, Nocedal 1980; with the last Hessian as the initial metric, Liu et al. 2017), as long as each
contributes a fair share of the gain. Every step is limited to 0.9 of the way to the first triangle without area.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from scipy.sparse import csc_matrix

from tactile_maps.core.arrays import FloatArray, dot
from tactile_maps.core.errors import MapError
from tactile_maps.core.sparse_ldl import SparseLDL

_ARMIJO = 1e-4
_SAFE = 0.9
_STEPS = 7
"""Largest number of steps per factorisation."""
_FAIR_SHARE = 0.2
"""A step that gains less than this share of the mean gain so far triggers a new factorisation."""


class DescentStopped(MapError):
    """A descent ended before convergence; the last map is the best so far."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """Result of a round of a minimiser.

    Attributes:
        plane: (k, 2) vertex positions on the plane.
        energy: Mean energy by area; 4 is an isometry.
        seconds: Wall time since the start.
    """

    plane: FloatArray
    energy: float
    seconds: float


OnRound: TypeAlias = Callable[[Iterate], None]
"""Called after each round of a minimiser; may raise to cancel."""


class Energy(Protocol):
    """Energy that ``minimise`` accepts."""

    def energy(self, plane: FloatArray, /) -> float:
        """Return the energy of a map; inf where the map is not valid."""

    def gradient(self, plane: FloatArray, /) -> FloatArray:
        """Return the gradient (2k,) at a map; x and y of a vertex are adjacent."""

    def derivatives(self, plane: FloatArray, /) -> tuple[FloatArray, csc_matrix]:
        """Return the gradient and the upper triangle of a positive semidefinite Hessian."""

    def largest_step(self, plane: FloatArray, step: FloatArray, /) -> float:
        """Return an upper bound of the step length up to which the energy is finite."""


def minimise(
    problem: Energy,
    plane: FloatArray,
    *,
    tolerance: float = 1e-4,
    rounds: int = 100,
    clock: Callable[[], float] = time.perf_counter,
) -> Iterator[Iterate]:
    """Yield ever better maps, from a valid one until a factorisation gains less than ``tolerance`` of what could be.

    Args:
        problem: The energy; 4 is the least possible.
        plane: (k, 2) a map without flips.
        tolerance: Relative decrease of (energy - 4) that still counts as progress.
        rounds: Largest number of factorisations.
        clock: Returns the time [s].

    Raises:
        MapError: The start has flips, or the system is too ill-conditioned to solve.
        DescentStopped: The last factorisation still reduced the energy; all maps have been yielded.

    Cost: about 4 µs a face and factorisation; four to eight of these from Tutte's map, up to twenty on deep cups.
    """
    start = clock()
    energy = problem.energy(plane)
    if not np.isfinite(energy):
        raise MapError("the initial map has flipped triangles", remedy="Remove very thin triangles from the surface")
    yield Iterate(plane, energy, clock() - start)
    factor = SparseLDL()
    for _ in range(rounds):
        before = energy
        for after, reached in _steps(problem, factor, plane, energy, tolerance):
            plane = after
            energy = reached
            yield Iterate(plane, energy, clock() - start)
        if before - energy <= tolerance * max(energy - 4, 1e-9):
            return
    raise DescentStopped("the descent has not converged", value=f"{rounds} factorisations", remedy="Start from its end")


def _steps(
    problem: Energy, factor: SparseLDL, plane: FloatArray, energy: float, tolerance: float
) -> Iterator[tuple[FloatArray, float]]:
    """Yield maps and their energies from one factorisation."""
    gradient, hessian = problem.derivatives(plane)
    factorise(factor, hessian)
    steps: list[tuple[FloatArray, FloatArray]] = []
    first = energy
    for count in range(1, _STEPS + 1):
        step = -quasi_newton(factor, steps, gradient).reshape(-1, 2)
        after, reached, _ = line_search(problem, plane, step, energy, dot(gradient, step.ravel()))
        yield after, reached
        gain = energy - reached
        if gain <= max(tolerance * max(reached - 4, 1e-9), _FAIR_SHARE * (first - reached) / count) or count == _STEPS:
            return
        new = problem.gradient(after)
        moved = (after - plane).ravel()
        change = new - gradient
        if dot(moved, change) > 0:
            steps.append((moved, change))
        plane = after
        energy = reached
        gradient = new


def factorise(factor: SparseLDL, hessian: csc_matrix) -> None:
    """Factor ``hessian`` (upper triangle, modified in place); a small diagonal fixes rigid motions, which cost nothing.

    Raises:
        MapError: The system is too ill-conditioned to solve.
    """
    diagonal = hessian.indptr[1:] - 1  # the last entry of each column of an upper triangle
    hessian.data[diagonal] += 1e-9 * hessian.data[diagonal].mean()
    try:
        factor.update(hessian)
    except ArithmeticError as error:
        raise MapError("the map is too distorted to be improved", value=error, remedy="Use method tutte") from error


def quasi_newton(factor: SparseLDL, steps: list[tuple[FloatArray, FloatArray]], gradient: FloatArray) -> FloatArray:
    """Return the inverse Hessian estimate times ``gradient``: Nocedal's two loops around the factored Hessian.

    ``steps`` are the pairs (step, change of the gradient), each (2k,), since the factorisation.

    Raises:
        MapError: The system is too ill-conditioned to solve.
    """
    q = gradient
    shares = []
    for moved, change in reversed(steps):
        shares.append(dot(moved, q) / dot(moved, change))
        q = q - shares[-1] * change
    try:
        result = factor.solve(q)
    except ArithmeticError as error:
        raise MapError("the map is too distorted to be improved", value=error, remedy="Use method tutte") from error
    for (moved, change), share in zip(steps, reversed(shares), strict=True):
        result = result + moved * (share - dot(change, result) / dot(moved, change))
    return result


def line_search(
    problem: Energy, plane: FloatArray, step: FloatArray, energy: float, slope: float
) -> tuple[FloatArray, float, float]:
    """Return the accepted map, its energy and the step length; 0 if no step along ``step`` (k, 2) decreases enough."""
    length = min(1.0, _SAFE * problem.largest_step(plane, step))
    while length > 1e-10:
        candidate = plane + length * step
        reached = problem.energy(candidate)
        if reached <= energy + _ARMIJO * length * slope:
            return candidate, reached, length
        length *= 0.5
    return plane, energy, 0.0
