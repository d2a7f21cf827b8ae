"""Rounds of a descent after moving pins: each short enough for a frame, never uphill, never over a flip.

The energy of a map that is held by pins: each is a spring from a place of the body to where it is wanted. A pin inside
a face pulls at its three corners, by their weights. Springs between corners of one face are entries that the Hessian
has anyway, so that a changed set of pins costs no new analysis, and a moved pin changes the gradient alone.

Why soft springs at points and not rigid handles of a ring of faces: handles are no clear gain. A circle of a quarter of
the map in 60 frames of one Newton step, most above the least energy, points and handles: bump of 968 faces 0.5 and
0.1 %, bump of 10,000 0.4 and 13 % (a handle's turn lags a step behind), torso of 10,000 8.8 and 5.0 %; no flips by
either. Points can be anywhere on the body, and with the move spread over the map (``shepard_warp``) they stay within
0.5 % on all three; handles were not tried with it.

Three things keep a frame short and the map healthy.

Pins are followed in reaches: a far goal is approached by a nearer one, so that no face is crushed on the way to it; the
reach grows and shrinks with the steps that are possible.

The first part of a move is spread smoothly over the whole map before any face is asked. One Newton step answers a pull
on a point like a needle: the faces around the pin take nearly all of it, and collapse. Here every place moves by the
mean of the pins' moves, weighed by 1 / distance⁴ (Shepard 1968): rigid near each pin, smooth between them. Measured on
a circle of a quarter of the map in 60 frames, one Newton step each: on two of three meshes of 10,000 faces the farthest
that a pin was left behind falls from 1 % to 0.02 % of the map, on the third it was small and stays so. And the Hessian
stays good for longer: 2 to 27 of the 60 frames need a new one, not each.

And a factored Hessian serves for several frames: a moved pin does not change it, and quasi-Newton steps follow what the
map's own change does, until their gain or their length says that it has aged.
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
"""Of a pin, for maps of unit area: a pull that doubles the energy of a map leaves its pin a hundredth of it behind."""


class Springs:
    """Where pins hold a map. Built once for a set of pins; where they are wanted is no part of it.

    Args:
        corners: (p, 3) vertices of the faces that hold the pins.
        weights: (p, 3) of the pins in them; they sum to one.
    """

    def __init__(self, corners: IntArray, weights: FloatArray) -> None:
        self.corners = corners
        self.weights = weights
        self._slots: IntArray | None = None

    def add_to(self, hessian: csc_matrix) -> None:
        """Add the springs' part to the upper triangle of a Hessian (2k, 2k); always to one of the same pattern."""
        first, second, stiffness = self._pairs
        if self._slots is None:  # 1 ms for 10,000 faces
            size = hessian.shape[0]
            keys = np.repeat(np.arange(size), np.diff(hessian.indptr)) * size + hessian.indices
            asked = np.concatenate([(2 * second + axis) * size + 2 * first + axis for axis in range(2)])
            self._slots = np.searchsorted(keys, asked)
        np.add.at(hessian.data, self._slots, np.tile(stiffness, 2))

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Vertices i <= j of every two corners of each pin's face, and the spring between them."""
        first = np.repeat(self.corners, 3, axis=1).ravel()
        second = np.tile(self.corners, (1, 3)).ravel()
        value = (2 * STIFFNESS * self.weights[:, :, None] * self.weights[:, None, :]).ravel()
        upper = first <= second
        return first[upper], second[upper], value[upper]


class PinnedEnergy:
    """The energy of a map and of springs, to be minimised in the former's place.

    Args:
        problem: The energy of stretching, of a map of about unit area.
        springs: Where pins hold it.
        goals: (p, 2) where on the plane they are wanted.
    """

    def __init__(self, problem: Energy, springs: Springs, goals: FloatArray) -> None:
        self._problem = problem
        self._springs = springs
        self.goals = goals

    def towards(self, goals: FloatArray) -> PinnedEnergy:
        """The same with other ``goals`` (p, 2)."""
        return PinnedEnergy(self._problem, self._springs, goals)

    def places(self, plane: FloatArray) -> FloatArray:
        """(p, 2) where the pins are on ``plane`` (k, 2)."""
        return np.einsum("pc,pcd->pd", self._springs.weights, plane[self._springs.corners])

    def energy(self, plane: FloatArray) -> float:
        """Mean energy by area plus the springs; inf where a face has no positive area."""
        return self._problem.energy(plane) + STIFFNESS * float(((self.places(plane) - self.goals) ** 2).sum())

    def gradient(self, plane: FloatArray) -> FloatArray:
        """(2k,) of the energy; x and y of a vertex side by side."""
        return self._pulled(self._problem.gradient(plane), plane)

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Gradient (2k,) and the projected Hessian's upper triangle (2k, 2k), in the pattern of the energy's own."""
        gradient, hessian = self._problem.derivatives(plane)
        self._springs.add_to(hessian)
        return self._pulled(gradient, plane), hessian

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """How far along ``step`` (k, 2) the first face loses its area; inf if none does."""
        return self._problem.largest_step(plane, step)

    def _pulled(self, gradient: FloatArray, plane: FloatArray) -> FloatArray:
        pulls = 2 * STIFFNESS * self._springs.weights[:, :, None] * (self.places(plane) - self.goals)[:, None]
        np.add.at(gradient.reshape(-1, 2), self._springs.corners, pulls)
        return gradient


def shepard_warp(plane: FloatArray, places: FloatArray, moves: FloatArray) -> FloatArray:
    """How far each point of ``plane`` (k, 2) goes along when ``places`` (p, 2), at least one, make ``moves`` (p, 2).

    For maps of about unit area: within a millionth a place counts as the pin's own.

    Cost: 0.1 ms for 5,000 points and a pin.
    """
    x, y = ((plane[:, axis, None] - places[:, axis]) ** 2 for axis in range(2))
    nearness = 1 / (x + y + 1e-12)
    nearness *= nearness
    return np.einsum("kp,pd->kd", nearness, moves) / nearness.sum(axis=1, keepdims=True)


_FARTHEST = 0.05
_NEAREST = 1e-3
"""Reach, in shares of the map's size: about four edges of 10,000 faces; where pins are in each other's way, less."""
_STEPS = 2
_REMEMBERED = 6
_AGED = 1e-3
"""A last step that still gains so much of the energy wants a new Hessian."""
_NEGLIGIBLE = 1e-4
"""Pulls and gains below this are left to the next round."""
_ROUNDING = 1e-13
"""Steps that promise less of the energy are lost in its rounding: how far they get says nothing about the reach."""

Barrier = Callable[[PinnedEnergy], Energy]


def _no_barrier(energy: PinnedEnergy) -> Energy:
    return energy


class PinDescent:
    """A map on its way. Mutable: ``plane`` (k, 2) is its present state, of about unit area and without flips.

    Args:
        plane: (k, 2) where to begin.
        barrier: What to add to the energy; nothing by default.
    """

    def __init__(self, plane: FloatArray, *, barrier: Barrier = _no_barrier) -> None:
        self.plane = plane
        self._barrier = barrier
        self._factor = SparseLDL()
        self._steps = list[tuple[FloatArray, FloatArray]]()
        self._reach = _FARTHEST
        self._aged = True
        self._shortest = 1.0

    @property
    def reach(self) -> float:
        """How far a round lets a pin pull."""
        return self._reach

    def forget(self) -> None:
        """The next round makes a new Hessian: other pins, or another energy."""
        self._aged = True

    def round(self, wanted: PinnedEnergy) -> float:
        """One round towards ``wanted``; how much its energy fell, 0 where no step was possible.

        Cost: at 10,000 faces 7 ms, with a new Hessian 18 ms.
        """
        places = wanted.places(self.plane)
        moves = wanted.goals - places
        lengths = np.linalg.norm(moves, axis=1, keepdims=True)
        moves = moves * np.minimum(1.0, self._reach / np.maximum(lengths, 1e-12))
        near = self._barrier(wanted.towards(places + moves))
        whole = self._barrier(wanted)
        before = whole.energy(self.plane)
        fresh = self._aged
        self._shortest = 1.0
        try:
            plane = self._descended(near, *self._pulled(near, places, moves))
        except MapError:  # a face is too thin for a step: the map stays as it is, and how far pins are behind is told
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
        """The map with the pins' moves spread over it, and its energy; as it was where that would not be lower."""
        energy = near.energy(self.plane)
        if not np.abs(moves).max(initial=0.0) > _NEGLIGIBLE:
            return self.plane, energy
        step = shepard_warp(self.plane, places, moves)
        moved = self.plane + min(1.0, 0.5 * near.largest_step(self.plane, step)) * step
        reached = near.energy(moved)
        return (moved, reached) if reached < energy else (self.plane, energy)

    def _descended(self, near: Energy, plane: FloatArray, energy: float) -> FloatArray:
        """A step of Newton's where the Hessian has aged, else a few with the last one."""
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
        """The gradient, and how many steps the Hessian is good for."""
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
        """A longer reach after easy steps, a shorter one after hard ones."""
        if not gain > 0:
            # With a fresh Hessian nothing is left to gain, or the pins pull too far; else the Hessian was too old.
            self._aged = not fresh
        if self._shortest < 0.25 or (fresh and not gain > 0):
            self._reach = max(_NEAREST, 0.5 * self._reach)
        elif self._shortest >= 0.5:
            self._reach = min(_FARTHEST, 1.5 * self._reach)
