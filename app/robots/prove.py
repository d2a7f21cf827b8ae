"""Proof that a robot is fit to simulate, before anybody sees it."""

from __future__ import annotations

import warnings

import mujoco
import numpy as np

from app.arrays import FloatArray
from app.errors import RobotError

STEPS = 20
LARGEST = 1e6  # m, or the same number of anything else; beyond it float32 shapes lose their form
_TROUBLES = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
_REMEDY = "Check masses, inertias and joint damping in the file"


def refuse_absurd_numbers(model: mujoco.MjModel, source: str) -> None:
    """Raise RobotError, naming the body, where a place or a size is not finite or beyond ``LARGEST``."""
    sizes = np.zeros((model.nbody, 3))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_size))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_pos))
    numbers = np.hstack([sizes, model.body_pos, model.body_quat, model.body_mass[:, None], model.body_inertia])
    bad = np.flatnonzero(~(np.abs(numbers) < LARGEST).all(axis=1))
    if bad.size:
        row = numbers[bad[0]]
        worst = float(row[np.argmin(np.abs(row) < LARGEST)])
        place = f"body {model.body(int(bad[0])).name}"
        raise RobotError("a place, size, mass or inertia is absurdly large", file=source, place=place, value=worst)


def prove_alive(model: mujoco.MjModel, home: FloatArray, source: str) -> None:
    """Step the robot from rest; raise RobotError if it cannot take 20 steps of 1 ms. Changes the model's options."""
    data = mujoco.MjData(model)
    data.qpos[:] = home
    model.opt.timestep, model.opt.integrator = 1e-3, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    with warnings.catch_warnings(record=True) as complaints:
        warnings.simplefilter("always")
        mujoco.mj_step(model, data, STEPS)
    blown = not np.isfinite(data.qpos).all() or any(data.warning[int(trouble)].number for trouble in _TROUBLES)
    if blown or complaints:
        said = str(complaints[0].message) if complaints else None
        raise RobotError("the robot does not survive its first steps", file=source, value=said, remedy=_REMEDY)
