"""A stroke between two events of the mouse: the finger goes there over the ticks between, as the hand did, in no leap.

Events come once a drawn frame, which may be as rare as ten times a second; a hand at 110 mm/s then is 11 mm farther on,
more than the finger is wide. Put there at once it would be another contact.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokeReleased

LEAP = 0.002
"""The finger may be put so far at once [m]: a quarter of its radius."""
LONGEST = 0.1
"""The finger lags behind the hand by no more than this [s]."""


class StrokePlan:
    """What fingers are still to do, tick by tick. Mutable; whoever shares it between threads guards it.

    A way that leaves the surface, or leads to another patch, is a leap as before: there is no skin between.

    Args:
        skin: What is stroked.
        tick: Seconds a tick.
    """

    def __init__(self, skin: Skin, tick: float) -> None:
        self._locator = SkinLocator(skin)
        self._most = max(round(LONGEST / tick), 1)
        self.clear()

    def clear(self) -> None:
        """Nothing is to be done, and nobody presses."""
        self._ways: dict[int, deque[SurfacePoint]] = {}
        self._at: dict[int, SurfacePoint] = {}
        self._told: dict[int, int] = {}
        self._until: dict[int, int] = {}
        self._lifts: set[int] = set()

    def take(self, poke: PokeInput, now: int) -> tuple[PokeInput, ...]:
        """What of ``poke`` is to be done at once; the rest is done by ``due`` at the ticks after ``now``."""
        if isinstance(poke, PokePressed):
            self._forget(poke.id)
            self._at[poke.id] = poke.at
            self._told[poke.id] = now
            return (poke,)
        if poke.id not in self._at:
            return (poke,)
        if isinstance(poke, PokeReleased):
            if self._ways.get(poke.id):
                self._lifts.add(poke.id)
                return ()
            self._forget(poke.id)
            return (poke,)
        return self._move(poke, now)

    def due(self, now: int) -> list[PokeInput]:
        """What is to be done at the tick after ``now``."""
        acts: list[PokeInput] = []
        for finger, way in list(self._ways.items()):
            count = math.ceil(len(way) / max(self._until[finger] - now, 1))
            at = [way.popleft() for _ in range(count)][-1]
            acts.append(PokeMoved(finger, at))
            if not way:
                del self._ways[finger]
                if finger in self._lifts:
                    acts.append(PokeReleased(finger))
                    self._forget(finger)
        return acts

    def _move(self, poke: PokeMoved, now: int) -> tuple[PokeInput, ...]:
        spent = min(now - self._told[poke.id], self._most)
        start = self._at[poke.id]
        self._at[poke.id] = poke.at
        self._told[poke.id] = now
        waiting = self._ways.get(poke.id)
        way = self._between(start, poke.at)
        if waiting is None and (len(way) == 1 or spent <= 1):
            return (poke,)
        self._ways.setdefault(poke.id, deque()).extend(way)
        self._until[poke.id] = now + max(spent, 1)
        return ()

    def _between(self, start: SurfacePoint, end: SurfacePoint) -> list[SurfacePoint]:
        """Places at most about ``LEAP`` apart, the last of them the end. Cost: 10 µs a place, once 10 ms a patch."""
        if start.patch != end.patch:
            return [end]
        first, last = (self._locator.skin.position(at) for at in (start, end))
        count = math.ceil(float(np.linalg.norm(last - first)) / LEAP)
        if count < 2:
            return [end]
        middle = np.linspace(first, last, count + 1)[1:-1]
        places = [self._locator.surface_point(start.patch, point) for point in middle]
        line = np.array([first, *(self._locator.skin.position(at) for at in places), last])
        leaves = np.linalg.norm(np.diff(line, axis=0), axis=1).max() > 3 * LEAP
        return [end] if leaves else [*places, end]

    def _forget(self, finger: int) -> None:
        self._lifts.discard(finger)
        for known in (self._ways, self._at, self._told, self._until):
            known.pop(finger, None)
