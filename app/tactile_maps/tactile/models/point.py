"""Point model: all of a load's force on the nearest taxel. The simplest model, for comparison with the others."""

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
from tactile_maps.tactile.models.shear import ShearModel

_TIP = Sphere(0.0)


class PointModel:
    """Pressures on all taxels as if every body were a needle. Built once for a skin.

    Force is conserved, as in ``WaterFillModel``. The body's shape is lost, so that one taxel bears the force of ten.

    Error: see ``stated_errors``.

    Cost: 10 µs a load, with 100 taxels or 10,000.

    Args:
        skin: The skin.
        field: Receptive field of the taxels; whole cells by default.
    """

    def __init__(self, skin: Skin, *, field: ReceptiveField | None = None) -> None:
        self.notes: tuple[ContactNote, ...] = ()
        self._count = len(skin)
        self._field = cell_field(skin) if field is None else field
        self._beds = link_broadphases(skin)
        self.shear: ShearModel | None = None

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """Return the mean pressure on each taxel (taxels,) [Pa]; loads add up."""
        pressures = np.zeros(self._count)
        notes = []
        if self.shear is not None:
            self.shear.begin()
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
                points = np.array([point])
                force = np.array([load.force])
                if self.shear is not None:
                    self.shear.add(load, points, force)
                self._field.add(pressures, points, force)
        self.notes = tuple(notes)
        return pressures


def _closest_facing(bed: LinkBroadphase, load: Load) -> int | None:
    """Return the facing point nearest to the load's point.

    If the load's point is outside the skin, the point nearest to its body bears it, as in the other models. None if the
    body is outside the skin as well, or no point faces it.
    """
    needle = Load(load.link, load.point, load.normal, load.force, _TIP, Pose(load.pose.rotation, load.point))
    under = bed.near(needle) or bed.near(load)
    return None if under is None else int(under.points[under.distances.argmin()])
