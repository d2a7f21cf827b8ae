"""What contacts of one model did between two readings of the skin: too deep, too hard, or over before they were felt.

Readings come once a tick and show the last step's contacts. ``ContactWatch`` looks at every step, so that none of the
others goes untold.
"""

from __future__ import annotations

from typing import TypeAlias

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.simulation.model.model_names import is_object, plain_name
from tactile_maps.simulation.model.piece_contacts import piece_groups
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

DEEPEST = 0.010
"""How far one body may be in another untold [m]: no cover yields by more."""
HARDEST = 5e3
"""Normal force of a contact that is told [N]: nothing that wears skin bears more."""
_SLOW = 1e-3
"""What moves less than this in a tick [m, rad] is as deep at its end as between."""
_LIGHT = 50.0
"""Forces on joints [N, N m] that no hard contact makes so small: a lever of 1 cm."""
Geoms: TypeAlias = tuple[int, int]


class ContactWatch:
    """Watches one model's contacts step by step. Mutable: what it found since ``begin``.

    Args:
        model: The compiled model.
        data: Its state.
        skin: Whose links feel.
        layer: Its cover.
        averages: Whether a reading counts what was over before it, so that nothing is missed.

    Attributes:
        needed: Whether anything may touch.

    Cost: 0.7 µs a step, and 4 µs a tick in contact; these 4 µs a step where something is fast, hard or comes and goes.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, skin: Skin, layer: ElasticLayer, *, averages: bool = False
    ) -> None:
        self._model = model
        self._data = data
        self._qvel = data.qvel
        self._pushes = data.qfrc_constraint
        self.needed = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
        links = {int(model.body(patch.link).id) for patch in skin.patches}
        self._feels = [int(body) in links for body in model.geom_bodyid]
        self._averages = averages
        self._groups = np.array(piece_groups(model), dtype=np.int64)
        self.start()

    def start(self) -> None:
        """Nothing has touched yet."""
        self._now: frozenset[Geoms] = frozenset()
        self._pairs = b""
        self._count = 0
        self.begin(1)

    def begin(self, steps: int) -> None:
        """A tick of so many steps begins: what touches now was read at the last one."""
        self._before = self._now
        self._met = self._now
        self._slow = (_SLOW / (steps * self._model.opt.timestep)) ** 2
        self._deep: dict[Geoms, float] = {}
        self._hard: dict[Geoms, float] = {}

    def look(self) -> None:
        """After a step: nothing where all is as it was, slow and light."""
        if (
            self._data.ncon != self._count
            or mujoco.mju_dot(self._qvel, self._qvel) > self._slow
            or mujoco.mju_dot(self._pushes, self._pushes) > _LIGHT**2
        ):
            self.inspect()

    def inspect(self) -> None:
        """What the contacts of the last step were: the last of a tick at least."""
        data = self._data
        self._count = data.ncon
        if not data.ncon:
            if self._now:
                self._now = frozenset()
                self._pairs = b""
            return
        contact = data.contact
        depths = data.contact.dist
        pairs = contact.geom.tobytes()
        if pairs != self._pairs:
            self._pairs = pairs
            self._now = frozenset(_geoms(self._groups[contact.geom].tolist()))
            self._met |= self._now
        if depths.min() < -DEEPEST:
            self._keep_largest(self._deep, self._groups[contact.geom], -depths, DEEPEST)
        if data.nefc and data.efc_force.max() > HARDEST:
            self._keep_largest(self._hard, self._groups[contact.geom], self._forces(data), HARDEST)

    def _forces(self, data: mujoco.MjData) -> FloatArray:
        """(contacts,) normal forces [N]."""
        rows = data.contact.efc_address
        return np.asarray(np.where(rows >= 0, data.efc_force[np.maximum(rows, 0)], 0.0))

    @property
    def notes(self) -> tuple[ContactNote, ...]:
        """What is to be told of the steps since ``begin``."""
        deep = [self._note(ContactNoteKind.DEEP, geoms, depth=depth) for geoms, depth in self._deep.items()]
        hard = [self._note(ContactNoteKind.HARD, geoms, force=force) for geoms, force in self._hard.items()]
        gone = [] if self._averages else sorted(self._met - self._before - self._now)
        missed = [self._note(ContactNoteKind.BRIEF, geoms) for geoms in gone if any(self._feels[k] for k in geoms)]
        return (*deep, *hard, *missed)

    def _note(
        self, kind: ContactNoteKind, geoms: Geoms, *, depth: float | None = None, force: float | None = None
    ) -> ContactNote:
        bodies = [self._model.body(int(self._model.geom_bodyid[geom])).name for geom in geoms]
        presses_first = sorted(bodies, key=is_object, reverse=True)
        return ContactNote(kind, tuple(map(plain_name, presses_first)), depth=depth, force=force)

    @staticmethod
    def _keep_largest(found: dict[Geoms, float], geoms: np.ndarray, values: FloatArray, above: float) -> None:
        for pair, value in zip(_geoms(geoms.tolist()), values.tolist(), strict=True):
            if value > max(above, found.get(pair, 0.0)):
                found[pair] = value


def _geoms(rows: list[list[int]]) -> list[Geoms]:
    return [(min(row), max(row)) for row in rows]
