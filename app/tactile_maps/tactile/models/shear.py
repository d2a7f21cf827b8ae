"""Shear on three-axis taxels: the friction of every contact distributed over the skin under the body.

A contact model distributes the normal force of a load over the quadrature points; ``ShearModel`` distributes its
tangential force and its torque over the same points, as a bed of springs with Coulomb sliders (``coulomb_bed``). The
springs are fixed to the skin: they keep their deflection while a contact lasts, and relax when a point loses contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind, load_note
from tactile_maps.tactile.mechanics.coulomb_bed import shear_bed
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.mechanics.plane_vectors import as_complex, as_vectors, plane_of, turned_into
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField, load_points, quadrature_points


@dataclass(frozen=True, eq=False)
class ShearLoad(ArrayFields):
    """Shear of the skin by a load, from the physics and without effects of the sensor.

    Attributes:
        load: The load.
        stuck: Share of the friction limit on points that stick, 0 to 1.
    """

    load: Load
    stuck: float

    @property
    def usage(self) -> float:
        """Tangential force over its limit, friction times normal force."""
        limit = self.load.friction * self.load.force
        return float(np.linalg.norm(self.load.shear)) / limit if limit > 0 else 0.0


class _Springs:
    """Tangential forces of the points under one body, at the last reading."""

    def __init__(self, points: IntArray, forces: FloatArray) -> None:
        order = points.argsort()
        self.points = points[order]
        self.forces = forces[order]

    def of(self, points: IntArray) -> FloatArray:
        """Return the forces (k, 3) on ``points`` (k,) [N], link frame; zero for points that were not touched."""
        rows = np.minimum(self.points.searchsorted(points), len(self.points) - 1)
        return np.where((self.points.take(rows) == points)[:, None], self.forces.take(rows, axis=0), 0.0)


class ShearModel:
    """Shear on all taxels. Mutable: it remembers the springs of the last reading; ``reset`` relaxes them.

    Forces are distributed in the plane of each load. On a curved skin they are turned into the plane of each taxel
    without a change of length, as the normal forces are, so that friction limits hold on every taxel and the sum of
    traction times area is the load's shear wherever the skin is flat under the body.

    Args:
        skin: The skin, with its bare points.
        layer: The skin's cover.
        field: Receptive field of the taxels, that of the contact model.
        frames: (taxels, 3, 3) axes t1, t2 and n of each taxel in its link's frame, as rows.

    Attributes:
        frames: The axes of the taxels; may be set between readings.
        tractions: (taxels, 2) traction of the touching bodies on each taxel along t1 and t2 [Pa], at the last reading.
        loads: How each load with friction shears the skin.
        notes: Loads whose friction the bed cannot transfer.

    Cost: 25 µs a load and the time of ``shear_bed``.
    """

    def __init__(self, skin: Skin, layer: ElasticLayer, field: ReceptiveField, frames: FloatArray) -> None:
        points = load_points(skin)
        self._positions = points.positions
        self._stiffness = layer.shear_foundation * points.areas
        self._read = len(quadrature_points(skin).areas)
        self._field = field
        self.frames = frames
        self.reset()

    def reset(self) -> None:
        """Relax all springs."""
        self._now: dict[tuple[str, str], list[tuple[IntArray, FloatArray]]] = {}
        self.begin()

    def resume(self, other: ShearModel) -> None:
        """Continue with the springs of another model of the same skin."""
        self._now = other._now

    def begin(self) -> None:
        """Begin a reading."""
        self._springs: dict[tuple[str, str], _Springs] = {
            key: _Springs(np.concatenate([points for points, _ in parts]), np.concatenate([own for _, own in parts]))
            for key, parts in self._now.items()
        }
        self._now = {}
        self.tractions = np.zeros((len(self.frames), 2))
        self.loads: tuple[ShearLoad, ...] = ()
        self.notes: tuple[ContactNote, ...] = ()

    def add(self, load: Load, points: IntArray, forces: FloatArray) -> None:
        """Distribute the friction of a load.

        Args:
            load: The load; nothing happens without friction.
            points: (k,) points that bear it, numbers of ``load_points``.
            forces: (k,) normal force on each [N].
        """
        if load.friction <= 0 or not len(points):
            return
        plane = plane_of(load.normal)
        offsets = as_complex((self._positions.take(points, axis=0) - load.point) @ plane)
        offsets -= (forces @ offsets) / forces.sum()
        key = load.link, load.by
        known = self._springs.get(key)
        before = np.zeros(len(points), dtype=np.complex128) if known is None else as_complex(known.of(points) @ plane)
        along = complex(*(load.shear @ plane).tolist())
        bed = shear_bed(
            before,
            load.friction * forces,
            self._stiffness.take(points),
            offsets,
            along,
            load.torque,
        )
        if not bed.matched:
            self.notes += (load_note(ContactNoteKind.FRICTION_EXCEEDED, load.by, load.link),)
        own = as_vectors(bed.forces)
        self._now.setdefault(key, []).append((points, own @ plane.T))
        self.loads += (ShearLoad(load, bed.stuck),)
        self._feel(load, plane, points, own)

    def numbers(self) -> FloatArray:
        """Return the complete state as one vector, for comparing runs."""
        parts = [part for stored in self._now.values() for points, own in stored for part in (points, own.ravel())]
        return np.concatenate([np.zeros(0), *parts])

    def _feel(self, load: Load, plane: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """Add the forces (k, 2) [N], in the plane of a load, to the tractions of the taxels that measure the points."""
        read = points < self._read
        points = points[read]
        sums = np.zeros((2, len(self.frames)))
        for total, part in zip(sums, forces[read].T, strict=True):
            self._field.add(total, points, part)
        taxels = np.flatnonzero(sums.any(axis=0))
        turns = turned_into(self.frames.take(taxels, axis=0), load.normal, plane)
        self.tractions[taxels] += as_vectors(turns * (sums[0].take(taxels) + 1j * sums[1].take(taxels)))
