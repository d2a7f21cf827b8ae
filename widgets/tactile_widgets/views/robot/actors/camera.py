"""Camera of the robot view: pixels to rays, points to pixels, framing, and its moves (orbit, pan, zoom).

Arithmetic of a perspective camera without Qt and VTK. Pixels count from the upper left corner.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, readonly


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
class Viewpoint(ArrayFields):
    """A perspective camera.

    Attributes:
        eye: (3,) [m], world.
        focus: (3,) point that it looks at [m]; not the eye.
        up: (3,) approximate up direction; not along the line of sight.
        view_angle: Full vertical angle [degrees].
    """

    eye: FloatArray
    focus: FloatArray
    up: FloatArray
    view_angle: float

    @classmethod
    def of(cls, camera: Any) -> Viewpoint:
        """Return the viewpoint of a PyVista camera."""
        return cls(camera.position, camera.focal_point, camera.up, float(camera.view_angle))

    def to(self, camera: Any) -> None:
        """Set a PyVista camera to this viewpoint."""
        camera.position = self.eye.tolist()
        camera.focal_point = self.focus.tolist()
        camera.up = self.up.tolist()
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
        """Distance from the eye to the focus [m]."""
        return float(np.linalg.norm(self.focus - self.eye))

    def ray(self, pixel: tuple[float, float], size: tuple[int, int]) -> CameraRay:
        """Return the ray through a pixel of a picture of this width and height [px]."""
        half = np.tan(np.radians(self.view_angle) / 2) / (size[1] / 2)
        direction = np.array([half * (pixel[0] - size[0] / 2), half * (size[1] / 2 - pixel[1]), 1.0]) @ self.axes
        return CameraRay(self.eye, direction / np.linalg.norm(direction))

    def in_front(self, points: FloatArray) -> BoolArray:
        """(k,) whether each of points (k, 3) [m] is in front of the eye, so that it has a pixel."""
        return np.asarray((np.atleast_2d(points) - self.eye) @ self.axes[2] > 0)

    def pixels(self, points: FloatArray, size: tuple[int, int]) -> FloatArray:
        """(k, 2) pixels of points (k, 3) [m] in a picture of this size; NaN if not ``in_front``."""
        across, above, depth = ((np.atleast_2d(points) - self.eye) @ self.axes.T).T
        depth = np.where(depth > 0, depth, np.nan)
        scale = size[1] / 2 / np.tan(np.radians(self.view_angle) / 2) / depth
        return np.stack([size[0] / 2 + scale * across, size[1] / 2 - scale * above], axis=1)


def box_corners(bounds: FloatArray, pose: FloatArray) -> FloatArray:
    """(8, 3) corners [m], world, of a box (2, 3) in a frame with this pose (4, 4)."""
    return np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T @ pose[:3, :3].T + pose[:3, 3]


def framing(
    points: FloatArray,
    away: FloatArray,
    aspect: float,
    *,
    view_angle: float,
    fill: float,
    central: FloatArray | None = None,
) -> Viewpoint:
    """Return the closest viewpoint in a direction that shows all points, with z up.

    Each point must be inside four planes through the eye; the tightest pair of planes determines the distance, and
    the slack of the other pair is shared evenly.

    Args:
        points: (k, 3) [m], at least one.
        away: (3,) from the points to the eye; not along z.
        aspect: Width by height of the picture.
        view_angle: Vertical, full [degrees].
        fill: Fraction of the picture's width or height that the points may fill.
        central: (j, 3) points whose centre must be in the middle third of the picture [m]; None for no such points.
    """
    away = np.asarray(away, dtype=np.float64) / np.linalg.norm(away)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    axes = Viewpoint(middle + away, middle, np.array([0.0, 0.0, 1.0]), view_angle).axes
    slope = np.tan(np.radians(view_angle) / 2) * np.array([aspect, 1.0])
    seen = (points - middle) @ axes.T
    planes = [_planes(seen, fill * slope)]
    nearest = float(seen[:, 2].min()) - 1e-3
    if central is not None and len(central):
        core = (0.5 * (central.min(axis=0) + central.max(axis=0)) - middle) @ axes.T
        planes.append(_planes(core[None], _CENTRAL * slope))
        nearest = min(nearest, float(core[2]) - 1e-3)
    # From an eye at (x, y, depth) each side of the picture holds if low(depth) <= x <= high(depth), both linear.
    low, high = (np.concatenate([one[k] for one in planes]) for k in (0, 1))
    pairs = [(low[low[:, 0] == k, 1:].T, high[high[:, 0] == k, 1:].T) for k in (0, 1)]
    depth = nearest
    for (slope_low, low_at), (slope_high, high_at) in pairs:
        slack = (high_at - low_at[:, None]) / (slope_low[:, None] + slope_high)
        depth = min(depth, float(slack.min()))
    eye = np.array([0.0, 0.0, depth])
    for k, ((slope_low, low_at), (slope_high, high_at)) in enumerate(pairs):
        eye[k] = 0.5 * ((low_at + slope_low * depth).max() + (high_at - slope_high * depth).min())
    ahead_of_eye = max(float(seen[:, 2].mean()) - depth, 1e-3)
    place = eye @ axes + middle
    return Viewpoint(place, place + ahead_of_eye * axes[2], np.array([0.0, 0.0, 1.0]), view_angle)


def _planes(seen: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds of the eye's position from points (k, 3) in the picture's axes: rows axis, slope, offset.

    An eye at depth d is above ``offset + slope d`` of the lower bounds and below ``offset - slope d`` of the upper.
    """
    low = []
    high = []
    for k in (0, 1):
        low.append([k, slope[k], float((seen[:, k] - slope[k] * seen[:, 2]).max())])
        high.append([k, slope[k], float((seen[:, k] + slope[k] * seen[:, 2]).min())])
    return np.array(low), np.array(high)


_CENTRAL = 1 / 3 - 0.05
"""Fraction of the picture for the centre of the central points; less than a third, because they move."""
_LOWEST = np.radians(-85)
_HIGHEST = np.radians(88)
_TURN_PER_HEIGHT = 2 * np.pi / 1.5


def orbit(view: Viewpoint, dx: float, dy: float, height: int) -> Viewpoint:
    """Turn about the focus by pixels dragged in a view of this height; z stays up, the poles are not crossed."""
    away = view.eye - view.focus
    azimuth = np.arctan2(away[1], away[0]) - _TURN_PER_HEIGHT * dx / height
    elevation = np.arcsin(np.clip(away[2] / view.distance, -1, 1)) + _TURN_PER_HEIGHT * dy / height
    return _seen_from(view, azimuth, elevation)


def look_from(view: Viewpoint, normal: FloatArray) -> Viewpoint:
    """Look at the focus from the side of ``normal`` (3,), as close to it as the poles allow; z stays up.

    From above or below, the azimuth is kept.
    """
    x, y, _ = normal if np.abs(normal[:2]).max() > 1e-9 else view.eye - view.focus
    return _seen_from(view, np.arctan2(y, x), np.arcsin(np.clip(normal[2] / np.linalg.norm(normal), -1, 1)))


def _seen_from(view: Viewpoint, azimuth: float, elevation: float) -> Viewpoint:
    elevation = np.clip(elevation, _LOWEST, _HIGHEST)
    flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    direction = np.cos(elevation) * flat + np.array([0.0, 0.0, np.sin(elevation)])
    return replace(view, eye=view.focus + view.distance * direction, up=np.array([0.0, 0.0, 1.0]))


def pan(view: Viewpoint, dx: float, dy: float, height: int) -> Viewpoint:
    """Move eye and focus together, so that points at the focus's depth follow the pointer."""
    right, up, _ = view.axes
    pixel = 2 * view.distance * np.tan(np.radians(view.view_angle) / 2) / height
    step = pixel * (dy * up - dx * right)
    return replace(view, eye=view.eye + step, focus=view.focus + step)


def zoom(view: Viewpoint, factor: float) -> Viewpoint:
    """Move closer to the focus by ``factor`` (> 1) or away (< 1), between 2 cm and 100 m."""
    distance = float(np.clip(view.distance / factor, 0.02, 100.0))
    return replace(view, eye=view.focus + (view.eye - view.focus) * (distance / view.distance))
