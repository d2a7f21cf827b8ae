"""The watchman: stops a run at the first number that means nothing, and says where it was."""

from __future__ import annotations

import mujoco
import numpy as np

from app.errors import SimulationError

MAX_SPEED = 1e3
"""Of any joint [rad/s, or m/s]; no robot does this, a diverging integrator does."""


def check(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise when the state is not finite, MuJoCo has reset it, or a joint runs away.

    Raises:
        SimulationError: Naming the joint, its value and the simulated time.
    """
    bad = ~np.isfinite(data.qpos) | ~np.isfinite(data.qvel) | (np.abs(data.qvel) > MAX_SPEED)
    troubles = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
    reset = any(data.warning[int(kind)].number for kind in troubles)
    if bad.any() or reset:
        joint = int(np.flatnonzero(bad)[0]) if bad.any() else 0
        raise SimulationError(
            "the simulation diverged", place=f"joint {model.joint(joint).name} at {data.time:.3f} s",
            value=f"{data.qvel[joint]:.3g} rad/s",
            remedy="Reset; use softer gains, a softer finger or a smaller time step",
        )
