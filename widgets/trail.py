"""Where the contact that a task is about was in the last seconds; without Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.contacts.region import ContactRegion
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from widgets.task_shown import TAIL_SECONDS, Tail

_STEP = 0.0005
"""Places nearer than this are one [m]."""
_TORN, _NEAR = 2.0, 0.002
"""A step on the map so many times longer than on the body, and this much [m], leads over a seam."""
_GAP = 0.5
"""Between two frames, a longer time than this is a jump in a replay [s]."""


class Trail:
    """Follows one contact. Mutable; ``reset`` forgets all.

    Attributes:
        contact: Id of the region followed; 0 for none.
        tail: For drawing; the very same object as long as nothing changes.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No contact was anywhere."""
        self._ats: list[SurfacePoint] = []
        self._times: FloatArray = np.zeros(0)
        self._time, self.contact, self.tail = -np.inf, 0, Tail()

    def show_map(self, map_: TactileMap) -> None:
        """The same places on another map. Cost: 20 µs each."""
        if self._ats:
            tail, on_map = self.tail, np.array([map_.to_map(at) for at in self._ats])
            self.tail = replace(tail, on_map=on_map, starts=tail.starts | _torn(tail.patch, on_map, tail.on_body))

    def follow(self, time: float, regions: Sequence[ContactRegion], map_: TactileMap) -> None:
        """One more frame: the contact known from before goes on, else the strongest is followed.

        Args:
            time: Simulated [s]; back, or far on, it is a jump, and what was is forgotten.
            regions: The strongest first.
            map_: That is shown.

        Cost: 60 µs while the contact moves.
        """
        if not self._time <= time <= self._time + _GAP:
            self.reset()
        self._time = time
        region = next((one for one in regions if one.id == self.contact), regions[0] if regions else None)
        new = region is not None and region.id != self.contact
        self.contact = 0 if region is None else region.id
        if region is not None and (new or not self._rests(region)):
            self._take(region, map_, new=new)
        elif region is not None:
            self._times = np.append(self._times[:-1], time)  # the same place, just now
        self._age()

    def _rests(self, region: ContactRegion) -> bool:
        if not self._ats or self._ats[-1].patch != region.at.patch:
            return False
        return bool(np.linalg.norm(region.point - self.tail.on_body[-1]) < _STEP)

    def _take(self, region: ContactRegion, map_: TactileMap, *, new: bool) -> None:
        self._ats.append(region.at)
        self._times = np.append(self._times, self._time)
        old = self.tail
        patch = np.append(old.patch, region.at.patch)
        on_map, on_body = np.vstack([old.on_map, map_.to_map(region.at)]), np.vstack([old.on_body, region.point])
        starts = np.append(old.starts, new) | _torn(patch, on_map, on_body)
        self.tail = Tail(patch, on_map, on_body, np.vstack([old.normals, region.normal]), np.append(old.age, 0), starts)

    def _age(self) -> None:
        """Forget what is too old; what is left has aged."""
        gone = int(np.searchsorted(self._times, self._time - TAIL_SECONDS))
        if gone:
            self._ats, self._times, self.tail = self._ats[gone:], self._times[gone:], self.tail.without_oldest(gone)
        if len(self._ats) > 1:
            self.tail = replace(self.tail, age=(self._time - self._times) / TAIL_SECONDS)


def _torn(patch: IntArray, on_map: FloatArray, on_body: FloatArray) -> BoolArray:
    """(k,) whether the way to each place from the one before is no line on the map; not to the first."""
    steps, apart = (np.linalg.norm(np.diff(places, axis=0), axis=1) for places in (on_map, on_body))
    torn = (np.diff(patch) != 0) | (steps > _TORN * (apart + _NEAR))
    return np.concatenate([np.zeros(min(len(patch), 1), bool), torn])
