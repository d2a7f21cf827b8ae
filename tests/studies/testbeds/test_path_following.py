"""A contact with a ball that follows a path: start position, assumed skin, and true errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.maps.learned.as_tactile_map import learned_tactile_map
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.paths import path_about
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.testbeds.fixed_ball import BALL, DEPTH, place_to_press, points_above, with_fixed_ball
from tactile_maps.studies.testbeds.path_following import PathRun, PathSetup, TrueContact, run_path
from tactile_maps.tactile.sensors.sensor_effects import GainSpread, SensorEffects
from tests.control.robots.robot_models import RobotModel
from tests.support.generated_robots import chain, model
from tests.support.pressed_arm import forearm
from tests.support.touch import prepared_bar

BAR = prepared_bar()
HOME = np.zeros(1)


def over(at: SurfacePoint, height: float) -> np.ndarray:
    return BAR.skin.position(at) + height * BAR.skin.normal(at)


def test_error_of_a_ball_is_its_distance_from_the_target():
    truth = TrueContact(BAR.robot, BAR.skin, BAR.map)
    target = BAR.skin.taxel_point(20)
    assert truth.error(target, over(target, 0.03), HOME) == pytest.approx(0.0, abs=1e-9)
    assert truth.error(target, over(target, 0.03) + [0.004, 0.003, 0.0], HOME) == pytest.approx(0.005, abs=1e-9)


def test_path_on_a_misplaced_skin_is_at_the_same_material_place():
    believed = build_map(with_calibration_error(BAR.skin, 0.004, seed=1))
    truth = TrueContact(BAR.robot, BAR.skin, believed)
    target = BAR.skin.taxel_point(20)
    assert np.linalg.norm(believed.skin.position(target) - BAR.skin.position(target)) > 0.001, (
        "it is believed elsewhere"
    )
    assert truth.error(target, over(target, 0.03), HOME) == pytest.approx(0.0, abs=1e-9)


def test_points_of_a_learned_map_are_interpolated_between_its_taxels():
    points = BAR.map.taxel_points
    learned = learned_tactile_map(BAR.skin, LearnedMap(points, np.ones(len(points), dtype=bool), "by hand", 0.0, 0.0))
    truth = TrueContact(BAR.robot, BAR.skin, learned)
    target = learned.skin.taxel_point(20)
    here = over(BAR.skin.taxel_point(20), 0.03)
    assert truth.error(target, here, HOME) == pytest.approx(0.0, abs=1e-6)
    assert len(learned.skin.patches[0].surface.faces) != len(BAR.skin.patches[0].surface.faces)


def test_place_has_room_and_is_flat():
    prepared = forearm()
    taxel = place_to_press(prepared)
    taxels = prepared.skin.patches[0].taxels
    edges = np.concatenate([*prepared.map.outlines, *(seams.reshape(-1, 2) for seams in prepared.map.seams)])
    assert np.linalg.norm(edges - prepared.map.taxel_points[taxel], axis=1).min() > 0.02
    near = np.linalg.norm(taxels.positions - taxels.positions[taxel], axis=1) < 0.02
    assert (taxels.normals[near] @ taxels.normals[taxel]).min() > np.cos(np.radians(50))


@pytest.mark.long
def test_ball_is_pressed_in_by_its_depth_and_touches_at_once():
    prepared = forearm()
    displaced_ball = with_fixed_ball(prepared)
    taxel = place_to_press(prepared)
    (ball,) = displaced_ball.scene.objects
    assert np.allclose(ball.at, points_above(prepared, np.array([taxel]), BALL - DEPTH)[0])
    session = PathSetup(displaced_ball).session(ControlSettings())
    assert 0.5 < session.total_normal_force < 30.0
    (region,) = session.frame.regions
    assert np.linalg.norm(region.link_position - prepared.skin.position(prepared.skin.taxel_point(taxel))) < 0.008
    assert prepared.scene.objects == (), "the given robot is unchanged"


def caged_finger(folder: Path, posts: Sequence[int]) -> PreparedScene:
    """Return a straight finger, 10 mm wide, within those of 12 posts, 8 mm wide, on a circle of 20 mm."""
    angles = np.pi / 6 * np.array(posts)
    capsules = "".join(
        f'<body name="post{number}" pos="{0.02 * np.cos(angle):g} {0.02 * np.sin(angle):g} 0">'
        '<geom type="capsule" size=".004" fromto="0 0 0 0 0 .3"/></body>'
        for number, angle in enumerate(angles)
    )
    text = model(chain("xyyy", 0.05, ranges="-1.6 1.6") + capsules)
    finger = RobotModel("caged", text, links=("link4",), taxels=200, thickness=0.001).prepare(folder)
    return replace(finger, robot=replace(finger.robot, home=np.zeros(4)))


@pytest.mark.long
def test_ball_is_placed_clear_of_all_other_links(tmp_path):
    posts = range(4, 13)
    prepared = caged_finger(tmp_path, posts)
    taxel = place_to_press(prepared, radius=0.01)
    (centre,) = points_above(prepared, np.array([taxel]), 0.01)
    angles = np.pi / 6 * np.array(posts)
    away = np.hypot(*(centre[:2, None] - 0.02 * np.array([np.cos(angles), np.sin(angles)])))
    assert away.min() > 0.01 + 0.004
    with pytest.raises(SkinError, match="touches something else too .found: radius 40 mm.. Choose another posture"):
        place_to_press(prepared, radius=0.04)


def test_bare_robot_cannot_be_pressed():
    with pytest.raises(SkinError, match="no skin to press"):
        place_to_press(replace(forearm(), skin=Skin(())))


FOLLOW = ControlSettings(controller="hybrid", task="follow_path", path_speed=0.04, path_size=0.02)


@cache
def displaced_ball():
    return PathSetup(with_fixed_ball(forearm()))


@cache
def followed(speed=0.04) -> PathRun:
    return run_path(displaced_ball(), replace(FOLLOW, path_speed=speed), 6.0, settling=0.5)


@pytest.mark.long
def test_duration_of_a_round_is_its_length_over_the_speed():
    length = path_about("lemniscate", np.zeros(2), 0.02).length
    assert followed().finished == pytest.approx(length / 0.04, rel=0.03)
    assert len(followed().force) == round(followed().finished / followed().tick)
    assert followed().lost == 0.0
    assert followed().stopped == ""


@pytest.mark.long
def test_errors_are_measured_on_the_body_with_the_true_force():
    assert 0.0005 < followed().error_rms < followed().error_p95 < 0.012
    assert followed().force_p95(3.0) < 1.0
    assert followed().in_band(3.0, 1.0) > 0.95
    assert followed().in_band(6.0, 1.0) == 0.0
    assert 0.0 < followed().control_ms <= followed().control_p95_ms
    assert -0.5 < followed().energy_minimum <= 0.0
    assert 0.01 < followed().speed.max() < 2.0


@pytest.mark.long
def test_open_path_ends_at_its_other_end():
    line = run_path(displaced_ball(), replace(FOLLOW, path_kind="polyline"), 6.0, settling=0.5)
    assert line.finished == pytest.approx(0.02 / 0.04, rel=0.05)


@pytest.mark.long
def test_paths_slower_than_the_limit_are_unfinished():
    short = run_path(displaced_ball(), FOLLOW, 0.3, settling=0.2)
    assert short.finished is None
    assert len(short.force) == 60


@pytest.mark.long
def test_task_without_a_path_uses_its_whole_time():
    held = run_path(displaced_ball(), replace(FOLLOW, task="hold_point"), 0.5, settling=0.5)
    assert held.finished is None
    assert held.error_p95 < 0.01
    assert np.isfinite(held.map_error).all()


def test_stop_by_the_supervisor_ends_the_run():
    stopped = run_path(displaced_ball(), replace(FOLLOW, max_force=1.0), 3.0, settling=0.0)
    assert stopped.stopped.startswith("stopped: contact force too high: ")
    assert stopped.finished is None
    assert len(stopped.force) < 100


@pytest.mark.long
def test_stored_forces_are_the_true_forces():
    """The measured force is held at the goal; taxels with wrong gains are pressed differently."""
    hold = replace(FOLLOW, task="keep_force", force_gain=0.003)
    wrong = replace(displaced_ball(), sensor=SensorEffects(gain_spread=GainSpread(sd=0.3)))
    true, read = (run_path(setup, hold, 0.1, settling=3.0) for setup in (displaced_ball(), wrong))
    assert true.force == pytest.approx(3.0, abs=0.1)
    assert np.abs(read.force - 3.0).min() > 0.15


def test_run_without_ticks_has_no_statistics():
    none = np.zeros(0)
    empty = PathRun(0.005, none, none, none, none, none, none, None, None, None)
    assert (empty.error_p95, empty.error_rms, empty.force_p95(3.0)) == (None, None, None)
    assert empty.lost == 1.0
    assert empty.in_band(3.0, 1.0) == 0.0
    assert empty.energy_minimum == 0.0
