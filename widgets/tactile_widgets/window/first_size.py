"""The window's first size and place: what a desk has room for, frame included, at any scale."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSize
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMainWindow

WANTED = QSize(1400, 900)
_FRAME = QSize(16, 48)
"""Of a window's frame and title bar, which nobody knows before it is shown [px]: as large as desks have them."""


def first_rectangle(room: QRect) -> QRect:
    """Where the window goes at first, without its frame.

    Args:
        room: Of the screen, free of bars, in the screen's logical pixels.

    Returns:
        The wanted size where it fits with a frame, else as much as fits; in the middle of ``room``.
    """
    size = WANTED.boundedTo(room.size() - _FRAME)
    place = QRect(room.topLeft(), size)
    place.moveCenter(room.center())
    place.moveTop(max(place.top(), room.top() + _FRAME.height() - _FRAME.width() // 2))
    return place


def fit_screen(window: QMainWindow) -> None:
    """Give the window its first size and place; the wanted size where there is no screen to ask."""
    screen = window.screen() or QGuiApplication.primaryScreen()
    if screen is None or QGuiApplication.platformName() == "offscreen":
        window.resize(WANTED)
    else:
        window.setGeometry(first_rectangle(screen.availableGeometry()))
