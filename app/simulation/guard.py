"""The watchman: stops a run at the first number that means nothing, and says where it was."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.errors import SimulationError
from app.robots.robot import Robot
from app.simulation.impedance import Impedance

MAX_SPEED = 1e3
"""Of any joint [rad/s, or m/s]; no robot does this, a diverging integrator does."""
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class Guard:
    """Watches one model's state and keeps the last good one.

    The model must not reset itself on bad numbers (``mjDSBL_AUTORESET``), or there is nothing left to see.

    Args:
        model: The compiled model.
        data: Its state.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._good = np.zeros(mujoco.mj_stateSize(model, _STATE))
        self._qvel, self._limit = data.qvel, MAX_SPEED**2

    def keep(self) -> None:
        """Take the present state for the last good one. Cost: 0.5 µs."""
        mujoco.mj_getState(self._model, self._data, self._good, _STATE)

    def sound(self) -> bool:
        """Whether all joints' velocities are finite and none runs away. Cost: 0.3 µs; 2 µs at great speeds.

        A position that is not finite comes of a velocity that is not.
        """
        # NaN compares false with everything, so the sound case is asked for, not the bad one.
        if mujoco.mju_dot(self._qvel, self._qvel) <= self._limit:  # numpy would warn of an overflow
            return True
        return bool((np.abs(self._qvel) <= MAX_SPEED).all())

    def replay(self, step: Callable[[], None], count: int) -> None:
        """Go ``count`` steps again from the last good state, one by one, and stop at the first bad one.

        Args:
            step: Advances the physics by one step.
            count: How many were taken in one go.

        Raises:
            SimulationError: As ``stop``.
        """
        self._back()
        for _ in range(count):
            self.keep()
            step()
            if not self.sound():
                self.stop()

    def stop(self) -> None:
        """Tell what the last step did, and return to the state before it.

        Raises:
            SimulationError: Always: naming the first bad joint, its value, the simulated time and the energy before.
        """
        error = self._error()
        self._back()
        raise error

    def _back(self) -> None:
        mujoco.mj_setState(self._model, self._data, self._good, _STATE)

    def _error(self) -> SimulationError:
        model, data = self._model, self._data
        dof = int(np.flatnonzero(~(np.abs(data.qvel) <= MAX_SPEED))[0])
        joint = model.joint(int(model.dof_jntid[dof]))
        position, velocity, time = data.qpos[joint.qposadr[0]], data.qvel[dof], data.time
        self._back()
        return SimulationError(
            "the simulation diverged",
            place=f"joint {joint.name} at {time:.3f} s",
            value=f"position {position:.3g}, velocity {velocity:.3g} a second, energy before {self._energy():.3g} J",
            remedy="Reset; use softer gains, a softer finger or a smaller time step",
        )

    def _energy(self) -> float:
        """Kinetic energy [J] at the present state."""
        if not self._model.nv:
            return 0.0
        moved: FloatArray = np.zeros(self._model.nv)
        mujoco.mj_forward(self._model, self._data)
        mujoco.mj_mulM(self._model, self._data, moved, self._data.qvel)
        return 0.5 * float(self._data.qvel @ moved)


def check_command(robot: Robot, command: Impedance) -> None:
    """Refuse a command that holds something that is no finite number, before it reaches the physics.

    Args:
        robot: Whose joints.
        command: What is asked of them.

    Raises:
        SimulationError: Naming the first such joint.
    """
    asked = {"posture": command.posture, "stiffness": command.stiffness, "damping": command.damping,
             "torque": command.torque}  # fmt: skip
    if math.isfinite(sum(float(values.sum()) for values in asked.values())):
        return
    for name, values in asked.items():
        for joint, value in zip(robot.joints, values, strict=True):
            if not math.isfinite(value):
                raise SimulationError(
                    "the controller asked for no number",
                    place=f"joint {joint.name}",
                    value=f"{name} {value}",
                    remedy="Reset; look at what drives the controller",
                )
