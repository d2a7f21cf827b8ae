"""The cube in the corner that says where x, y and z point, and turns the view: its visible faces, without Qt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray

_NAMES = (("X", "\u2212X"), ("Y", "\u2212Y"), ("Z", "\u2212Z"))
_RING = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_LEGIBLE = 0.3


@dataclass(frozen=True, eq=False)
class CubeFace:
    """One face that looks at the eye.

    Attributes:
        corners: (4, 2) in half edges from the cube's middle, x to the right and y down.
        facing: 0 seen from the side, 1 seen straight on.
        name: Its axis, or nothing where it is too slanted to be read.
        normal: (3,) its axis with its sign, world frame.
    """

    corners: FloatArray
    facing: float
    name: str
    normal: FloatArray

    def holds(self, x: float, y: float) -> bool:
        """Whether a point in half edges from the cube's middle, y down, lies on it."""
        sides, arms = np.roll(self.corners, -1, axis=0) - self.corners, np.array([x, y]) - self.corners
        turns = sides[:, 0] * arms[:, 1] - sides[:, 1] * arms[:, 0]
        return bool((turns >= 0).all() or (turns <= 0).all())


def cube_faces(axes: FloatArray) -> list[CubeFace]:
    """The faces of a cube along the world's axes that can be seen, parallel projection.

    Args:
        axes: (3, 3) rows right, up and forward of the picture, world frame.
    """
    faces = []
    for axis in range(3):
        for side, name in zip((1.0, -1.0), _NAMES[axis], strict=True):
            facing = -side * float(axes[2, axis])
            if facing <= 1e-6:
                continue
            corners = np.insert(_RING, axis, side, axis=1) @ axes[:2].T * [1.0, -1.0]
            faces.append(CubeFace(corners, facing, name if facing > _LEGIBLE else "", side * np.eye(3)[axis]))
    return faces
