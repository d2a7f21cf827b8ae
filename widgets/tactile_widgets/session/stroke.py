"""Interpolation of finger motion between two mouse events over the ticks between them.

Mouse events arrive once per drawn frame, at times only ten times a second. A hand at 110 mm/s then has moved 11 mm,
more than the width of the finger; without interpolation the finger would make a new contact there.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.tactile.poke import PokeInput, PokeMoved, PokePressed, PokePulled, PokeReleased

LEAP = 0.002
"""Longest step of the finger within one tick [m]: a quarter of its radius."""
LONGEST = 0.1
"""Maximum lag of the finger behind the hand [s]."""


class StrokePlan:
    """Finger motion of the next ticks. Mutable; not thread-safe.

    Motion that leaves the surface, or leads to another patch, is not interpolated, because no skin is in between.

    Args:
        skin: The skin.
        tick: Duration of a tick [s].
    """

    def __init__(self, skin: Skin, tick: float) -> None:
        self._locator = SkinLocator(skin)
        self._most = max(round(LONGEST / tick), 1)
        self.clear()

    def clear(self) -> None:
        """Forget all fingers."""
        self._ways: dict[int, deque[SurfacePoint]] = {}
        self._at: dict[int, SurfacePoint] = {}
        self._last_event: dict[int, int] = {}
        self._until: dict[int, int] = {}
        self._lifts: set[int] = set()

    def take(self, poke: PokeInput, now: int) -> tuple[PokeInput, ...]:
        """Return the part of ``poke`` to apply at once; ``due`` returns the rest at the ticks after ``now``."""
        if isinstance(poke, PokePressed):
            self._forget(poke.id)
            self._at[poke.id] = poke.at
            self._last_event[poke.id] = now
            return (poke,)
        if poke.id not in self._at or isinstance(poke, PokePulled):  # its friction makes it slide step by step
            return (poke,)
        if isinstance(poke, PokeReleased):
            if self._ways.get(poke.id):
                self._lifts.add(poke.id)
                return ()
            self._forget(poke.id)
            return (poke,)
        return self._move(poke, now)

    def due(self, now: int) -> list[PokeInput]:
        """Return the inputs for the tick after ``now``."""
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
        spent = min(now - self._last_event[poke.id], self._most)
        start = self._at[poke.id]
        self._at[poke.id] = poke.at
        self._last_event[poke.id] = now
        waiting = self._ways.get(poke.id)
        way = self._between(start, poke.at)
        if waiting is None and (len(way) == 1 or spent <= 1):
            return (poke,)
        self._ways.setdefault(poke.id, deque()).extend(way)
        self._until[poke.id] = now + max(spent, 1)
        return ()

    def _between(self, start: SurfacePoint, end: SurfacePoint) -> list[SurfacePoint]:
        """Return points about ``LEAP`` apart, ending at ``end``. Cost: 10 µs per point, once 10 ms per patch."""
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
        for known in (self._ways, self._at, self._last_event, self._until):
            known.pop(finger, None)
