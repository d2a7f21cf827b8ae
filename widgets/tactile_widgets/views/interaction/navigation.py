"""Mouse buttons that move the camera, in the styles of several programs."""

from __future__ import annotations

from enum import Enum, auto

from PySide6.QtCore import Qt

from tactile_widgets.common.settings import NavigationStyle

_ZOOM_A_PIXEL = 1.005


class CameraMotion(Enum):
    """Motion of the camera by a drag."""

    TURN = auto()
    PAN = auto()
    ZOOM = auto()


def motion_of(style: NavigationStyle, button: Qt.MouseButton, keys: Qt.KeyboardModifier) -> CameraMotion:
    """Return the motion for a button; the left one moves the camera where it does not touch the skin."""
    shift = bool(keys & Qt.KeyboardModifier.ShiftModifier)
    control = bool(keys & Qt.KeyboardModifier.ControlModifier)
    if button == Qt.MouseButton.LeftButton:
        return CameraMotion.PAN if shift else CameraMotion.TURN
    right = button == Qt.MouseButton.RightButton
    if style is NavigationStyle.MUJOCO:
        return CameraMotion.PAN if right else CameraMotion.ZOOM
    if style is NavigationStyle.BLENDER and not right:
        return CameraMotion.PAN if shift else CameraMotion.ZOOM if control else CameraMotion.TURN
    return CameraMotion.TURN if right else CameraMotion.PAN


def zoom_by(pixels: float) -> float:
    """Return the zoom factor of a vertical drag [px]; upwards zooms in."""
    return float(_ZOOM_A_PIXEL**-pixels)
