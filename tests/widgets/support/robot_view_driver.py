"""A hand on a real robot view: what it emits, where skin is, what it looks like, the wheel."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.robot.robot_view import RobotView

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


class Heard:
    """Remembers what a view emitted."""

    def __init__(self, view):
        self.acts = []
        self.hovers = []
        self.drawn = []
        view.interaction.poke_pressed.connect(self._on_pressed)
        view.interaction.poke_moved.connect(self._on_moved)
        view.interaction.poke_released.connect(self._on_released)
        view.interaction.hovered.connect(self.hovers.append)
        view.display.drawn.connect(self.drawn.append)

    def _on_pressed(self, at):
        self.acts.append(("pressed", at))

    def _on_moved(self, at):
        self.acts.append(("moved", at))

    def _on_released(self):
        self.acts.append(("released", None))

    @property
    def kinds(self):
        return [kind for kind, _ in self.acts]


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
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(0, heard.acts[0][1]))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session.frame


def picture(view):
    view.display.draw_now()
    return view.grab().toImage()


def wheel(view, notches):
    place = QPointF(view.rect().center())
    event = QWheelEvent(
        place,
        view.mapToGlobal(place),
        QPoint(),
        QPoint(0, 120 * notches),
        Qt.MouseButton.NoButton,
        NONE,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(view.display.canvas.widget, event)
