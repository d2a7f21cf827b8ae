"""Water-fill model: the solver's force distributed over the skin under the body, exact for any contact stiffness.

The skin is a bed of springs at the quadrature points (a Winkler foundation). A body with force F is as deep as the bed
requires: the depth d solves  sum K A_i max(0, d - g_i) = F,  where g_i is the distance of point i from the body minus
that of the closest point. This is like filling a basin with water and exact after a few steps. It uses the force rather
than a penetration, so it is never blind where hull and skin differ, and it is always stable.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, dot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.broadphase import LinkBroadphase, NearbyPoints, link_broadphases
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, border_notes, load_note
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField, cell_field
from tactile_maps.tactile.mechanics.winkler import winkler_level
from tactile_maps.tactile.models.shear import ShearModel

_LAYER = ElasticLayer()


class WaterFillModel:
    """Pressures on all taxels under rigid bodies. Built once for a skin.

    Force is conserved: with whole cells as receptive fields the sum of pressure times area is the sum of the loads'
    forces to rounding. Loads outside the skin are not measured but noted: next to the skin the bare surface of the link
    bears its share of a load, if the skin has ``bare_points``. The moment of the force about the contact is lost
    (see ``punch``); shear is distributed by ``shear`` if one is set.

    Error: see ``stated_errors``.

    Cost: 10 µs a ball with 1,000 taxels on an arm and 12 µs with 10,000, three to four bare steps of that arm; 11 and
    14 µs while it slides at 5 cm/s, with a search of 0.05 ms now and then. A box 35 to 75 µs, a mesh 0.1 to 0.5 ms.

    Args:
        skin: The skin.
        layer: The skin's cover; its foundation is the springs' stiffness per area.
        field: Receptive field of the taxels; whole cells by default.
    """

    def __init__(self, skin: Skin, *, layer: ElasticLayer = _LAYER, field: ReceptiveField | None = None) -> None:
        self.notes: tuple[ContactNote, ...] = ()
        self._count = len(skin)
        self._stiffness = layer.foundation
        self._field = cell_field(skin) if field is None else field
        self._beds = link_broadphases(skin)
        self.shear: ShearModel | None = None

    def pressures(self, loads: Sequence[Load]) -> FloatArray:
        """Return the mean pressure on each taxel (taxels,) [Pa]; loads add up."""
        pressures = np.zeros(self._count)
        self.notes = ()
        if self.shear is not None:
            self.shear.begin()
        for load in loads:
            if load.force > 0 and (bed := self._beds.get(load.link)) is not None:
                under = bed.near(load)
                points, forces = self._at_edge(bed, load) if under is None else self._distributed(bed, under, load)
                if self.shear is not None:
                    self.shear.add(load, points, forces)
                if under is not None and bed.has_bare:
                    points, forces = self._covered(bed, load, points, forces)
                self._field.add(pressures, points, forces)
        return pressures

    def _at_edge(self, bed: LinkBroadphase, load: Load) -> tuple[IntArray, FloatArray]:
        """Return the whole force on the closest point, because no point faces the body; none outside the skin."""
        point = bed.nearest(load)
        borne = [] if point is None or point >= bed.read else [point]
        kind = ContactNoteKind.SKIN_EDGE if borne else ContactNoteKind.OUTSIDE_SKIN
        self.notes += (load_note(kind, load.by, load.link),)
        return np.array(borne, dtype=np.int64), np.full(len(borne), load.force)

    def _distributed(self, bed: LinkBroadphase, under: NearbyPoints, load: Load) -> tuple[IntArray, FloatArray]:
        """Return the points under the body (k,) and the force on each (k,) [N]."""
        points, forces, level = distribute_force(under, load.force, self._stiffness)
        if level > under.search_radius:
            # Fewer points let the water rise higher, so it will not rise beyond this level again.
            under = bed.near(load, upto=level) or under
            points, forces, _ = distribute_force(under, load.force, self._stiffness)
        return points, forces

    def _covered(
        self, bed: LinkBroadphase, load: Load, points: IntArray, forces: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return the part of a load on points that taxels read, and note the share of bare points."""
        read = points < bed.read
        outside = float(forces[~read].sum())
        self.notes += border_notes(outside / load.force if read.any() else 1.0, load.by, load.link)
        return points[read], forces[read]


def distribute_force(under: NearbyPoints, force: float, stiffness: float) -> tuple[IntArray, FloatArray, float]:
    """Distribute a force over the points under a body by filling water between skin and body.

    Args:
        under: The points and their distances from the body, at least one not inf.
        force: Force [N], > 0.
        stiffness: Stiffness of the foundation [Pa/m].

    Returns:
        Points under water (k,), the force on each (k,) [N], and the level as a distance from the body [m].
    """
    wet = winkler_level(under.distances, under.areas, force / stiffness, guess=under.guess)
    forces = wet.level - wet.floors
    total = dot(forces, wet.areas)
    if total > 0:
        forces *= wet.areas
        forces *= force / total
    else:  # the volume rounds to 0: the first point bears the force
        forces[0] = force
    return under.points.take(wet.points), forces, wet.level
