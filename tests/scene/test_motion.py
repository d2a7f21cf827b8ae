"""Motion through waypoints: the closed form, smooth at every join, and never outside the robot's limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.robots.model.robot import Joint, Robot
from tactile_maps.scene.motion import Motion, Waypoint

ROBOT = Robot(
    "r",
    "by hand",
    "",
    {},
    (),
    (Joint("a", -2.0, 2.0), Joint("b", -math.inf, math.inf), Joint("s", 0.0, 0.5, slide=True)),
    np.array([0.1, 0.2, 0.3]),
)


def test_motion_without_waypoints_stays_at_home():
    motion = Motion(ROBOT, ())
    assert motion.period == 0.0
    assert np.array_equal(motion.posture(7.0), ROBOT.home)


def test_motion_between_waypoints_is_the_minimum_jerk_polynomial():
    motion = Motion(ROBOT, [Waypoint((1.1, 0.2, 0.3), seconds=2.0)])
    for share in np.linspace(0, 1, 11)[:-1]:
        expected = 0.1 + 1.0 * (10 * share**3 - 15 * share**4 + 6 * share**5)
        assert motion.posture(2.0 * share) == pytest.approx([expected, 0.2, 0.3])


def test_motion_rests_and_repeats_from_the_last_waypoint():
    motion = Motion(ROBOT, [Waypoint({"a": 1.0}, seconds=1.0, rest=0.5), Waypoint({"a": -1.0, "s": 0.5}, seconds=2.0)])
    assert motion.period == 3.5
    assert motion.posture(0.0) == pytest.approx(ROBOT.home)
    assert motion.posture(1.2) == pytest.approx([1.0, 0.2, 0.3])
    assert motion.posture(2.5) == pytest.approx([0.0, 0.2, 0.4])
    assert motion.posture(3.5) == pytest.approx([-1.0, 0.2, 0.5])
    assert motion.posture(4.0) == pytest.approx([0.0, 0.2, 0.4], abs=1e-9), "b stays"
    assert motion.posture(35.0 + 1.2) == pytest.approx(motion.posture(3.5 + 1.2))


def test_position_speed_and_acceleration_are_continuous():
    motion = Motion(ROBOT, [Waypoint({"a": 1.0}, seconds=1.0), Waypoint({"a": -1.0}, seconds=2.0, rest=0.2)])
    step = 1e-3
    times = np.arange(0.0, 2 * motion.period, step)
    path = np.array([motion.posture(time)[0] for time in times])
    speed = np.diff(path) / step
    jerk = np.diff(path, 3) / step**3
    assert np.abs(speed).max() == pytest.approx(1.875 * 2.0 / 1.0, rel=0.01), "15/8 of the mean"
    assert np.abs(jerk).max() < 1.1 * 60 * 2.0, "the jerk is that of the polynomial everywhere"


def test_degrees_apply_to_hinges_only():
    motion = Motion(ROBOT, [Waypoint((90.0, 360.0, 0.4), seconds=1.0, rest=1.0, unit="deg")])
    assert motion.posture(1.5) == pytest.approx([math.pi / 2, 2 * math.pi, 0.4])


@pytest.mark.parametrize(
    ("posture", "unit", "words"),
    [
        ({"aa": 1.0}, "rad", "no such joint.*aa.*Did you mean a"),
        ((1.0,), "rad", "one number per joint.*Give 3"),
        ({"a": 2.5}, "rad", "motion.0.posture.a.*2.5.*-2 to 2 rad"),
        ({"a": 120.0}, "deg", "-114.6 to 114.6 deg"),
        ({"s": 0.6}, "deg", "0 to 0.5 m"),
    ],
)
def test_waypoint_outside_the_limits_is_rejected(posture, unit, words):
    with pytest.raises(SceneError, match=words):
        Motion(ROBOT, [Waypoint(posture, unit=unit)])


@pytest.mark.parametrize(
    "bad",
    [{"seconds": 0.0}, {"seconds": math.nan}, {"rest": -1.0}, {"posture": (math.inf,)}, {"posture": {"a": math.nan}}],
)
def test_waypoint_with_invalid_numbers_is_rejected(bad):
    with pytest.raises(SceneError, match=f"motion.{next(iter(bad))}"):
        replace(Waypoint(), **bad)


SLOW = replace(ROBOT, joints=(replace(ROBOT.joints[0], max_speed=0.5), *ROBOT.joints[1:]))


@pytest.mark.parametrize(
    ("ways", "words"),
    [
        ([Waypoint({"a": 1.1}, seconds=3.7)], r"motion\.0\.seconds: the joint a would be faster .*0\.5 rad.*3\.75 s"),
        ([Waypoint({"a": 0.1}, seconds=9.0), Waypoint({"a": 1.1}, seconds=3.7)], r"motion\.1\.seconds"),
        ([Waypoint({"a": 0.2}, seconds=1.0), Waypoint({"a": 1.9}, seconds=9.0)], r"motion\.0\.seconds"),
    ],
)
def test_motion_faster_than_the_model_allows_is_rejected(ways, words):
    with pytest.raises(SceneError, match=words):
        Motion(SLOW, ways)
    Motion(ROBOT, ways)


def test_motion_within_the_speeds_of_the_model_is_accepted():
    motion = Motion(SLOW, [Waypoint({"a": 1.1}, seconds=3.75), Waypoint({"a": 0.6}, seconds=3.75)])
    path = np.array([motion.posture(time)[0] for time in np.arange(0.0, 15.0, 1e-3)])
    assert np.abs(np.diff(path)).max() / 1e-3 == pytest.approx(0.5, rel=1e-3)
