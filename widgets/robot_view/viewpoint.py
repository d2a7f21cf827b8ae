"""Where the eye is: pixels to rays, points to pixels, and the place from which everything is just in the picture.

Pure arithmetic of a perspective camera; knows neither Qt nor VTK. Pixels count from the upper left corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from app.arrays import FloatArray, readonly


@dataclass(frozen=True, eq=False)
class CameraRay:
    """A ray from the eye through a pixel, world frame.

    Attributes:
        origin: (3,) [m].
        direction: (3,) unit.
    """

    origin: FloatArray
    direction: FloatArray


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A perspective camera.

    Attributes:
        eye: (3,) [m], world.
        focus: (3,) [m] what it looks at; not the eye.
        up: (3,) roughly up; not along the line of sight.
        view_angle: Vertical, full [degrees].
    """

    eye: FloatArray
    focus: FloatArray
    up: FloatArray
    view_angle: float

    def __post_init__(self) -> None:
        for name in ("eye", "focus", "up"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    @classmethod
    def of(cls, camera: Any) -> Viewpoint:
        """The viewpoint of a PyVista camera as it is now."""
        return cls(camera.position, camera.focal_point, camera.up, float(camera.view_angle))

    def to(self, camera: Any) -> None:
        """Let a PyVista camera look from here."""
        camera.position, camera.focal_point, camera.up = self.eye.tolist(), self.focus.tolist(), self.up.tolist()
        camera.view_angle = self.view_angle

    @cached_property
    def axes(self) -> FloatArray:
        """(3, 3) rows right, up and forward: unit vectors of the picture, world frame."""
        forward = (self.focus - self.eye) / self.distance
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        return readonly([right, np.cross(right, forward), forward])

    @property
    def distance(self) -> float:
        """From the eye to the focus [m]."""
        return float(np.linalg.norm(self.focus - self.eye))

    def ray(self, pixel: tuple[float, float], size: tuple[int, int]) -> CameraRay:
        """The ray through a pixel of a picture of this width and height [px]."""
        half = np.tan(np.radians(self.view_angle) / 2) / (size[1] / 2)
        direction = np.array([half * (pixel[0] - size[0] / 2), half * (size[1] / 2 - pixel[1]), 1.0]) @ self.axes
        return CameraRay(self.eye, direction / np.linalg.norm(direction))

    def pixels(self, points: FloatArray, size: tuple[int, int]) -> FloatArray:
        """(k, 2) where points (k, 3) [m] appear in a picture of this size; NaN for those not in front of the eye."""
        across, above, depth = ((np.atleast_2d(points) - self.eye) @ self.axes.T).T
        depth = np.where(depth > 0, depth, np.nan)
        scale = size[1] / 2 / np.tan(np.radians(self.view_angle) / 2) / depth
        return np.stack([size[0] / 2 + scale * across, size[1] / 2 - scale * above], axis=1)


def framing(points: FloatArray, away: FloatArray, aspect: float, *, view_angle: float, fill: float) -> Viewpoint:
    """The nearest viewpoint in a direction from which all points are in the picture, z up.

    Each point must lie inside four planes through the eye; the tightest pair of planes decides how far away it is, and
    the slack of the other pair is shared evenly.

    Args:
        points: (k, 3) [m], at least one.
        away: (3,) from the points to the eye; not along z.
        aspect: Width by height of the picture.
        view_angle: Vertical, full [degrees].
        fill: Share of the picture's width or height that the points may take.
    """
    away = np.asarray(away, dtype=np.float64) / np.linalg.norm(away)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    axes = Viewpoint(middle + away, middle, np.array([0.0, 0.0, 1.0]), view_angle).axes
    x, y, z = ((points - middle) @ axes.T).T
    slope = fill * np.tan(np.radians(view_angle) / 2) * np.array([aspect, 1.0])
    ahead = [np.max(side - tan * z) for tan, axis in zip(slope, (x, y), strict=True) for side in (axis, -axis)]
    right, left, top, bottom = ahead
    depth = min(-(right + left) / (2 * slope[0]), -(top + bottom) / (2 * slope[1]), float(z.min()) - 1e-3)
    eye = np.array([(right - left) / 2, (top - bottom) / 2, depth]) @ axes + middle
    ahead_of_eye = max(float(z.mean()) - depth, 1e-3)
    return Viewpoint(eye, eye + ahead_of_eye * axes[2], np.array([0.0, 0.0, 1.0]), view_angle)
