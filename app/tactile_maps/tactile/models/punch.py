"""Punch model: the solver's force and moment distributed over the skin under the body, exact in both.

It is water-fill with tilt: the body tilts like a stiff punch on a bed of springs until the force of the springs acts at
the solver's place. The unknowns are a depth and two tilts, for one force and two coordinates of the centre of pressure.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.tactile.mechanics.broadphase import LinkBroadphase, NearbyPoints
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, load_note
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.plane_vectors import plane_of
from tactile_maps.tactile.mechanics.winkler import winkler_tilt
from tactile_maps.tactile.models.water_fill import WaterFillModel, distribute_force

_SEARCHES = 3
_ROOM = 1.5
"""Search range of springs in multiples of the depth of the body without tilt."""


class _Tilted(NamedTuple):
    """Points under the tilted body, the force on each [N], and the smallest and largest of their distances [m]."""

    points: IntArray
    forces: FloatArray
    lowest: float
    highest: float
    matched: bool


class PunchModel(WaterFillModel):
    """Pressures on all taxels under tilted bodies. Built once for a skin.

    Force is conserved to rounding as by water-fill, and the centre of pressure of the forces on the quadrature points
    is the load's to 1e-10 m, along the plane of its normal. A load whose centre of pressure is outside the points
    under its body, or with fewer than three points under it, is distributed by water-fill and noted; this may also
    happen below 0.1 mN, where rounding hides the tilt.

    The centre of the readings is coarser, because taxels measure sums over their cells.

    Cost: 0.1 ms a load more than water-fill for some dozen points, 0.5 ms for two thousand: 2 to 7 Newton steps.
    """

    def _distributed(self, bed: LinkBroadphase, under: NearbyPoints, load: Load) -> tuple[IntArray, FloatArray]:
        near = under
        tilted = self._tilted(near, load)
        for _ in range(_SEARCHES):
            if tilted.highest <= near.search_radius:
                break
            near = bed.near(load, upto=tilted.lowest + _ROOM * (tilted.highest - tilted.lowest)) or near
            tilted = self._tilted(near, load)
        if not tilted.matched:
            points, forces = super()._distributed(bed, under, load)
            self.notes += (load_note(ContactNoteKind.MOMENT_IGNORED, load.by, load.link),)
            return points, forces
        return tilted.points, tilted.forces

    def _tilted(self, under: NearbyPoints, load: Load) -> _Tilted:
        facing = np.flatnonzero(np.isfinite(under.distances))
        gaps = under.distances[facing]
        areas = under.areas[facing]
        offsets = np.einsum("ij,jk->ik", under.positions[facing] - load.point, plane_of(load.normal))
        level = distribute_force(under, load.force, self._stiffness)[2]
        lowest = float(gaps.min())
        balance = winkler_tilt(gaps - lowest, areas, offsets, load.force / self._stiffness, level=level - lowest)
        pressed = np.flatnonzero(balance.borne)
        if not balance.matched:
            return _Tilted(facing[:0], gaps[:0], lowest, level, False)
        borne = balance.borne[pressed]
        highest = max(level, float(gaps[pressed].max()))
        return _Tilted(under.points[facing[pressed]], borne * (load.force / borne.sum()), lowest, highest, True)
