"""The physics of one scene, stepped: an arm under impedance commands, fingers on its skin, what the skin feels."""

from __future__ import annotations

from typing import Protocol

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.robots.robot import Robot
from app.simulation import guard
from app.simulation.assemble import assemble
from app.simulation.effects import Effects
from app.simulation.fingers import Fingers
from app.simulation.loads import contact_loads
from app.simulation.poke import PokeInput, PokeState
from app.simulation.sensing import WaterFill
from app.skin.skin import Skin


class Impedance(Protocol):
    """What the joints are asked for; ``app.control.command.JointCommand`` is one. (This folder knows no control.)"""

    @property
    def posture(self) -> FloatArray:
        """(n,) [rad]."""

    @property
    def stiffness(self) -> FloatArray:
        """(n,) [N m/rad]."""

    @property
    def damping(self) -> FloatArray:
        """(n,) [N m s/rad]."""

    @property
    def torque(self) -> FloatArray:
        """(n,) [N m]."""


class Simulation:
    """One robot with one skin. Mutable; ``reset`` starts again. Deterministic: same calls, same numbers, bit for bit.

    Args:
        robot: The robot.
        skin: Its skin.
        effects: What to simulate.
    """

    def __init__(self, robot: Robot, skin: Skin, effects: Effects) -> None:
        self._robot, self._skin, self._effects = robot, skin, effects
        self._model = assemble(robot, skin, effects)
        self._data = mujoco.MjData(self._model)
        self._fingers = Fingers(self._model, skin)
        self._fill = WaterFill(skin)
        self.reset()

    def reset(self) -> None:
        """The robot at home and at rest, no fingers, time zero."""
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = self._robot.home
        self._fingers.reset()
        mujoco.mj_forward(self._model, self._data)

    def apply(self, poke: PokeInput) -> None:
        """Let a hand do something, from the next step on. Raises SimulationError for a finger that is too stiff."""
        self._fingers.apply(self._data, poke)

    def step(self, count: int, command: Impedance) -> None:
        """Advance ``count`` time steps under one command.

        Args:
            count: How many.
            command: Posture, stiffness, damping and added torque for each joint.

        Raises:
            SimulationError: The state left the numbers that mean something; it is kept as it was then.
        """
        model, data = self._model, self._data
        model.actuator_gainprm[:, 0] = command.stiffness
        model.actuator_biasprm[:, 1] = -command.stiffness
        model.actuator_biasprm[:, 2] = -command.damping
        data.ctrl[:] = command.posture
        for _ in range(count):
            mujoco.mj_step1(model, data)
            data.qfrc_applied[:] = command.torque
            self._fingers.push(data)
            mujoco.mj_step2(model, data)
            guard.check(model, data)
        # Positions of bodies are those before the last step until kinematics is asked again.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)

    def sense(self) -> FloatArray:
        """(taxels,) pressures [Pa] of the last step's loads."""
        loads = self._fingers.loads()
        if self._effects.contact != "off":
            loads += contact_loads(self._model, self._data, self._skin)
        return self._fill.pressures(loads)

    @property
    def pokes(self) -> tuple[PokeState, ...]:
        """All fingers on the skin."""
        return self._fingers.states(self._data)

    @property
    def posture(self) -> FloatArray:
        """(n,) [rad, or m]."""
        return self._data.qpos.copy()

    @property
    def velocity(self) -> FloatArray:
        """(n,) [rad/s, or m/s]."""
        return self._data.qvel.copy()

    @property
    def time(self) -> float:
        """Simulated seconds since the reset."""
        return float(self._data.time)

    @property
    def timestep(self) -> float:
        """Of the physics [s]."""
        return float(self._model.opt.timestep)

    def state(self) -> FloatArray:
        """Everything the future depends on, as one vector: MuJoCo's integration state and the fingers."""
        spec = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        state = np.zeros(mujoco.mj_stateSize(self._model, spec))
        mujoco.mj_getState(self._model, self._data, state, spec)
        return np.concatenate([state, self._fingers.numbers()])
