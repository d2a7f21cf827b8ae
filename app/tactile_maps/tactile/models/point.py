"""Point: all of a load's force on the one taxel nearest to it. The cheapest model, for teaching what the others add."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.broadphase import LinkBroadphase, link_broadphases
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, load_note
from tactile_maps.tactile.mechanics.loads import Load, Sphere
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField, cell_field

_TIP = Sphere(0.0)


class PointModel:
    """Pressures on all taxels from what presses them, as if everything were a needle. Built once for a skin.

    Force is conserved, as in ``WaterFillModel``. Lost: the body's shape, so that one taxel feels what ten should.

    Error: see ``stated_errors``.

    Cost: 10 µs a load, with 100 taxels or 10,000.

    Args:
        skin: The skin.
        field: What each taxel feels; its whole cell by default.
    """

    def __init__(self, skin: Skin, *, field: ReceptiveField | None = None) -> None:
        self.notes: tuple[ContactNote, ...] = ()
        self._count = len(skin)
        self._field = cell_field(skin) if field is None else field
        self._beds = link_broadphases(skin)

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """(taxels,) mean pressure that each taxel feels [Pa]; loads add up."""
        pressures = np.zeros(self._count)
        notes = []
        for load in loads:
            if load.force > 0 and (bed := self._beds.get(load.link)) is not None:
                point = _closest_facing(bed, load)
                edge = point is None
                if point is None:
                    point = bed.nearest(load)
                if point is None or point >= bed.read:
                    notes.append(load_note(ContactNoteKind.OUTSIDE_SKIN, load.by, load.link))
                    continue
                if edge:
                    notes.append(load_note(ContactNoteKind.SKIN_EDGE, load.by, load.link))
                self._field.add(pressures, np.array([point]), np.array([load.force]))
        self.notes = tuple(notes)
        return pressures


def _closest_facing(bed: LinkBroadphase, load: Load) -> int | None:
    """Return the number of the point nearest to the load's of those that face it.

    Where the load's point is beside the skin, the point nearest to its body bears it, as in the other models. None
    where the body is beside the skin as well, or no point faces it.
    """
    needle = Load(load.link, load.point, load.normal, load.force, _TIP, Pose(load.pose.rotation, load.point))
    under = bed.near(needle) or bed.near(load)
    return None if under is None else int(under.points[under.distances.argmin()])
