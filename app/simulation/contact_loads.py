"""The solver's contacts as loads on the skin: one for each link that feels and thing that touches it."""

from __future__ import annotations

import math

import mujoco

from app.arrays import FloatArray
from app.simulation.geom_shapes import Solids
from app.skin.skin import Skin
from app.touch.load import Load


class ContactLoads:
    """Reads the loads on a skin from one model's contacts. Built once for a model.

    All contacts of one link with one geom are one load: the sum of their normal forces, at the centre of those, along
    the mean of their normals. Two links with skin that touch both feel it. Friction is not felt.

    Args:
        model: The compiled model, with elliptic cones.
        skin: Which links feel.
        solids: Of the model's geoms.
    """

    def __init__(self, model: mujoco.MjModel, skin: Skin, solids: Solids) -> None:
        self._solids = solids
        self._links = {int(model.body(patch.link).id): patch.link for patch in skin.patches}
        self._feels = [int(body) if int(body) in self._links else 0 for body in model.geom_bodyid]

    def read(self, data: mujoco.MjData) -> list[Load]:
        """What presses the skin at the state of ``data``.

        Cost: 3 times a bare step for one contact, 0.3 µs for each further one and 10 µs for each further load.
        """
        if not data.ncon:
            return []
        contact, forces, feels = data.contact, data.efc_force, self._feels
        address = contact.efc_address.tolist()
        # Numbers of contacts by who meets: plain lists, which are faster than arrays for the few there are.
        meetings: dict[tuple[int, int, float], list[int]] = {}
        for number, (first, second) in enumerate(contact.geom.tolist()):
            if address[number] >= 0:  # one without an address makes no force
                if feels[first]:
                    meetings.setdefault((feels[first], second, 1.0), []).append(number)
                if feels[second]:
                    meetings.setdefault((feels[second], first, -1.0), []).append(number)
        loads = []
        for (body, other, sign), numbers in meetings.items():
            # The first number at a contact's address is its normal force.
            force = forces[[address[number] for number in numbers]]
            total = float(force.sum())
            if total > 0:
                # The contact frame's x axis points from the first geom to the second: outward for the first body.
                sums = force @ contact.pos[numbers], sign * (force @ contact.frame[numbers, :3])
                loads.append(self._load(data, body, other, total, *sums))
        return loads

    def _load(
        self, data: mujoco.MjData, body: int, geom: int, force: float, moment: FloatArray, normal: FloatArray
    ) -> Load:
        """Of the sums over the contacts of ``body`` with ``geom``: force, force times place, force times normal."""
        rotation, solid = data.xmat[body].reshape(3, 3), self._solids[geom]
        point = (moment / force - data.xpos[body]) @ rotation
        outward = (normal / math.sqrt(normal @ normal)) @ rotation
        return Load(self._links[body], point, outward, force, solid.shape, solid.seen_from(data, body), solid.by)
