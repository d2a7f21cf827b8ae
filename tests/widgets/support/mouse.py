"""Mouse gestures in tests, at the middle of a widget unless a pixel is given."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

_LEFT = Qt.MouseButton.LeftButton


def left_click(widget, at=None):
    QTest.mouseClick(widget, _LEFT, pos=at or QPoint())


def left_double_click(widget, at=None):
    QTest.mouseDClick(widget, _LEFT, pos=at or QPoint())


def left_press(widget, at=None):
    QTest.mousePress(widget, _LEFT, pos=at or QPoint())


def left_release(widget, at=None):
    QTest.mouseRelease(widget, _LEFT, pos=at or QPoint())


def left_drag(widget, start, *path):
    """Press at ``start``, move along the pixels of ``path``, and release at the last one."""
    left_press(widget, start)
    for pixel in path:
        QTest.mouseMove(widget, pixel)
    left_release(widget, path[-1])


def turn_wheel(widget, at=None, notches=1.0, keys=Qt.KeyboardModifier.NoModifier):
    """Turn the wheel; widgets that ignore it pass it to their parents. Return the event."""
    place = QPointF(widget.rect().center() if at is None else at)
    turn = QPoint(0, round(120 * notches))
    phase = Qt.ScrollPhase.NoScrollPhase
    button = Qt.MouseButton.NoButton
    event = QWheelEvent(place, widget.mapToGlobal(place), QPoint(), turn, button, keys, phase, False)
    QApplication.sendEvent(widget, event)
    return event
