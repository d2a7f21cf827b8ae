"""Loads of contacts on the skin at one instant, and the wrench of all contacts on a link.

``ContactLoads`` combines the solver's contacts into one load per link with skin and body that touches it.
``LinkWrenches`` computes the contact wrench that a force-torque sensor in a link would measure. It includes friction
and excludes weight and inertia of the link, as if they were compensated without error. It is the load of that link
alone, without those of the links farther out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.simulation.mean_loads import ONE_LOAD
from tactile_maps.simulation.pressing_shapes import Solids
from tactile_maps.skin.link_pieces import piece_number
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.loads import Load
from tactile_maps.tactile.models.foundation import ContactWrench

_FORCE = np.arange(3)


class ContactLoads:
    """Loads on a skin, read from the contacts of one model. Built once for a model.

    All contacts of one link with one geom are one load: the sum of their normal forces, at the centre of those, along
    the mean of their normals. On a link that collides in pieces, contacts whose normals are more than 60 degrees apart
    are separate loads: a ball in a groove presses both walls. Within one load of such a link, the parts of the forces
    across the mean normal cancel and do not count. When two links with skin touch, both get a load.

    Args:
        model: The compiled model, with elliptic cones.
        skin: Skin whose links get loads.
        solids: Shapes of the model's geoms.
        shear: Whether loads include friction: their shear and their torque about the normal.
    """

    def __init__(self, model: mujoco.MjModel, skin: Skin, solids: Solids, *, shear: bool = False) -> None:
        self._solids = solids
        self._shear = shear
        self._links = {int(model.body(patch.link).id): patch.link for patch in skin.patches}
        self._feels = [int(body) if int(body) in self._links else 0 for body in model.geom_bodyid]
        self._divided = {
            int(model.geom_bodyid[geom]) for geom in range(model.ngeom) if piece_number(model.geom(geom).name) == 0
        }

    def read(self, data: mujoco.MjData) -> list[Load]:
        """Return the loads on the skin at the state of ``data``.

        Cost: 3 times a bare step for one contact, 0.3 µs for each further one and 10 µs for each further load; with
        shear 20 µs more for each load.
        """
        if not data.ncon:
            return []
        contact = data.contact
        forces = data.efc_force
        feels = self._feels
        address = contact.efc_address.tolist()
        # Contacts by link, other geom and sign. For a few contacts lists are faster than arrays.
        meetings: dict[tuple[int, int, float], list[int]] = {}
        for number, (first, second) in enumerate(contact.geom.tolist()):
            if address[number] >= 0:  # a contact without an address has no force
                if feels[first]:
                    meetings.setdefault((feels[first], second, 1.0), []).append(number)
                if feels[second]:
                    meetings.setdefault((feels[second], first, -1.0), []).append(number)
        loads = []
        for (body, other, sign), numbers in self._by_normal(data, meetings):
            # The first number at a contact's address is its normal force.
            force = forces[[address[number] for number in numbers]]
            total = float(force.sum())
            if total > 0:
                # The contact frame's x axis points from the first geom to the second: outward for the first body.
                moment = force @ contact.pos[numbers]
                normal = sign * (force @ contact.frame[numbers, :3])
                if body in self._divided:  # forces across the mean normal of a hollow cancel
                    share = math.sqrt(normal @ normal) / total
                    total = share * total
                    moment = share * moment
                load = self._load(data, body, other, total, moment, normal)
                loads.append(self._with_friction(data, load, body, sign, numbers) if self._shear else load)
        return loads

    def _by_normal(
        self, data: mujoco.MjData, meetings: dict[tuple[int, int, float], list[int]]
    ) -> Iterator[tuple[tuple[int, int, float], list[int]]]:
        """Yield each meeting; on links in pieces, its contacts by normal, the strongest first."""
        for meeting, numbers in meetings.items():
            if meeting[0] not in self._divided or len(numbers) == 1:
                yield meeting, numbers
                continue
            forces = data.efc_force[data.contact.efc_address[numbers]]
            normals = data.contact.frame[numbers, :3]
            clusters: dict[int, list[int]] = {}
            for row in (-forces).argsort(kind="stable").tolist():
                first = next((one for one in clusters if normals[one] @ normals[row] > ONE_LOAD), row)
                clusters.setdefault(first, []).append(numbers[row])
            for cluster in clusters.values():
                yield meeting, cluster

    def _load(
        self, data: mujoco.MjData, body: int, geom: int, force: float, moment: FloatArray, normal: FloatArray
    ) -> Load:
        """Return the load of ``geom`` on ``body``, from sums of force, force times place, force times normal."""
        rotation = data.xmat[body].reshape(3, 3)
        solid = self._solids[geom]
        point = (moment / force - data.xpos[body]) @ rotation
        outward = (normal / math.sqrt(normal @ normal)) @ rotation
        return Load(self._links[body], point, outward, force, solid.shape, solid.seen_from(data, body), solid.by)

    def _with_friction(self, data: mujoco.MjData, load: Load, body: int, sign: float, numbers: Sequence[int]) -> Load:
        """Return the load with the forces along the skin of its contacts, and their torque about its normal."""
        contact = data.contact
        if contact.dim[numbers[0]] < 3:
            return load
        rows = contact.efc_address[numbers]
        # Forces act on the second geom, along the axes of the contact's frame.
        parts = -sign * data.efc_force[rows[:, None] + _FORCE]
        forces = np.einsum("ij,ijk->ik", parts, contact.frame[numbers].reshape(-1, 3, 3))
        rotation = data.xmat[body].reshape(3, 3)
        inward = forces.sum(axis=0) @ rotation
        arms = (contact.pos[numbers] - data.xpos[body]) @ rotation - load.point
        torque = float(np.cross(arms, forces @ rotation).sum(axis=0) @ load.normal)
        shear = inward - (inward @ load.normal) * load.normal
        return replace(load, shear=shear, torque=torque, friction=float(contact.friction[numbers[0], 0]))


class LinkWrenches:
    """Contact wrenches on the links with skin of one model.

    Mutable: it stores the sums over steps and the poses of the bodies at the time the contacts were found.

    Args:
        model: The compiled model.
        skin: Skin that selects the links.
    """

    def __init__(self, model: mujoco.MjModel, skin: Skin) -> None:
        self._model = model
        self._bodies = {patch.link: int(model.body(patch.link).id) for patch in skin.patches}
        self._positions = np.zeros((0, 3))
        self._rotations = np.zeros((0, 9))
        self.begin()

    def begin(self) -> None:
        """Clear the sums of earlier steps."""
        self._steps = 0
        self._sums = np.zeros((len(self._bodies), 6))

    def add(self, data: mujoco.MjData, pushes: Sequence[ContactWrench]) -> None:
        """Add the wrenches of the last step to the mean. Cost: that of ``read``."""
        self._steps += 1
        self._sums += self._of_step(data, pushes, data.xpos, data.xmat)

    def keep(self, data: mujoco.MjData) -> None:
        """Store the poses at which the last step found its contacts, before they are updated. Cost: 1 µs."""
        self._positions = data.xpos.copy()
        self._rotations = data.xmat.copy()

    def read(self, data: mujoco.MjData, pushes: Sequence[ContactWrench]) -> dict[str, FloatArray]:
        """(6,) force [N] and torque [N m] about each link's origin, link frame, by link.

        The mean over the added steps; without any, the wrenches of the last step.

        Args:
            data: State after a step whose poses were stored by ``keep``.
            pushes: Other wrenches between bodies in that step.

        Cost: 2 µs a link, and 10 µs a contact.
        """
        if self._steps:
            wrenches = self._sums / self._steps
        else:
            wrenches = self._of_step(data, pushes, self._positions, self._rotations)
        return dict(zip(self._bodies, wrenches, strict=True))

    def _of_step(
        self, data: mujoco.MjData, pushes: Sequence[ContactWrench], positions: FloatArray, rotations: FloatArray
    ) -> FloatArray:
        """(links, 6) wrenches of one step, in which the bodies were at ``positions`` with ``rotations``."""
        wrenches = np.zeros((len(self._bodies), 6))
        contacts = [*self._solved(data), *pushes]
        for row, body in zip(wrenches, self._bodies.values(), strict=True):
            sums = np.zeros((2, 3))
            for contact in contacts:
                if body in (contact.body, contact.other):
                    sign = 1.0 if body == contact.body else -1.0
                    arm = contact.point - positions[body]
                    sums += sign * np.array([contact.force, contact.torque + np.cross(arm, contact.force)])
            if contacts:
                row[:] = (sums @ rotations[body].reshape(3, 3)).ravel()
        return wrenches

    def _solved(self, data: mujoco.MjData) -> Iterator[ContactWrench]:
        """Yield the solver's contacts of links with skin."""
        felt = set(self._bodies.values())
        own = np.zeros(6)
        for number, geoms in enumerate(data.contact.geom.tolist()):
            first, second = (int(self._model.geom_bodyid[geom]) for geom in geoms)
            if felt.isdisjoint((first, second)):
                continue
            mujoco.mj_contactForce(self._model, data, number, own)
            frame = data.contact.frame[number].reshape(3, 3)
            yield ContactWrench(second, first, data.contact.pos[number], own[:3] @ frame, own[3:] @ frame)


def add_loads(wrenches: dict[str, FloatArray], loads: Sequence[Load]) -> None:
    """Add the forces of ``loads``, those of fingers for example, to their links' wrenches."""
    for load in loads:
        force = load.shear - load.force * load.normal
        wrenches[load.link] += np.concatenate([force, np.cross(load.point, force)])
