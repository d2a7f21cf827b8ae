"""Moving the eye by hand: orbit, pan and zoom, from one viewpoint to the next. Knows neither Qt nor VTK."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.arrays import FloatArray
from widgets.robot_view.viewpoint import Viewpoint

_LOWEST, _HIGHEST = np.radians(-85), np.radians(88)
_TURN_PER_HEIGHT = 2 * np.pi / 1.5


def orbit(view: Viewpoint, dx: float, dy: float, height: int) -> Viewpoint:
    """Turn about the focus by pixels dragged in a view of this height; z stays up, the poles are not crossed."""
    away = view.eye - view.focus
    azimuth = np.arctan2(away[1], away[0]) - _TURN_PER_HEIGHT * dx / height
    elevation = np.arcsin(np.clip(away[2] / view.distance, -1, 1)) + _TURN_PER_HEIGHT * dy / height
    elevation = np.clip(elevation, _LOWEST, _HIGHEST)
    flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    direction = np.cos(elevation) * flat + np.array([0.0, 0.0, np.sin(elevation)])
    return replace(view, eye=view.focus + view.distance * direction, up=np.array([0.0, 0.0, 1.0]))


def face(view: Viewpoint, normal: FloatArray) -> Viewpoint:
    """Look at the focus from the side that ``normal`` (3,) points to, as near to it as the poles allow; z stays up.

    Seen from above or below, the way round is kept.
    """
    away = view.eye - view.focus
    azimuth = np.arctan2(normal[1], normal[0]) if np.abs(normal[:2]).max() > 1e-9 else np.arctan2(away[1], away[0])
    elevation = np.clip(np.arcsin(np.clip(normal[2] / np.linalg.norm(normal), -1, 1)), _LOWEST, _HIGHEST)
    flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    direction = np.cos(elevation) * flat + np.array([0.0, 0.0, np.sin(elevation)])
    return replace(view, eye=view.focus + view.distance * direction, up=np.array([0.0, 0.0, 1.0]))


def pan(view: Viewpoint, dx: float, dy: float, height: int) -> Viewpoint:
    """Move eye and focus together, so that what is as deep as the focus follows the pointer."""
    right, up, _ = view.axes
    pixel = 2 * view.distance * np.tan(np.radians(view.view_angle) / 2) / height
    step = pixel * (dy * up - dx * right)
    return replace(view, eye=view.eye + step, focus=view.focus + step)


def zoom(view: Viewpoint, factor: float, *, nearest: float = 0.02, farthest: float = 100.0) -> Viewpoint:
    """Go closer to the focus by ``factor`` (> 1) or away (< 1), within these distances [m]."""
    distance = float(np.clip(view.distance / factor, nearest, farthest))
    return replace(view, eye=view.focus + (view.eye - view.focus) * (distance / view.distance))
