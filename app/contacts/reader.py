"""Contact regions read from taxel pressures: found on the skin's own graph, placed by the map, followed in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from app.arrays import BoolArray, FloatArray, IntArray
from app.contacts.region import ContactRegion
from app.geometry.closest import ClosestPoint
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap

THRESHOLD = 1000.0
"""Pressure at which a taxel counts as touched [Pa]; real skins start at 2-3 kPa."""
_RELEASE = 0.5
_TORN = 2.0


@dataclass(frozen=True)
class _Seen:
    """A region of the last frame, for recognising it."""

    id: int
    taxels: frozenset[int]


class ContactReader:
    """Finds contact regions frame by frame. Mutable: it remembers which taxels were touched and which region is which.

    Regions are connected on the body (the skin's neighbours), so a seam never splits one. The untouched ring around a
    region is added before summing: what lies below the threshold there is 8 to 20 % of the force.

    Args:
        map_: The tactile map.
        threshold: A taxel is touched from here [Pa] and stays so down to half of it.

    Cost: 20 µs when nothing is touched, about 0.15 ms a region otherwise.
    """

    def __init__(self, map_: TactileMap, *, threshold: float = THRESHOLD) -> None:
        self._map, self._threshold = map_, threshold
        skin = map_.skin
        self._pairs, count = skin.neighbours, len(skin)
        both = np.concatenate([self._pairs, self._pairs[:, ::-1]])
        self._graph = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count)).tocsr()
        body = np.concatenate([patch.taxels.positions for patch in skin.patches])
        self._body = body
        on_body = np.linalg.norm(body[self._pairs[:, 0]] - body[self._pairs[:, 1]], axis=1)
        points = map_.taxel_points
        on_map = np.linalg.norm(points[self._pairs[:, 0]] - points[self._pairs[:, 1]], axis=1)
        self._torn = on_map > _TORN * on_body
        self._closest = [ClosestPoint(patch.surface) for patch in skin.patches]
        self.reset()

    def reset(self) -> None:
        """Forget what was touched; ids start at 1 again."""
        self._touched = np.zeros(len(self._map.skin), dtype=bool)
        self._seen: list[_Seen] = []
        self._next = 1

    def read(self, pressures: FloatArray) -> tuple[ContactRegion, ...]:
        """The regions touched now, the strongest first.

        Args:
            pressures: (taxels,) [Pa], >= 0.
        """
        level = np.where(self._touched, _RELEASE * self._threshold, self._threshold)
        self._touched = np.asarray(pressures) >= level
        touched = np.flatnonzero(self._touched)
        if not len(touched):
            self._seen = []
            return ()
        _, label = connected_components(self._graph[touched][:, touched], directed=False)
        cores = [touched[label == k] for k in range(label.max() + 1)]
        ids = self._identify(cores)
        regions = [self._region(number, core, pressures) for number, core in zip(ids, cores, strict=True)]
        return tuple(sorted(regions, key=lambda region: (-region.force, region.id)))

    def _identify(self, cores: list[IntArray]) -> list[int]:
        """Ids for the regions: the largest overlap with an old region keeps its id, the others are new."""
        sets = [frozenset(core.tolist()) for core in cores]
        shared = sorted(
            ((len(s & old.taxels), -k, old.id) for k, s in enumerate(sets) for old in self._seen), reverse=True
        )
        ids: dict[int, int] = {}
        for overlap, negative, number in shared:
            if overlap and -negative not in ids and number not in ids.values():
                ids[-negative] = number
        for k in range(len(sets)):
            if k not in ids:
                ids[k] = self._next
                self._next += 1
        self._seen = [_Seen(ids[k], taxels) for k, taxels in enumerate(sets)]
        return [ids[k] for k in range(len(sets))]

    def _region(self, number: int, core: IntArray, pressures: FloatArray) -> ContactRegion:
        ring = self._with_ring(core)
        forces = pressures[ring] * self._map.skin.areas[ring]
        at = self._centre(ring, forces)
        skin = self._map.skin
        return ContactRegion(
            id=number,
            taxels=ring,
            force=float(forces.sum()),
            area=float(skin.areas[core].sum()),
            peak=float(pressures[core].max()),
            map_point=self._map.to_map(at),
            at=at,
            link=skin.link(at),
            point=skin.position(at),
            normal=skin.normal(at),
        )

    def _with_ring(self, core: IntArray) -> IntArray:
        """The region and its neighbours that are not themselves touched (those belong to another region)."""
        marked = np.zeros(len(self._touched), dtype=bool)
        marked[self._graph[core].indices] = True
        marked &= ~self._touched
        marked[core] = True
        return np.flatnonzero(marked)

    def _centre(self, taxels: IntArray, forces: FloatArray) -> SurfacePoint:
        """Centre of pressure, taken on the map and back-projected with the containing triangle.

        On the map it stays on the surface; a mean in space sinks below it (by 0.5 mm at 10 mm half-width on a 36 mm
        tube). Only where a seam tears the region apart on the map is the mean taken in space, and put back on the skin.
        """
        share = forces / forces.sum()
        if not self._is_torn(taxels):
            at = self._map.to_body(share @ self._map.taxel_points[taxels])
            if at is not None:
                return at
        strongest = self._map.skin.patch_of[taxels[np.argmax(forces)]]
        own = self._map.skin.patch_of[taxels] == strongest
        middle = (share[own] @ self._body[taxels[own]]) / share[own].sum()
        faces, weights, _ = self._closest[int(strongest)].query(middle[None])
        a, b, c = weights[0]
        return SurfacePoint(int(strongest), int(faces[0]), (float(a), float(b), float(c)))

    def _is_torn(self, taxels: IntArray) -> bool:
        member: BoolArray = np.zeros(len(self._touched), dtype=bool)
        member[taxels] = True
        return bool((self._torn & member[self._pairs].all(axis=1)).any())
