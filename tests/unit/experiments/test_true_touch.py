"""What is true of a touch, whatever is believed."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.true_touch import TrueTouch
from app.geometry.surface_point import SurfacePoint
from app.maps.build import build_map
from app.maps.learned.as_map import learned_tactile_map
from app.maps.learned.learned_map import LearnedMap
from app.skin.misplace import misplaced
from tests.touch import prepared_bar

BAR = prepared_bar()
HOME = np.zeros(1)


def over(at: SurfacePoint, height: float) -> np.ndarray:
    return BAR.skin.position(at) + height * BAR.skin.normal(at)


def test_a_ball_over_the_target_is_right_and_one_beside_it_so_far_off():
    truth, target = TrueTouch(BAR.robot, BAR.skin, BAR.map), BAR.skin.taxel_point(20)
    assert truth.error(target, over(target, 0.03), HOME) == pytest.approx(0.0, abs=1e-9)
    assert truth.error(target, over(target, 0.03) + [0.004, 0.003, 0.0], HOME) == pytest.approx(0.005, abs=1e-9)


def test_the_robot_moves_the_target_along():
    truth, target = TrueTouch(BAR.robot, BAR.skin, BAR.map), BAR.skin.taxel_point(20)
    still = over(target, 0.03)
    assert truth.error(target, still, np.array([0.1])) > 0.001


def test_a_place_of_a_misplaced_skin_is_the_same_place():
    believed = build_map(misplaced(BAR.skin, 0.004, seed=1))
    truth, target = TrueTouch(BAR.robot, BAR.skin, believed), BAR.skin.taxel_point(20)
    assert np.linalg.norm(believed.skin.position(target) - BAR.skin.position(target)) > 0.001, (
        "it is believed elsewhere"
    )
    assert truth.error(target, over(target, 0.03), HOME) == pytest.approx(0.0, abs=1e-9)


def test_a_place_of_a_learned_map_lies_between_its_taxels():
    points = BAR.map.taxel_points
    learned = learned_tactile_map(BAR.skin, LearnedMap(points, np.ones(len(points), dtype=bool), "by hand", 0.0, 0.0))
    truth, target = TrueTouch(BAR.robot, BAR.skin, learned), learned.skin.taxel_point(20)
    here = over(BAR.skin.taxel_point(20), 0.03)
    assert truth.error(target, here, HOME) == pytest.approx(0.0, abs=1e-6)
    assert len(learned.skin.patches[0].surface.faces) != len(BAR.skin.patches[0].surface.faces)
