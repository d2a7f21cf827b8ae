"""The force along the skin as goal and as cap, on the simulated arm."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.task_priority import TaskContact
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tests.support.limits import kinds

CONTROLLERS = ("hybrid", "parallel", "priority", "qp")
DOWN = (1.2, 0.24, 0.08, 0.69)


@cache
def ball_on_forearm(path):
    """The arm with a ball that is moved along a path [s, m], on a skin that measures shear."""
    scene = load_scene("slip")
    ball = replace(scene.objects[0], path=((0.0, 0.24, 0.08, 0.76), DOWN, *path))
    return prepare_cached(replace(scene, objects=(ball,), control={}))


def shear_on_map(prepared, frame):
    """(2,) force of the only contact along the axes of the map [N]."""
    (region,) = frame.regions
    configuration = Configuration(prepared.robot)
    configuration.update(frame.posture)
    to_map = MapKinematics(prepared.map).jacobian(region.at, "smoothed", configuration)
    axes = TaskContact(1, 0.0, 0.0, np.zeros(3), np.zeros(3), np.zeros((3, 7)), to_map, None, np.zeros(2)).map_axes
    return axes @ configuration.pose(region.link).rotation @ region.shear.force


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_shear_and_force_reach_their_goals_in_size_and_direction(controller):
    prepared = ball_on_forearm(((20.0, *DOWN[1:]),))
    settings = ControlSettings(controller, force_goal=4.0, shear_goal=1.0, shear_direction=0.5)
    frame = Session(prepared, settings=settings).run_for(3.2)
    assert frame.regions[0].force == pytest.approx(4.0, abs=0.05)
    assert shear_on_map(prepared, frame) == pytest.approx([np.cos(0.5), np.sin(0.5)], abs=0.05)
    assert LimitKind.SHEAR_GOAL_LIMITED not in kinds(frame.why_limited)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_arm_yields_to_a_ball_that_is_pulled_with_more_than_the_limit(controller):
    """The ball moves 30 mm at 10 mm/s; without a limit the shear reaches its friction of 2 N."""
    prepared = ball_on_forearm(((1.8, *DOWN[1:]), (4.8, 0.27, 0.08, 0.69), (9.0, 0.27, 0.08, 0.69)))
    largest = {}
    for most in (0.6, float("inf")):
        session = Session(
            prepared, settings=ControlSettings(controller, force_goal=4.0, force_gain=0.02, max_shear=most)
        )
        session.run_for(1.8)
        frames = [session.tick() for _ in range(round(3.0 / 0.005))]
        largest[most] = max(np.linalg.norm(region.shear.force) for frame in frames for region in frame.regions)
        assert any(LimitKind.SHEAR_CAP in kinds(frame.why_limited) for frame in frames) == (most < 1)
    assert largest[0.6] < 0.6 + 1.0 < largest[float("inf")], largest


def guided(threshold):
    """Way of the forearm [m], mean force of the hand along the skin on it [N], and the last normal force [N]."""
    scene = load_scene("guided_by_hand")
    settings = replace(settings_from(scene.control), shear_threshold=threshold)
    session = Session(prepare_cached(scene), settings=settings)
    posture = session.run_for(2.0).posture
    frames = [session.tick() for _ in range(round(2.0 / 0.005))]
    start, end = Configuration(session.prepared.robot), Configuration(session.prepared.robot)
    start.update(posture)
    end.update(frames[-1].posture)
    way = end.pose("forearm").translation - start.pose("forearm").translation
    pull = np.mean([np.linalg.norm(region.shear.force) for frame in frames for region in frame.regions])
    return way[0], pull, frames[-1].regions[0].force


@pytest.mark.long
def test_hand_that_drags_the_skin_needs_less_force_where_shear_is_measured():
    """The force times the way of 60 mm is the effort; without shear the arm follows the place of the sliding hand."""
    way, pull, force = guided(0.3)
    _, usual, _ = guided(float("inf"))
    assert way == pytest.approx(0.06, abs=0.012)
    assert force == pytest.approx(3.0, abs=0.3)
    assert pull < 0.6 * usual
