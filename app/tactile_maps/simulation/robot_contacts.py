"""What touches the robot in a posture it is not in: for placing it there without pushing it into anything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import plain_name
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer


class HasPosition(Protocol):
    """The state of a joint."""

    @property
    def position(self) -> FloatArray:
        """(k,) its coordinates."""


class RobotContacts:
    """Finds what touches a robot under some effects, beside the physics that runs. Built once, asked often.

    The model is one of its own, in which the skin touches by its hulls: the contact models that make the skin's force
    themselves have no shapes that meet.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: Which contacts there are.
        objects: What else is there.
        layer: The skin's cover.

    Raises:
        RobotError: MuJoCo refuses the model.
    """

    def __init__(
        self, robot: Robot, skin: Skin, effects: Effects, objects: Sequence[SceneObject], layer: ElasticLayer
    ) -> None:
        effects = replace(effects, skin="off") if effects.skin in ("foundation", "depth") else effects
        self._model = assemble(robot, skin, effects, objects=objects, layer=layer)
        self._data = mujoco.MjData(self._model)
        self._joints = len(robot.joints)
        self._links = {int(self._model.body(link.name).id) for link in robot.links}

    def words(self, states: Mapping[str, HasPosition], posture: FloatArray) -> str:
        """What touches the robot in ``posture`` (n,), as in ``hand on table``; empty for nothing.

        Args:
            states: Where all else is, by joint name.
            posture: [rad, or m].
        """
        model = self._model
        data = self._data
        for number in range(model.njnt):
            joint = model.joint(number)
            if (state := states.get(joint.name)) is not None:
                first = int(joint.qposadr[0])
                data.qpos[first : first + len(state.position)] = state.position
        data.qpos[: self._joints] = posture
        mujoco.mj_fwdPosition(model, data)
        found = [contact.geom for contact in data.contact if contact.dist < 0]
        pairs = (tuple(int(body) for body in model.geom_bodyid[np.asarray(geoms)]) for geoms in found)
        touching = {tuple(sorted(pair, key=lambda body: body not in self._links)) for pair in pairs}
        named = sorted(self._name(pair) for pair in touching if pair[0] in self._links)
        return ", ".join(named)

    def _name(self, pair: tuple[int, ...]) -> str:
        one, other = (plain_name(self._model.body(body).name).replace("_", " ") for body in pair)
        return f"{one} on {other}"
