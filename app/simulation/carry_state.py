"""Taking the state along when the model changes: by joint name, for the robot and for objects that come and go."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from app.arrays import FloatArray, readonly
from app.simulation.physics import Physics

_POSITIONS = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
_VELOCITIES = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}


@dataclass(frozen=True, eq=False)
class JointState:
    """One joint at one instant.

    Attributes:
        position: Its coordinates [rad, m].
        velocity: [rad/s, m/s].
        acceleration: Of the last step, from which the solver starts.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    @property
    def at_rest(self) -> JointState:
        """The same, without motion."""
        return JointState(self.position, 0 * self.velocity, 0 * self.acceleration)


def joint_states(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, JointState]:
    """All joints of ``data`` by name."""
    states = {}
    for joint in range(model.njnt):
        at, way = _slices(model, joint)
        states[model.joint(joint).name] = JointState(data.qpos[at], data.qvel[way], data.qacc_warmstart[way])
    return states


def restore(physics: Physics, states: Mapping[str, JointState], time: float) -> None:
    """Bring ``physics`` to these states and that time; joints without one stay where they are.

    Args:
        physics: Fresh, or at any state.
        states: By joint name.
        time: [s].
    """
    model, data = physics.model, physics.data
    data.time = time
    warm = np.zeros(model.nv)
    for joint in range(model.njnt):
        state = states.get(model.joint(joint).name)
        if state is not None:
            at, way = _slices(model, joint)
            data.qpos[at], data.qvel[way], warm[way] = state.position, state.velocity, state.acceleration
    physics.settle()
    data.qacc_warmstart[:] = warm


def _slices(model: mujoco.MjModel, joint: int) -> tuple[slice, slice]:
    """Of the joint's coordinates in ``qpos`` and ``qvel``."""
    kind = mujoco.mjtJoint(int(model.jnt_type[joint]))
    at, way = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    return slice(at, at + _POSITIONS.get(kind, 1)), slice(way, way + _VELOCITIES.get(kind, 1))
