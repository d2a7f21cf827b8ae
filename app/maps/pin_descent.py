"""Rounds of a descent after moving pins: each short enough for a frame, never uphill, never over a flip.

Three things keep a frame short and the map healthy. Pins are followed in reaches: a far goal is approached by a nearer
one, so that no face is crushed on the way to it; the reach grows and shrinks with the steps that are possible. The
first part of a move is spread smoothly (``pull``). And a factored Hessian serves for several frames: a moved pin does
not change it, and quasi-Newton steps follow what the map's own change does, until their gain or their length says that
it has aged.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from app.arrays import FloatArray, dot
from app.errors import MapError
from app.geometry.factor import Factor
from app.maps.newton import Energy, line_search, quasi_newton, refactor
from app.maps.pinned_energy import PinnedEnergy
from app.maps.pull import spread

_FARTHEST, _NEAREST = 0.05, 1e-3
"""Reach, in shares of the map's size: about four edges of 10,000 faces; where pins are in each other's way, less."""
_STEPS, _REMEMBERED = 2, 6
_AGED = 1e-3
"""A last step that still gains so much of the energy wants a new Hessian."""
_NEGLIGIBLE = 1e-4
"""Pulls and gains below this are left to the next round."""

Barrier = Callable[[PinnedEnergy], Energy]


def _none(energy: PinnedEnergy) -> Energy:
    return energy


class PinDescent:
    """A map on its way. Mutable: ``plane`` (k, 2) is its present state, of about unit area and without flips.

    Args:
        plane: (k, 2) where to begin.
        barrier: What to add to the energy; nothing by default.
    """

    def __init__(self, plane: FloatArray, *, barrier: Barrier = _none) -> None:
        self.plane, self._barrier = plane, barrier
        self._factor, self._steps, self._reach = Factor(), list[tuple[FloatArray, FloatArray]](), _FARTHEST
        self._aged, self._shortest = True, 1.0

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
        near, whole = self._barrier(wanted.towards(places + moves)), self._barrier(wanted)
        before, fresh, self._shortest = whole.energy(self.plane), self._aged, 1.0
        try:
            plane = self._descended(near, *self._pulled(near, places, moves))
        except MapError:  # a face is too thin for a step: the map stays as it is, and how far pins are behind is told
            self._aged, self._reach = True, max(_NEAREST, 0.5 * self._reach)
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
        step = spread(self.plane, places, moves)
        moved = self.plane + min(1.0, 0.5 * near.largest_step(self.plane, step)) * step
        reached = near.energy(moved)
        return (moved, reached) if reached < energy else (self.plane, energy)

    def _descended(self, near: Energy, plane: FloatArray, energy: float) -> FloatArray:
        """A step of Newton's where the Hessian has aged, else a few with the last one."""
        gradient, count = self._prepared(near, plane)
        gain = 0.0
        for _ in range(count):
            step = -quasi_newton(self._factor, self._steps, gradient).reshape(-1, 2)
            after, reached, length = line_search(near, plane, step, energy, dot(gradient, step.ravel()))
            self._shortest = min(self._shortest, length)
            if length == 0:
                break
            gain, new = energy - reached, near.gradient(after)
            self._remember((after - plane).ravel(), new - gradient)
            plane, energy, gradient = after, reached, new
            if gain <= _NEGLIGIBLE * max(energy - 4, 1e-9):
                return plane
        self._aged = self._shortest < 0.3 or (count > 1 and gain > _AGED * max(energy - 4, 1e-9))
        return plane

    def _prepared(self, near: Energy, plane: FloatArray) -> tuple[FloatArray, int]:
        """The gradient, and how many steps the Hessian is good for."""
        if not self._aged:
            return near.gradient(plane), _STEPS
        gradient, hessian = near.derivatives(plane)
        refactor(self._factor, hessian)
        self._steps, self._aged = [], False
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
