"""Rows of Jacobians and errors of one contact."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.task_contact import Want
from tests.unit.control.touched import TO_MAP, contact, touch


def test_outward_is_the_normal_s_share_of_motion():
    assert contact().outward == pytest.approx([8, 9, 10, 11])


def test_map_axes_lie_along_the_skin_as_the_map_s_do_and_are_square_to_each_other():
    axes = contact().map_axes
    assert axes @ axes.T == pytest.approx(np.eye(2))
    assert axes @ contact().normal == pytest.approx([0, 0])
    stretch = TO_MAP @ axes.T
    assert stretch == pytest.approx(stretch.T), "what is left of the map is stretch without a turn"


def test_the_skin_goes_the_other_way_so_that_the_contact_comes_where_it_should():
    mine = contact(np.array([0.01, -0.02]), (0.003, 0.004))
    skin = mine.along(5.0, 1.0)
    assert -TO_MAP @ skin == pytest.approx(5.0 * mine.error + mine.velocity)
    assert skin @ mine.normal == pytest.approx(0)
    slow = mine.along(5.0, 0.01)
    assert np.linalg.norm(slow) == pytest.approx(0.01)
    assert np.cross(slow, skin) == pytest.approx(np.zeros(3), abs=1e-12)
    assert not contact().along(5.0, 1.0).any(), "one that may slide is not moved along"


def test_a_want_leaves_place_open_unless_it_says():
    want = Want(touch(1.0)[0], 3.0)
    assert want.error is None
    assert want.velocity is None
