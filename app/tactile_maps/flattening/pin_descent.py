"""Descent rounds that follow moving pins: each fits in a frame, never increases the energy and never flips a face.

The map is held by pins: springs from points of the body to their targets. A pin inside a face pulls at its three
corners, by their weights. Springs connect corners of one face, whose entries the Hessian has anyway, so a changed set
of pins needs no new symbolic analysis, and a moved pin changes only the gradient.

Decision: soft springs at points instead of rigid handles of a ring of faces, which are not clearly better. Measured on
a circle of a quarter of the map in 60 frames of one Newton step, largest excess over the least energy, points and
handles: bump of 968 faces 0.5 and 0.1 %, bump of 10,000 0.4 and 13 % (the rotation of a handle lags a step behind),
torso of 10,000 8.8 and 5.0 %; no flips with either. Points can be anywhere on the body, and with the move spread over
the map (``shepard_warp``) they stay within 0.5 % on all three; handles were not tested with it.

Three things keep a frame short and the map valid:

- Limited reach. A distant target is approached through nearer ones, so that no face is crushed on the way. The reach
  adapts to the steps that are possible.
- Spread moves. A Newton step responds to a pull on a point like a needle: the faces around the pin take nearly all of
  it and collapse. So each move is first distributed over the map: every point moves by the mean of the pins' moves,
  weighted by 1 / distance⁴ (Shepard 1968), rigid near each pin and smooth between them. Measured on a circle of a
  quarter of the map in 60 frames with one Newton step each: on two of three meshes of 10,000 faces the largest lag of a
  pin drops from 1 % to 0.02 % of the map; on the third it was small already. The Hessian also remains usable for
  longer: 2 to 27 of the 60 frames need a new one, instead of all.
- Reused factorisations. A moved pin does not change the Hessian, and quasi-Newton steps follow the change of the map
  until their gain or length shows that it is outdated.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix

from tactile_maps.core.arrays import FloatArray, IntArray, dot
from tactile_maps.core.errors import MapError
from tactile_maps.core.sparse_ldl import SparseLDL
from tactile_maps.flattening.newton import Energy, factorise, line_search, quasi_newton

STIFFNESS = 1e4
"""Stiffness of a pin for maps of unit area. A pull that doubles the energy of a map leaves a lag of 1 % of the map."""


class Springs:
    """Springs at the pins of a map. Built once for a set of pins, independent of their targets.

    Args:
        corners: (p, 3) vertices of the faces that contain the pins.
        weights: (p, 3) of the pins in them; they sum to one.
    """

    def __init__(self, corners: IntArray, weights: FloatArray) -> None:
        self.corners = corners
        self.weights = weights
        self._slots: IntArray | None = None

    def add_to(self, hessian: csc_matrix) -> None:
        """Add the springs to the upper triangle of a Hessian (2k, 2k), which must always have the same pattern."""
        first, second, stiffness = self._pairs
        if self._slots is None:  # 1 ms for 10,000 faces
            size = hessian.shape[0]
            keys = np.repeat(np.arange(size), np.diff(hessian.indptr)) * size + hessian.indices
            entries = np.concatenate([(2 * second + axis) * size + 2 * first + axis for axis in range(2)])
            self._slots = np.searchsorted(keys, entries)
        np.add.at(hessian.data, self._slots, np.tile(stiffness, 2))

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Vertices i <= j of each pair of corners of a pin's face, and the stiffness between them."""
        first = np.repeat(self.corners, 3, axis=1).ravel()
        second = np.tile(self.corners, (1, 3)).ravel()
        value = (2 * STIFFNESS * self.weights[:, :, None] * self.weights[:, None, :]).ravel()
        upper = first <= second
        return first[upper], second[upper], value[upper]


class PinnedEnergy:
    """Sum of the energies of a map and of springs.

    Args:
        problem: The energy of stretching, of a map of about unit area.
        springs: Springs at the pins.
        goals: (p, 2) target positions on the plane.
    """

    def __init__(self, problem: Energy, springs: Springs, goals: FloatArray) -> None:
        self._problem = problem
        self._springs = springs
        self.goals = goals

    def towards(self, goals: FloatArray) -> PinnedEnergy:
        """Return the energy with other ``goals`` (p, 2)."""
        return PinnedEnergy(self._problem, self._springs, goals)

    def places(self, plane: FloatArray) -> FloatArray:
        """Return the positions (p, 2) of the pins on ``plane`` (k, 2)."""
        return np.einsum("pc,pcd->pd", self._springs.weights, plane[self._springs.corners])

    def energy(self, plane: FloatArray) -> float:
        """Return the mean energy by area plus the springs; inf if a face has no positive area."""
        return self._problem.energy(plane) + STIFFNESS * float(((self.places(plane) - self.goals) ** 2).sum())

    def gradient(self, plane: FloatArray) -> FloatArray:
        """Return the gradient (2k,); x and y of a vertex are adjacent."""
        return self._pulled(self._problem.gradient(plane), plane)

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Return the gradient (2k,) and upper triangle (2k, 2k) of the Hessian, in the pattern of ``problem``."""
        gradient, hessian = self._problem.derivatives(plane)
        self._springs.add_to(hessian)
        return self._pulled(gradient, plane), hessian

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """Return the step length at which the first face loses its area; inf if none does."""
        return self._problem.largest_step(plane, step)

    def _pulled(self, gradient: FloatArray, plane: FloatArray) -> FloatArray:
        pulls = 2 * STIFFNESS * self._springs.weights[:, :, None] * (self.places(plane) - self.goals)[:, None]
        np.add.at(gradient.reshape(-1, 2), self._springs.corners, pulls)
        return gradient


def shepard_warp(plane: FloatArray, places: FloatArray, moves: FloatArray) -> FloatArray:
    """Return the displacement (k, 2) of ``plane`` (k, 2) for ``moves`` (p, 2) of at least one of ``places`` (p, 2).

    For maps of about unit area: points within a millionth of a place move with it.

    Cost: 0.1 ms for 5,000 points and a pin.
    """
    x, y = ((plane[:, axis, None] - places[:, axis]) ** 2 for axis in range(2))
    nearness = 1 / (x + y + 1e-12)
    nearness *= nearness
    return np.einsum("kp,pd->kd", nearness, moves) / nearness.sum(axis=1, keepdims=True)


_FARTHEST = 0.05
_NEAREST = 1e-3
"""Largest and smallest reach, in shares of the map's size: from about four edges of 10,000 faces down to pins that
obstruct each other."""
_STEPS = 2
_REMEMBERED = 6
_AGED = 1e-3
"""Relative gain of a last step above which the Hessian is renewed."""
_NEGLIGIBLE = 1e-4
"""Pulls and relative gains below this are left to the next round."""
_ROUNDING = 1e-13
"""Steps with a smaller predicted relative gain are lost in rounding; their length says nothing about the reach."""

Barrier = Callable[[PinnedEnergy], Energy]


def _no_barrier(energy: PinnedEnergy) -> Energy:
    return energy


class PinDescent:
    """Descent of a map that follows pins. Mutable: ``plane`` (k, 2) is the current map, of unit area and without flips.

    Args:
        plane: (k, 2) initial map.
        barrier: Returns the energy with a barrier; none by default.
    """

    def __init__(self, plane: FloatArray, *, barrier: Barrier = _no_barrier) -> None:
        self.plane = plane
        self._barrier = barrier
        self._factor = SparseLDL()
        self._steps = list[tuple[FloatArray, FloatArray]]()
        self._reach = _FARTHEST
        self._aged = True
        self._shortest = 1.0

    def forget(self) -> None:
        """Discard the Hessian, after a change of pins or energy."""
        self._aged = True

    def round(self, target: PinnedEnergy) -> float:
        """Run one round towards ``target``; return the decrease of its energy, 0 if no step was possible.

        Cost: at 10,000 faces 7 ms, with a new Hessian 18 ms.
        """
        places = target.places(self.plane)
        moves = target.goals - places
        lengths = np.linalg.norm(moves, axis=1, keepdims=True)
        moves = moves * np.minimum(1.0, self._reach / np.maximum(lengths, 1e-12))
        near = self._barrier(target.towards(places + moves))
        whole = self._barrier(target)
        before = whole.energy(self.plane)
        fresh = self._aged
        self._shortest = 1.0
        try:
            plane = self._descended(near, *self._pulled(near, places, moves))
        except MapError:  # a face is too thin for a step: the map is unchanged, and the lag of the pins is reported
            self._aged = True
            self._reach = max(_NEAREST, 0.5 * self._reach)
            return 0.0
        gain = before - whole.energy(plane)
        self._adapt(gain, fresh)
        if not gain > 0:
            return 0.0
        self.plane = plane
        return gain

    def _pulled(self, near: Energy, places: FloatArray, moves: FloatArray) -> tuple[FloatArray, float]:
        """Return the map with the pins' moves spread over it, and its energy; unchanged if that is not lower."""
        energy = near.energy(self.plane)
        if not np.abs(moves).max(initial=0.0) > _NEGLIGIBLE:
            return self.plane, energy
        step = shepard_warp(self.plane, places, moves)
        moved = self.plane + min(1.0, 0.5 * near.largest_step(self.plane, step)) * step
        reached = near.energy(moved)
        return (moved, reached) if reached < energy else (self.plane, energy)

    def _descended(self, near: Energy, plane: FloatArray, energy: float) -> FloatArray:
        """Return the map after one Newton step with a new Hessian, or a few steps with the previous one."""
        gradient, count = self._prepared(near, plane)
        gain = 0.0
        for _ in range(count):
            step = -quasi_newton(self._factor, self._steps, gradient).reshape(-1, 2)
            slope = dot(gradient, step.ravel())
            if -slope <= _ROUNDING * energy:
                break
            after, reached, length = line_search(near, plane, step, energy, slope)
            self._shortest = min(self._shortest, length)
            if length == 0:
                break
            gain = energy - reached
            new = near.gradient(after)
            self._remember((after - plane).ravel(), new - gradient)
            plane = after
            energy = reached
            gradient = new
            if gain <= _NEGLIGIBLE * max(energy - 4, 1e-9):
                return plane
        self._aged = self._shortest < 0.3 or (count > 1 and gain > _AGED * max(energy - 4, 1e-9))
        return plane

    def _prepared(self, near: Energy, plane: FloatArray) -> tuple[FloatArray, int]:
        """Return the gradient and the number of steps for this Hessian."""
        if not self._aged:
            return near.gradient(plane), _STEPS
        gradient, hessian = near.derivatives(plane)
        factorise(self._factor, hessian)
        self._steps = []
        self._aged = False
        return gradient, 1

    def _remember(self, moved: FloatArray, turned: FloatArray) -> None:
        if dot(moved, turned) > 0:
            self._steps = [*self._steps, (moved, turned)][-_REMEMBERED:]

    def _adapt(self, gain: float, fresh: bool) -> None:
        """Increase the reach after long steps, decrease it after short ones."""
        if not gain > 0:
            # With a new Hessian nothing is left to gain, or the pins pull too far; otherwise the Hessian was outdated.
            self._aged = not fresh
        if self._shortest < 0.25 or (fresh and not gain > 0):
            self._reach = max(_NEAREST, 0.5 * self._reach)
        elif self._shortest >= 0.5:
            self._reach = min(_FARTHEST, 1.5 * self._reach)
