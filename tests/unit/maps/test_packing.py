"""Patches are laid out in order, apart from each other, in a window's shape."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.chart import Chart
from app.maps.packing import ASPECT, pack


def _charts(sizes):
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return [Chart(faces, [[0, 0], [w, 0], [w, h], [0, h]], np.arange(4), np.zeros((0, 2)), "by hand") for w, h in sizes]


def _boxes(charts):
    places = pack(charts).placements
    placed = [place.apply(chart.plane) for place, chart in zip(places, charts, strict=True)]
    return np.array([[p.min(axis=0), p.max(axis=0)] for p in placed])


@pytest.mark.parametrize("count", [1, 2, 3, 6, 12, 13, 40])
def test_no_two_touch_and_all_are_on_the_map(count):
    boxes = _boxes(_charts(np.random.default_rng(count).uniform(0.02, 0.3, (count, 2))))
    assert boxes.min() == pytest.approx(0, abs=1e-12)
    for i in range(count):
        for j in range(i):
            gap = np.maximum(boxes[i, 0] - boxes[j, 1], boxes[j, 0] - boxes[i, 1]).max()
            assert gap > 0.005, (i, j)


def test_order_is_that_of_reading():
    boxes = _boxes(_charts([(0.1, 0.1)] * 6))
    middle = boxes.mean(axis=1)
    order = sorted(range(6), key=lambda k: (-round(middle[k, 1], 3), middle[k, 0]))
    assert order == list(range(6))


def test_the_whole_has_a_windows_shape():
    width, height = _boxes(_charts([(0.1, 0.1)] * 12)).reshape(-1, 2).max(axis=0)
    assert 0.7 * ASPECT < width / height < 1.5 * ASPECT


def test_nothing_to_pack_is_an_empty_layout():
    assert pack([]).placements == ()


def test_a_patch_keeps_its_upright_direction():
    assert all(place.angle == 0 and not place.mirrored for place in pack(_charts([(0.1, 0.2)] * 5)).placements)
