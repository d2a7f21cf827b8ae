"""The laws at their tasks on the whole arm beside a ball that stands still: what arrives, and what stays bounded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlChanged, ControlSettings
from app.control.laws import RULES
from app.control.reference import MAX_JOINT_SPEED
from app.session.session import Session
from app.touch.poke import Finger, PokePressed
from tests.numerics.pressed_arm import TICK, Course, beside_ball, forearm


def bounded(course: Course, *, force=40.0) -> None:
    assert np.isfinite(course.force).all()
    assert course.force.max() < force
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


@pytest.mark.parametrize("law", RULES)
def test_a_contact_that_leaves_is_sought_and_held_again(law):
    """The ball goes 5 mm away and comes back: no kick, no windup."""
    course = Course(beside_ball(ControlSettings(law=law), leaves=True), 8.0)
    bounded(course, force=25.0)
    assert "contact lost" in course.why
    assert course.force[round(1.8 / TICK)] == pytest.approx(3.0, abs=0.1)
    assert course.force[-1] == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
@pytest.mark.parametrize("law", RULES)
def test_soft_and_hard_covers_are_held(law, stiffness):
    course = Course(beside_ball(ControlSettings(law=law), stiffness=stiffness), 4.0)
    bounded(course, force=60.0)
    assert course.force[-200:] == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("law", ["hybrid", "qp"])
def test_friction_sticks_and_slips_within_bounds(law, friction):
    course = Course(beside_ball(ControlSettings(law=law, task="follow_path"), friction=friction), 8.0)
    bounded(course)
    assert course.force[400:].mean() == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("law", RULES)
def test_a_path_that_leaves_the_skin_ends_at_its_border(law):
    session = beside_ball(ControlSettings(law=law, task="follow_path"))
    here = session.tick().regions[0].map_point
    far = tuple(map(float, here + [0.0, 1.0]))
    line = (tuple(map(float, here)), far)
    settings = ControlSettings(law=law, task="follow_path", path_kind="polyline", path=line, path_speed=0.03)
    session.submit(ControlChanged(settings))
    course = Course(session, 8.0)
    bounded(course)
    assert "the path leaves the skin" in course.why


@pytest.mark.parametrize("before", RULES)
def test_laws_change_in_mid_contact_without_a_jump(before):
    session = beside_ball(ControlSettings(law=before, task="hold_point"))
    Course(session, 2.0)
    for after in ("impedance", *RULES, "hold_force", before):
        was = session.tick().regions[0].force
        session.submit(ControlChanged(replace(session.settings, law=after)))
        course = Course(session, 0.1)
        steps = np.abs(np.diff([was, *course.force]))
        assert steps.max() < 0.25, f"{after}: the torque goes on, and the law moves from there"
        if after == "impedance":
            continue
        assert Course(session, 2.0).force[-1] == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("law", RULES)
def test_too_strong_a_hand_stops_the_arm_which_yields_softly(law):
    session = Session(forearm(), settings=ControlSettings(law=law, max_force=5.0, force_gain=0.001))
    session.submit(PokePressed(1, forearm().skin.taxel_point(150), Finger(speed=0.03, max_force=15.0)))
    course = Course(session, 2.0)
    assert any(why.startswith("stopped: ") for why in course.why)
    assert course.force.max() < 16.0
    assert course.speed.max() < MAX_JOINT_SPEED


@pytest.mark.parametrize("law", RULES)
def test_a_finger_that_tracks_its_place_cannot_lead_the_arm_away(law):
    """It can never come to another point of the map: the arm notices, and keeps the force alone."""
    prepared = forearm()
    session = Session(prepared, settings=ControlSettings(law=law, task="hold_point"))
    session.submit(PokePressed(1, prepared.skin.taxel_point(150), Finger(speed=0.01, max_force=8.0)))
    Course(session, 1.0)
    target = tuple(map(float, session.frame.regions[0].map_point + [0.02, 0.02]))
    session.submit(ControlChanged(replace(session.settings, path=(target,))))
    Course(session, 2.0)
    posture = session.frame.posture
    course = Course(session, 3.0)
    bounded(course)
    assert "the contact goes along with the skin" in course.why
    assert np.abs(session.frame.posture - posture).max() < 0.1


def test_a_straight_elbow_keeps_the_force_and_the_bounds():
    """Every joint at zero: the arm is stretched, and some directions are out of its reach."""
    prepared = forearm()
    for law in RULES:
        session = Session(prepared, settings=ControlSettings(law=law, task="hold_point"))
        session._controller.rest = np.clip(np.zeros(7), [j.lower for j in prepared.robot.joints],
                                           [j.upper for j in prepared.robot.joints])  # fmt: skip
        Course(session, 3.0)
        session.submit(PokePressed(1, prepared.skin.taxel_point(150), Finger(speed=0.01, max_force=10.0)))
        course = Course(session, 3.0)
        bounded(course, force=12.0)
        assert course.force[-1] > 0.5, law


@pytest.mark.parametrize("law", RULES)
def test_two_hands_are_balanced(law):
    prepared = forearm()
    session = Session(prepared, settings=ControlSettings(law=law, task="balance"))
    points = prepared.map.taxel_points
    other = int(np.argsort(np.linalg.norm(points - points[150], axis=1))[60])
    for finger, taxel, most in ((1, 150, 6.0), (2, other, 2.0)):
        session.submit(PokePressed(finger, prepared.skin.taxel_point(taxel), Finger(speed=0.01, max_force=most)))
    course = Course(session, 4.0)
    bounded(course)
    forces = sorted(region.force for region in session.frame.regions)
    assert len(forces) == 2
    assert forces[1] - forces[0] < 3.0, "nearer to each other than the hands would be"


def test_the_same_session_gives_the_same_numbers():
    runs = [Course(beside_ball(ControlSettings(law="qp", task="follow_path")), 2.0).force for _ in range(2)]
    assert np.array_equal(*runs)
