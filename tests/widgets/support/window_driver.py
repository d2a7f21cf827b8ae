"""What the window's tests do to it: let time pass, find skin to press, press it."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication


def run(window, seconds):
    """Let simulated time pass, and the window show it."""
    for _ in range(max(round(seconds / 0.2), 1)):
        window.live.runner.run_for(min(seconds, 0.2))
        window.live.pump()
        QApplication.processEvents()


def blow_up(live):
    """Let the physics diverge at the next tick, as real as it gets: the joints are as fast as no joint can be."""
    with live.runner.lock:
        live.runner.session._simulation._data.qvel[:] = 1e9
    live.runner.run_for(0.01)
    live.pump()
    assert live.runner.session.failure is not None


def visible_skin(window):
    """A place on the skin that the robot view shows unhidden, and its pixel there."""
    view, skin = window.robot_view, window.live.prepared.skin
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        pixel = view.pixel_of(at)
        near = [view.point_at(pixel + QPointF(x, y)) for x in (-4, 4) for y in (-4, 4)]
        # One that faces the eye, so that a pixel aside is little aside on the skin.
        if all(hit is not None and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
            return at, pixel.toPoint()
    raise AssertionError("no taxel can be seen")


def press_map(window, taxel):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(taxel)).toPoint()
    QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    return pixel
