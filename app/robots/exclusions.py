"""Which links may never collide: neighbours whose shapes overlap in most postures are joined, not in collision."""

from __future__ import annotations

from collections import Counter

import mujoco
import numpy as np

from app.arrays import FloatArray

POSTURES = 30
SHARE = 0.5


def pairs_to_exclude(model: mujoco.MjModel, home: FloatArray, *, seed: int = 0) -> list[tuple[str, str]]:
    """Names of body pairs to exclude from collision, sorted.

    These are pairs that touch at home or in at least half of 30 random postures (iCub's shells overlap for good, and
    its simulation blows up otherwise), and the children of links fixed to the world, which MuJoCo's own parent-child
    filter forgets. Cost: 31 collision passes.

    Args:
        model: A compiled model with scalar joints only and names for all bodies.
        home: (nq,) the posture at rest.
        seed: Of the random postures.
    """
    data = mujoco.MjData(model)
    counts: Counter[tuple[int, int]] = Counter()
    for posture in _random_postures(model, seed):
        counts.update(_touching(model, data, posture))
    pairs = {pair for pair, count in counts.items() if count >= SHARE * POSTURES}
    pairs |= _touching(model, data, home) | _children_of_fixed_links(model)
    return sorted((model.body(a).name, model.body(b).name) for a, b in pairs)


def _random_postures(model: mujoco.MjModel, seed: int) -> FloatArray:
    """(POSTURES, nq) uniform inside the limits; within half a turn or half a metre where there are none."""
    span = np.where(model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE, 0.5, np.pi)
    limited = model.jnt_limited.astype(bool) & (np.ptp(model.jnt_range, axis=1) < 100 * span)
    lower = np.where(limited, model.jnt_range[:, 0], -span)
    upper = np.where(limited, model.jnt_range[:, 1], span)
    return np.random.default_rng(seed).uniform(lower, upper, (POSTURES, model.nq))


def _touching(model: mujoco.MjModel, data: mujoco.MjData, posture: FloatArray) -> set[tuple[int, int]]:
    """Pairs of bodies with penetrating geoms at ``posture``; neither is the world."""
    data.qpos[:] = posture
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    touching = data.contact.geom[data.contact.dist <= 0]
    bodies = np.sort(model.geom_bodyid[touching].reshape(-1, 2), axis=1)
    return {(int(a), int(b)) for a, b in bodies if 0 < a < b}


def _children_of_fixed_links(model: mujoco.MjModel) -> set[tuple[int, int]]:
    """Moving bodies paired with the parent they are hinged to, where the parent is fixed to the world."""
    return {
        (int(parent), body)
        for body, parent in enumerate(model.body_parentid)
        if parent > 0 and model.body_weldid[body] != 0 and model.body_weldid[parent] == 0
    }
