"""What all contacts of a link do to it together: the wrench that a force-torque sensor in the link would feel of them.

What such a sensor also feels, the link's own weight and inertia, is left out: it counts as compensated without error.
Friction is in it. It is the whole load of this one link, not of those farther out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.skin.skin import Skin
from app.touch.load import Load
from app.touch.push import Push


class LinkWrenches:
    """Adds up one model's contacts. Mutable: it remembers where bodies were when contacts were found.

    Args:
        model: The compiled model.
        skin: Whose links' wrenches are wanted.
    """

    def __init__(self, model: mujoco.MjModel, skin: Skin) -> None:
        self._model = model
        self._bodies = {patch.link: int(model.body(patch.link).id) for patch in skin.patches}
        self._positions, self._rotations = np.zeros((0, 3)), np.zeros((0, 9))

    def keep(self, data: mujoco.MjData) -> None:
        """Bodies are where the last step found its contacts; a step moves them after that. Cost: 1 µs."""
        self._positions, self._rotations = data.xpos.copy(), data.xmat.copy()

    def read(self, data: mujoco.MjData, pushes: Sequence[Push]) -> dict[str, FloatArray]:
        """(6,) force [N] and torque [N m] about each link's origin, link frame, by link.

        Args:
            data: After a step for which bodies were kept.
            pushes: What else acted between bodies in that step.

        Cost: 2 µs a link, and 10 µs a contact.
        """
        acts = [*self._solved(data), *pushes]
        wrenches = {}
        for link, body in self._bodies.items():
            sums = np.zeros((2, 3))
            for act in acts:
                if body in (act.body, act.other):
                    sign = 1.0 if body == act.body else -1.0
                    arm = act.point - self._positions[body]
                    sums += sign * np.array([act.force, act.torque + np.cross(arm, act.force)])
            wrenches[link] = (sums @ self._rotations[body].reshape(3, 3)).ravel() if acts else sums.ravel()
        return wrenches

    def _solved(self, data: mujoco.MjData) -> Iterator[Push]:
        """The solver's contacts."""
        felt, own = set(self._bodies.values()), np.zeros(6)
        for number, geoms in enumerate(data.contact.geom.tolist()):
            first, second = (int(self._model.geom_bodyid[geom]) for geom in geoms)
            if felt.isdisjoint((first, second)):
                continue
            mujoco.mj_contactForce(self._model, data, number, own)
            frame = data.contact.frame[number].reshape(3, 3)
            yield Push(second, first, data.contact.pos[number], own[:3] @ frame, own[3:] @ frame)


def add_loads(wrenches: dict[str, FloatArray], loads: Sequence[Load]) -> None:
    """Add the normal forces of ``loads``, those of fingers for example, to their links' wrenches."""
    for load in loads:
        force = -load.force * load.normal
        wrenches[load.link] += np.concatenate([force, np.cross(load.point, force)])
