"""The cube in the corner shows the faces that look at the eye, and names those that can be read."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.robot.actors.camera import Viewpoint
from tactile_widgets.views.robot.caption_overlay import cube_faces


def faces_from(*eye):
    return cube_faces(Viewpoint(np.array(eye, dtype=float), np.zeros(3), np.array([0.0, 0.0, 1.0]), 30.0).axes)


def test_view_along_the_axis_shows_one_square():
    (face,) = faces_from(3, 0, 0)
    assert face.name == "X"
    assert face.facing == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(np.abs(face.corners), axis=None), np.ones(8))


def test_three_quarters_there_are_three_named_faces():
    assert {face.name for face in faces_from(1, -1, 0.8)} == {"X", "−Y", "Z"}


def test_a_slanted_face_is_not_named():
    names = {round(face.facing, 1): face.name for face in faces_from(1, -0.1, 0)}
    assert names == {1.0: "X", 0.1: ""}


def test_the_top_is_drawn_above_and_x_to_the_right_seen_from_the_front():
    faces = {face.name: face.corners.mean(axis=0) for face in faces_from(1, -1, 0.8)}
    assert faces["Z"][1] < min(faces["X"][1], faces["−Y"][1])
    assert faces["X"][0] > faces["−Y"][0]
