"""The watchman: stops a run at the first number that means nothing, and says where it was."""

from __future__ import annotations

import mujoco
import numpy as np

from app.errors import SimulationError

MAX_SPEED = 1e3
"""Of any joint [rad/s, or m/s]; no robot does this, a diverging integrator does."""


def check(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise when a joint's position or velocity is not finite, or runs away. Asked after every step; about 4 µs.

    The model must not reset itself on bad numbers (``mjDSBL_AUTORESET``), or there is nothing left to see.

    Raises:
        SimulationError: Naming the first such joint, its value and the simulated time.
    """
    speed = np.abs(data.qvel)
    # NaN compares false with everything, so the sound case is asked for, not the bad one.
    if bool((speed <= MAX_SPEED).all()) and bool(np.isfinite(data.qpos).all()):
        return
    joint = int(np.flatnonzero(~((speed <= MAX_SPEED) & np.isfinite(data.qpos)))[0])
    raise SimulationError(
        "the simulation diverged",
        place=f"joint {model.joint(joint).name} at {data.time:.3f} s",
        value=f"position {data.qpos[joint]:.3g}, velocity {data.qvel[joint]:.3g} a second",
        remedy="Reset; use softer gains, a softer finger or a smaller time step",
    )
