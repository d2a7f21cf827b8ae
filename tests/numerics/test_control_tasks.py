"""The laws at their tasks on the whole arm beside a ball that stands still; ``hard_control`` has the hard cases."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlChanged, ControlSettings
from app.control.laws import RULES
from app.control.reference import MAX_JOINT_SPEED
from tests.numerics.pressed_arm import TICK, Course, beside_ball


def bounded(course: Course) -> None:
    assert np.isfinite(course.force).all()
    assert course.pressed.max() < 40.0
    assert course.speed.max() < 2 * MAX_JOINT_SPEED


@pytest.mark.parametrize("law", RULES)
def test_a_path_is_followed_at_a_set_force(law):
    """A figure of eight of 30 mm at 10 mm/s: the taxels' pitch of 12 mm is most of the error."""
    course = Course(beside_ball(ControlSettings(law=law, task="follow_path")), 10.0)
    bounded(course)
    steady = slice(round(2.0 / TICK), None)
    assert course.force[steady].mean() == pytest.approx(3.0, abs=0.1)
    assert course.force[steady].std() < 0.3
    assert np.nanmedian(course.body_error[steady]) < 0.002
    assert np.nanpercentile(course.body_error[steady], 95) < 0.008
    assert "contact lost" not in course.why


@pytest.mark.parametrize("law", ["hybrid", "qp"])
def test_a_faster_path_lags_more_and_stays_bounded(law):
    slow, fast = (
        Course(beside_ball(ControlSettings(law=law, task="follow_path", path_speed=speed)), 10.0)
        for speed in (0.01, 0.03)
    )
    bounded(fast)
    assert np.nanmedian(fast.error[400:]) > 1.5 * np.nanmedian(slow.error[400:])


@pytest.mark.parametrize("law", RULES)
def test_a_point_drawn_elsewhere_is_reached_and_held(law):
    session = beside_ball(ControlSettings(law=law, task="hold_point"))
    here = session.tick().regions[0].map_point
    target = (float(here[0]) + 0.012, float(here[1]) + 0.009)
    session.submit(ControlChanged(ControlSettings(law=law, task="hold_point", path=(target,))))
    course = Course(session, 6.0)
    bounded(course)
    assert course.error[0] > 0.012
    assert course.error[-1] < 0.002
    assert course.force[-1] == pytest.approx(3.0, abs=0.1)
