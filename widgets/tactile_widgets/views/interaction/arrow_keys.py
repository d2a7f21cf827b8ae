"""Displacements on the map by arrow keys."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent

from tactile_maps.core.arrays import FloatArray

STEP = 1e-3
FINE_STEP = 1e-4
"""Distance an arrow key moves a pin, the target or a path [m], and with Shift."""
ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}
"""Direction (2,) on the map of each arrow key."""


def nudge_of(event: QKeyEvent) -> FloatArray | None:
    """Return the displacement (2,) on the map of an arrow key [m]; None for other keys."""
    arrow = ARROWS.get(Qt.Key(event.key()))
    fine = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
    return None if arrow is None else (FINE_STEP if fine else STEP) * np.array(arrow)
