"""Punch: the solver's force and its moment spread over the skin under the body, exact in both.

As water-fill, but the body may also tilt, like a stiff punch on a bed of springs, until the springs' force acts where
the solver says: an unknown depth and two tilts for one force and two coordinates of the centre of pressure.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.broadphase import LinkBroadphase, NearbyPoints
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, load_note
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField
from tactile_maps.tactile.mechanics.winkler import winkler_tilt
from tactile_maps.tactile.models.water_fill import WaterFillModel, distribute_force

_LAYER = ElasticLayer()
_SEARCHES = 3
_ROOM = 1.5
"""Springs are looked for up to this many times the depth at which the straight body would rest."""


class _Tilted(NamedTuple):
    """Points that bear the tilted body, the force on each [N], the closest and the farthest of them, if there are."""

    points: IntArray
    forces: FloatArray
    lowest: float
    highest: float
    matched: bool


class PunchModel(WaterFillModel):
    """Pressures on all taxels from what presses them. Built once for a skin.

    Force is conserved to rounding as by water-fill, and the centre of pressure of the forces on the quadrature points
    is the load's to 1e-10 m, along the plane of its normal. A load whose centre of pressure lies outside the points
    that its body can press, or with fewer than three points under it, is spread as water-fill does, and ``notes`` say
    so; so it may be below 0.1 mN, where rounding hides the tilt.

    Lost: shear. What taxels say of the centre is coarser: they know only the sums over their cells.

    Args:
        skin: The skin.
        layer: Its foundation is the springs' stiffness per area.
        field: What each taxel feels; its whole cell by default.

    Cost: 0.1 ms a load more than water-fill for some dozen points, 0.5 ms for two thousand: 2 to 7 Newton steps.
    """

    def __init__(self, skin: Skin, *, layer: ElasticLayer = _LAYER, field: ReceptiveField | None = None) -> None:
        super().__init__(skin, stiffness=layer.foundation, field=field)

    def _press(self, bed: LinkBroadphase, load: Load, pressures: FloatArray) -> None:
        under = bed.near(load)
        if under is None or not self._press_tilted(bed, under, load, pressures):
            super()._press(bed, load, pressures)
            if under is not None:
                self.notes += (load_note(ContactNoteKind.MOMENT_IGNORED, load.by, load.link),)

    def _press_tilted(self, bed: LinkBroadphase, under: NearbyPoints, load: Load, pressures: FloatArray) -> bool:
        """Whether force and moment could be matched; nothing is added otherwise."""
        tilted = self._tilted(under, load)
        for _ in range(_SEARCHES):
            if tilted.highest <= under.search_radius:
                break
            under = bed.near(load, upto=tilted.lowest + _ROOM * (tilted.highest - tilted.lowest)) or under
            tilted = self._tilted(under, load)
        if tilted.matched:
            self._read(bed, load, pressures, tilted.points, tilted.forces, bare=under.bare)
        return tilted.matched

    def _tilted(self, under: NearbyPoints, load: Load) -> _Tilted:
        facing = np.flatnonzero(np.isfinite(under.distances))
        gaps = under.distances[facing]
        areas = under.areas[facing]
        offsets = np.einsum("ij,jk->ik", under.positions[facing] - load.point, _across(load.normal))
        level = distribute_force(under, load.force, self._stiffness)[2]
        lowest = float(gaps.min())
        balance = winkler_tilt(gaps - lowest, areas, offsets, load.force / self._stiffness, level=level - lowest)
        pressed = np.flatnonzero(balance.borne)
        if not balance.matched:
            return _Tilted(facing[:0], gaps[:0], lowest, level, False)
        borne = balance.borne[pressed]
        highest = max(level, float(gaps[pressed].max()))
        return _Tilted(under.points[facing[pressed]], borne * (load.force / borne.sum()), lowest, highest, True)


def _across(normal: FloatArray) -> FloatArray:
    """(3, 2) two unit vectors across ``normal`` and each other."""
    helper = np.zeros(3)
    helper[np.abs(normal).argmin()] = 1.0
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first)])
