"""A hand on a real robot view: what it emits, where skin is, what it looks like."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.robot.robot_view import RobotView
from tests.widgets.support.heard import Heard
from tests.widgets.support.mouse import left_click

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
BESIDE = QPoint(4, 4)
PICTURE = (320, 280)
"""Width and height of a scene on a plain plotter [pixels]."""


def open_view(qtbot) -> RobotView:
    """Return an empty view on the screen; the caller closes it."""
    view = RobotView(DARK, PressureScale())
    qtbot.addWidget(view)
    view.resize(480, 400)
    view.show()
    qtbot.waitExposed(view)
    return view


def skin_pixel(view, prepared) -> QPoint:
    """A pixel on the skin with skin all around it."""
    eye = view.display.actors.viewpoint.eye
    poses = view.display.actors.poses
    for taxel in range(len(prepared.skin)):
        at = prepared.skin.taxel_point(taxel)
        pose = poses[prepared.robot.link_index[prepared.skin.link(at)]]
        towards = eye - (pose[:3, :3] @ prepared.skin.position(at) + pose[:3, 3])
        if pose[:3, :3] @ prepared.skin.normal(at) @ towards > 0.9 * np.linalg.norm(towards):
            return view.display.pixel_of(at).toPoint()
    pytest.fail("no taxel faces the eye")


def pressed_frame(view, prepared, skin):
    """A frame in which a finger has pressed for half a second at a skin pixel."""
    heard = Heard(view)
    left_click(view.display.canvas.widget, skin)
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(0, heard.acts[0][1]))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session.frame


def picture(view):
    view.display.draw_now()
    return view.grab().toImage()
