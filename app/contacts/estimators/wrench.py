"""The force and torque of a contact on a link, and how joint torques tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly
from app.errors import MapError
from app.robots.configuration import Configuration


@dataclass(frozen=True, eq=False)
class Wrench:
    """What acts on a link, in its frame and about its origin.

    Attributes:
        force: (3,) [N].
        torque: (3,) [N m].
        rank: How many of its six numbers are known; a sensor in the link tells all, few joints tell fewer.
        condition: How many times relative errors of what it was found from may have grown.
        force_noise: Standard deviation of each force [N].
        torque_noise: Standard deviation of each torque [N m].
    """

    force: FloatArray
    torque: FloatArray
    rank: int = 6
    condition: float = 1.0
    force_noise: float = 0.0
    torque_noise: float = 0.0

    def __post_init__(self) -> None:
        for name in ("force", "torque"):
            value = readonly(getattr(self, name))
            if value.shape != (3,) or not np.isfinite(value).all():
                raise MapError("a wrench's force and torque are three finite numbers each", value=value.tolist())
            object.__setattr__(self, name, value)


_KNOWN = 1e-6
"""Singular values below this share of the largest tell nothing."""


def wrench_of_torques(configuration: Configuration, link: str, torques: FloatArray) -> Wrench:
    """The smallest wrench on ``link`` that the joints' ``torques`` (joints,) [N m, N] are due to: J' w = torques.

    Torques are those that contact alone causes: motors, gravity and inertia taken off. Lengths count in decimetres, so
    that forces and torques of touch have like weight. Cost: 60 µs.

    Raises:
        MapError: There is not one finite number for each joint.
        RobotError: There is no such link.
    """
    jacobian = _jacobian(configuration, link)
    torques = np.asarray(torques, dtype=np.float64)
    if torques.shape != jacobian.shape[1:] or not np.isfinite(torques).all():
        raise MapError(f"these are not the torques of {jacobian.shape[1]} joints", value=torques.tolist())
    scale = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    left, values, right = np.linalg.svd((jacobian * scale[:, None]).T, full_matrices=False)
    known = values > _KNOWN * max(float(values.max(initial=0.0)), 1e-300)
    wrench = scale * (right[known].T @ ((left.T @ torques)[known] / values[known]))
    condition = float(values[known].max() / values[known].min()) if known.any() else float("inf")
    return Wrench(wrench[:3], wrench[3:], int(known.sum()), condition)


def _jacobian(configuration: Configuration, link: str) -> FloatArray:
    """(6, joints) velocity of the link's origin over angular velocity, link frame, per joint velocity."""
    turn = configuration.pose(link).rotation.T
    origin = turn @ configuration.jacobian(link, np.zeros(3))
    along_x = turn @ configuration.jacobian(link, np.array([1.0, 0.0, 0.0])) - origin  # omega x e_x = (0, wz, -wy)
    along_y = turn @ configuration.jacobian(link, np.array([0.0, 1.0, 0.0])) - origin  # omega x e_y = (-wz, 0, wx)
    return np.vstack([origin, along_y[2], -along_x[2], along_x[1]])
