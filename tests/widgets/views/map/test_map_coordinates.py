"""Places on the map: scene and metres are one to one, and the words for a place are short and right."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.map.items.map_coordinates import SCENE_SIZE, SceneTransform, format_three_digits


@pytest.mark.parametrize("bounds", [[[0, 0], [0.5, 0.2]], [[-3, 1], [-2.9, 4]], [[0, 0], [1e-3, 1e-3]]])
def test_there_and_back(bounds):
    frame = SceneTransform.around(np.array(bounds, dtype=float))
    assert max(frame.size) == pytest.approx(SCENE_SIZE)
    points = np.random.default_rng(0).uniform(bounds[0], bounds[1], (50, 2))
    assert np.abs(frame.to_map(frame.to_scene(points)) - points).max() < 1e-12


def test_the_map_stands_upright_from_the_upper_left_corner():
    frame = SceneTransform.around(np.array([[1.0, 2.0], [1.5, 2.2]]))
    assert frame.to_scene(np.array([1.0, 2.2])) == pytest.approx([0, 0])
    assert frame.to_scene(np.array([1.5, 2.0])) == pytest.approx([1000, 400])


def test_a_map_without_size_has_a_frame():
    assert SceneTransform.around(np.zeros((2, 2))).scale > 0


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0.00"), (0.123, "0.12"), (7.4, "7.40"), (12.34, "12.3"), (99.96, "100"), (431.4, "431")]
)
def test_three_digits(value, text):
    assert format_three_digits(value) == text
