"""Notes on contacts between two readings of the skin: too deep, too hard, or too short to be read; and on fast bodies.

The skin is read once per tick, with the contacts of the last step. ``ContactWatch`` checks every step, so that the
contacts of the other steps are reported as well. A contact that is too stiff for its time step throws a light body out;
the speed that it gives is reported, because the force on so light a body is small.
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

DEEPEST = 0.010
"""Penetration depth from which a contact is noted [m]: no cover yields by more."""
HARDEST = 5e3
"""Normal force from which a contact is noted [N]: no robot with skin bears more."""
FASTEST = 50.0
"""Speed from which a body is noted [m/s]: no robot throws or strikes faster."""
_SLOW = 1e-3
"""Motion per tick [m, rad] below which the depth at the end of the tick is that of all its steps."""
_LIGHT = 50.0
"""Constraint forces on joints [N, N m] below which no contact is too hard, at a lever of 1 cm."""
Geoms: TypeAlias = tuple[int, int]


class ContactWatch:
    """Checks the contacts of one model after every step. Mutable: it collects findings since ``begin``.

    Args:
        model: The compiled model.
        data: Its state.
        skin: The skin; short contacts are noted on its links only.
        averages: Whether readings average over the tick, so that no contact is too short.

    Attributes:
        needed: Whether the model has contacts.

    Cost: 0.7 µs a step, and 4 µs a tick in contact; these 4 µs a step where something is fast, hard or comes and goes.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, skin: Skin, *, averages: bool = False) -> None:
        self._model = model
        self._data = data
        self._qvel = data.qvel
        self._pushes = data.qfrc_constraint
        self.needed = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
        # A joint moves no point by more than the model's extent times its velocity.
        self._quick = (FASTEST / max(float(model.stat.extent), 1.0)) ** 2
        links = {int(model.body(patch.link).id) for patch in skin.patches}
        self._feels = [int(body) in links for body in model.geom_bodyid]
        self._averages = averages
        self._groups = np.array(piece_groups(model), dtype=np.int64)
        self.start()

    def start(self) -> None:
        """Forget all contacts."""
        self._now: frozenset[Geoms] = frozenset()
        self._pairs = b""
        self._count = 0
        self.begin(1)

    def begin(self, steps: int) -> None:
        """Begin a tick of ``steps`` steps; contacts that exist now were read in the last tick."""
        self._before = self._now
        self._met = self._now
        self._slow = (_SLOW / (steps * self._model.opt.timestep)) ** 2
        self._deep: dict[Geoms, float] = {}
        self._hard: dict[Geoms, float] = {}
        self._fast: dict[int, float] = {}

    def look(self) -> None:
        """Check the contacts after a step, unless their number is the same and everything is slow and light."""
        motion = mujoco.mju_dot(self._qvel, self._qvel)
        if motion > self._quick:
            self._look_for_fast_bodies()
        if (
            self._data.ncon != self._count
            or motion > self._slow
            or mujoco.mju_dot(self._pushes, self._pushes) > _LIGHT**2
        ):
            self.inspect()

    def _look_for_fast_bodies(self) -> None:
        """Keep the speeds of bodies at the start of the step that are too fast."""
        data = self._data
        arms = data.xipos - data.subtree_com[self._model.body_rootid]
        speeds = np.linalg.norm(data.cvel[:, 3:] + np.cross(data.cvel[:, :3], arms), axis=1)
        for body in np.flatnonzero(speeds > FASTEST).tolist():
            self._fast[body] = max(float(speeds[body]), self._fast.get(body, 0.0))

    def inspect(self) -> None:
        """Check the contacts of the last step. Required after the last step of a tick."""
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
        """Notes on the steps since ``begin``."""
        deep = [self._note(ContactNoteKind.DEEP, geoms, depth=depth) for geoms, depth in self._deep.items()]
        hard = [self._note(ContactNoteKind.HARD, geoms, force=force) for geoms, force in self._hard.items()]
        fast = [
            ContactNote(ContactNoteKind.FAST, (plain_name(self._model.body(body).name),), speed=speed)
            for body, speed in self._fast.items()
        ]
        gone = [] if self._averages else sorted(self._met - self._before - self._now)
        missed = [self._note(ContactNoteKind.BRIEF, geoms) for geoms in gone if any(self._feels[k] for k in geoms)]
        return (*deep, *hard, *fast, *missed)

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
