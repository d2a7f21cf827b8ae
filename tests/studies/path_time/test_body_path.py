"""The same path on the body, whatever map is believed."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.build import build_map
from tactile_maps.maps.learned.as_tactile_map import learned_tactile_map
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import path_about
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.studies.path_time.body_path import path_length, touched_place, transfer_points, with_path_on_body
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.studies.testbeds.path_following import PathSetup
from tests.support.pressed_arm import forearm

SETTINGS = ControlSettings(task="follow_path")


@pytest.fixture(scope="module")
def prepared():
    return with_fixed_ball(forearm(), taxel=150)


def body_places(map_, points):
    return np.array([map_.skin.position(map_.to_body(point)) for point in points])


def test_true_map_keeps_the_path_around_the_contact(prepared):
    assert with_path_on_body(SETTINGS, PathSetup(prepared)) == SETTINGS
    assert path_length(SETTINGS) == path_about("lemniscate", np.zeros(2), SETTINGS.path_size).length


def test_ball_touches_its_taxel(prepared):
    skin = prepared.skin
    away = skin.position(touched_place(prepared)) - skin.position(skin.taxel_point(150))
    assert np.linalg.norm(away) < 1e-3


def test_map_at_half_its_size_has_the_same_path_on_the_body(prepared):
    true = prepared.map
    half = TactileMap(true.skin, true.charts, MapLayout(tuple(Placement(angle=0.4, scale=0.5) for _ in true.charts)))
    taken = with_path_on_body(SETTINGS, PathSetup(prepared, half))
    whole = with_path_on_body(SETTINGS, PathSetup(prepared, TactileMap(true.skin, true.charts, true.layout)))
    assert path_length(taken) == pytest.approx(0.5 * path_length(whole))
    assert path_length(whole) == pytest.approx(path_length(SETTINGS), rel=2e-3)
    assert body_places(half, taken.path) == pytest.approx(body_places(true, whole.path), abs=1e-9)


@pytest.mark.long
def test_path_on_a_misplaced_skin_visits_the_same_material_places(prepared):
    true = prepared.map
    believed = build_map(with_calibration_error(prepared.skin, 0.003, seed=1))
    points = true.taxel_points[100:200:10]
    there = [believed.to_body(point) for point in transfer_points(points, true, believed)]
    assert [prepared.skin.position(at) for at in there] == pytest.approx(body_places(true, points), abs=1e-9)


def test_path_on_a_learned_map_follows_its_taxels(prepared):
    true = prepared.map
    squeezed = LearnedMap(true.taxel_points * [0.3, 1.0], np.ones(len(prepared.skin), dtype=bool), "by hand", 0.0, 0.0)
    believed = learned_tactile_map(prepared.skin, squeezed)
    taxels = np.arange(100, 200, 10)
    taken = transfer_points(true.taxel_points[taxels], true, believed)
    assert taken == pytest.approx(believed.taxel_points[taxels], abs=1e-3)
