"""A map that follows its pins: with all its faces, or, where those are too many for a frame, carried by a stand-in."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.maps.carried_energy import CarriedEnergy
from app.maps.newton import Energy
from app.maps.pin_descent import PinDescent
from app.maps.pinned_energy import PinnedEnergy, Springs
from app.maps.proxy import Proxy
from app.maps.symmetric_dirichlet import SymmetricDirichlet

_A_FRAME = 8000
"""Faces for which there is time for one round a frame; smaller patches take more rounds to catch up with far pins."""
_MOST_ROUNDS = 6
_STILL = 1e-6
_THERE = 1e-3
"""Nearer, in shares of the map's size, a pin is where it is wanted to the eye."""


class PinFollower:
    """Mutable: the map and its pins. Planes and goals are in units in which the map's area is about one.

    Args:
        problem: The energy of stretching.
        plane: (k, 2) a map without flips.
        proxy: A stand-in made from that map, to follow by; None to follow with all faces.
    """

    def __init__(self, problem: SymmetricDirichlet, plane: FloatArray, *, proxy: Proxy | None = None) -> None:
        self._proxy, self._faces = proxy, len(problem.faces)
        self._energy: Energy = problem if proxy is None else CarriedEnergy(problem, proxy.carried)
        self._descent = PinDescent(plane if proxy is None else plane[proxy.chosen])
        self.pin(np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 2)))
        self._still = True

    @property
    def plane(self) -> FloatArray:
        """(k, 2) the present map, without flips."""
        moved = self._descent.plane
        return moved if self._proxy is None else np.asarray(self._proxy.carried @ moved)

    @property
    def energy(self) -> float:
        """Of stretching and of the springs."""
        return self._pinned.energy(self._descent.plane)

    @property
    def still(self) -> bool:
        """Whether another frame would show nothing new."""
        return self._still

    def pin(self, corners: IntArray, weights: FloatArray, goals: FloatArray) -> None:
        """Be held there from now on: (p, 3) vertices of faces, (p, 3) weights in them, (p, 2) where on the plane."""
        if self._proxy is not None:
            corners, weights = self._proxy.held(corners, weights)
        self._pinned, self._still = PinnedEnergy(self._energy, Springs(corners, weights), goals), False
        self._descent.forget()

    def aim(self, goals: FloatArray) -> None:
        """Want the pins at ``goals`` (p, 2)."""
        self._pinned, self._still = self._pinned.towards(goals), False

    def frame(self) -> None:
        """Follow the pins for about a frame's time; ``energy`` never rises."""
        for _ in range(max(1, min(_MOST_ROUNDS, _A_FRAME // self._faces))):
            gain = self._descent.round(self._pinned)
            self._still = gain <= _STILL * self.energy
            behind = np.linalg.norm(self._pinned.places(self._descent.plane) - self._pinned.goals, axis=1)
            if self._still or behind.max(initial=0.0) <= _THERE:
                return
