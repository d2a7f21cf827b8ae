"""The cube in the corner shows the faces that look at the eye, and names those that can be read."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QWidget

from tactile_widgets.common.colours import LIGHT
from tactile_widgets.views.robot.actors.camera import Viewpoint
from tactile_widgets.views.robot.caption_overlay import CaptionOverlay, ForceCaption, cube_faces


def faces_from(*eye):
    return cube_faces(Viewpoint(np.array(eye, dtype=float), np.zeros(3), np.array([0.0, 0.0, 1.0]), 30.0).axes)


def test_view_along_an_axis_shows_one_face_of_the_cube():
    (face,) = faces_from(3, 0, 0)
    assert face.name == "X"
    assert face.facing == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(np.abs(face.corners), axis=None), np.ones(8))


def test_oblique_view_shows_three_named_faces_of_the_cube():
    assert {face.name for face in faces_from(1, -1, 0.8)} == {"X", "−Y", "Z"}


def test_slanted_face_is_not_named():
    names = {round(face.facing, 1): face.name for face in faces_from(1, -0.1, 0)}
    assert names == {1.0: "X", 0.1: ""}


def test_front_view_has_the_top_above_and_x_to_the_right():
    faces = {face.name: face.corners.mean(axis=0) for face in faces_from(1, -1, 0.8)}
    assert faces["Z"][1] < min(faces["X"][1], faces["−Y"][1])
    assert faces["X"][0] > faces["−Y"][0]


@pytest.mark.parametrize("degrees", [0, 30, 75, 90, 200])
def test_caption_of_a_force_begins_beyond_the_tail_of_its_arrow(qtbot, degrees):
    view = QWidget()
    qtbot.addWidget(view)
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    tip = np.array([300.0, 200.0])
    tail = tip + 40 * along
    box = CaptionOverlay(LIGHT, view)._spot(ForceCaption(np.array([tail, tip]), "12.3 N")).preferred
    covered = [box.contains(QPointF(*(tail + away * along))) for away in (-40.0, 0.0, 5.9, 6.1)]
    assert covered == [False, False, False, True]
