"""Contacts of the robot in a posture before it is placed there."""

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
    """State of a joint."""

    @property
    def position(self) -> FloatArray:
        """(k,) coordinates."""


class RobotContacts:
    """Contacts of a robot in any posture, computed with a separate model. Built once for some effects.

    In this model the skin collides by its hulls, because contact models that compute the force themselves have no
    collision shapes.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: Effects, which determine the contacts.
        objects: Objects of the scene.
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
        """Return the contacts of the robot in ``posture`` (n,), such as ``hand on table``; empty without contact.

        Args:
            states: States of all other joints by name.
            posture: Joint positions [rad or m].
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
