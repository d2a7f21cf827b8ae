"""Moving a camera by hand: orbit, pan and zoom, as arithmetic on a PyVista camera. No Qt."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.arrays import FloatArray

_LOWEST, _HIGHEST = np.radians(-85), np.radians(88)


def orbit(camera: Any, dx: float, dy: float, height: int) -> None:
    """Turn about the focal point by pixels dragged; z stays up and the poles are not crossed."""
    away = np.array(camera.position) - camera.focal_point
    distance = float(np.linalg.norm(away))
    turn = 2 * np.pi * np.array([dx, dy]) / (1.5 * height)
    azimuth = np.arctan2(away[1], away[0]) - turn[0]
    elevation = float(np.clip(np.arcsin(away[2] / distance) + turn[1], _LOWEST, _HIGHEST))
    direction = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    camera.position = np.array(camera.focal_point) + distance * np.array(direction)
    camera.up = (0.0, 0.0, 1.0)


def pan(camera: Any, dx: float, dy: float, height: int) -> None:
    """Move eye and focal point together, so that what is at the focal point's depth follows the pointer."""
    forward, right, up, distance = _frame(camera)
    del forward
    pixel = 2 * distance * np.tan(np.radians(camera.view_angle) / 2) / height
    step = pixel * (dy * up - dx * right)
    camera.focal_point, camera.position = camera.focal_point + step, camera.position + step


def zoom(camera: Any, factor: float, *, nearest: float = 0.02, farthest: float = 100.0) -> None:
    """Go closer by ``factor`` (> 1) or away (< 1), towards the focal point [m]."""
    away = np.array(camera.position) - camera.focal_point
    distance = float(np.linalg.norm(away))
    wanted = float(np.clip(distance / factor, nearest, farthest))
    camera.position = camera.focal_point + away * (wanted / distance)


def _frame(camera: Any) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Forward, right and up unit vectors, and the distance to the focal point [m]."""
    forward = np.array(camera.focal_point) - camera.position
    distance = float(np.linalg.norm(forward))
    forward = forward / distance
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    return forward, right, np.cross(right, forward), distance
