"""Placements are undone and combined exactly; packing keeps charts apart, in the body's order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import crossings
from tactile_maps.flattening.chart import Chart
from tactile_maps.maps.model.layout import PACKING_ASPECT, MapLayout, Placement, fit_placement, pack_charts, pair_up

POINTS = np.random.default_rng(0).normal(size=(20, 2))


def _lengths(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


@pytest.mark.parametrize(
    "placement", [Placement(), Placement(0.7, (1.0, -2.0)), Placement(-2.0, (0.0, 0.3), mirrored=True)]
)
def test_placement_preserves_lengths(placement):
    np.testing.assert_allclose(_lengths(placement.apply(POINTS)), _lengths(POINTS), atol=1e-12)


def test_rotation_is_counter_clockwise_and_applied_before_translation():
    np.testing.assert_allclose(Placement(np.pi / 2, (5.0, 0.0)).apply(np.array([[1.0, 0.0]])), [[5, 1]], atol=1e-12)


def test_mirroring_is_applied_first():
    mirrored = Placement(np.pi / 2, (0.0, 0.0), mirrored=True)
    np.testing.assert_allclose(mirrored.apply(np.array([[1.0, 0.0]])), [[0, -1]], atol=1e-12)


PLACEMENTS = [
    Placement(0.7, (1.0, -2.0)),
    Placement(-2.0, (0.0, 0.3), mirrored=True),
    Placement(3.0, (2.0, 1.0), scale=2.5),
    Placement(-0.4, (0.5, 0.0), mirrored=True, scale=0.2),
]


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_scale_applies_to_all_lengths_and_its_inverse_is_exact(placement):
    drawn = placement.apply(POINTS)
    np.testing.assert_allclose(_lengths(drawn), placement.scale * _lengths(POINTS), atol=1e-12)
    np.testing.assert_allclose(placement.back(drawn), POINTS, atol=1e-12)


@pytest.mark.parametrize("second", PLACEMENTS)
@pytest.mark.parametrize("first", PLACEMENTS)
def test_composition_equals_both_transforms_in_turn(first, second):
    both = second.after(first)
    np.testing.assert_allclose(both.apply(POINTS), second.apply(first.apply(POINTS)), atol=1e-12)
    assert abs(both.angle) <= np.pi


@pytest.mark.parametrize(
    ("change", "says"), [({"offset": (1e6, 0.0)}, "too far from the origin"), ({"scale": 20.0}, "too large")]
)
def test_placement_out_of_bounds_is_rejected(change, says):
    with pytest.raises(MapError, match=says):
        MapLayout((Placement(), Placement(**change)))


@pytest.mark.parametrize("placement", [Placement(np.nan), Placement(0.0, (np.inf, 0.0)), Placement(scale=np.nan)])
def test_placement_that_is_not_finite_is_rejected(placement):
    with pytest.raises(MapError, match="not finite"):
        MapLayout((placement,))


def _chart(outline):
    outline = np.asarray(outline, dtype=float)
    outline = outline - outline.min(axis=0)
    faces = np.array([[0, k, k + 1] for k in range(1, len(outline) - 1)])
    return Chart(faces, outline, np.arange(len(outline)), np.zeros((0, 2)), "by hand")


def _charts(sizes):
    return [_chart([[0, 0], [w, 0], [w, h], [0, h]]) for w, h in sizes]


def _placed(charts, links=None):
    places = pack_charts(charts, links=links).placements
    return [place.apply(chart.plane) for place, chart in zip(places, charts, strict=True)]


def _boxes(charts, links=None):
    return np.array([[p.min(axis=0), p.max(axis=0)] for p in _placed(charts, links)])


@pytest.mark.sampled(3)
@pytest.mark.parametrize("count", [1, 2, 3, 6, 12, 13, 40])
def test_packed_patches_do_not_touch_and_are_inside_the_map(count):
    boxes = _boxes(_charts(np.random.default_rng(count).uniform(0.02, 0.3, (count, 2))))
    assert boxes.min() == pytest.approx(0, abs=1e-12)
    for i in range(count):
        for j in range(i):
            gap = np.maximum(boxes[i, 0] - boxes[j, 1], boxes[j, 0] - boxes[i, 1]).max()
            assert gap > 0.005, (i, j)


_NAMES = st.sampled_from(["torso", "l_arm", "r_arm", "left_hand", "right_hand", "LeftFoot", "RightFoot", "head", "arm"])


@pytest.mark.long
@settings(max_examples=60)
@given(st.lists(st.tuples(_NAMES, st.integers(3, 9), st.floats(0.01, 0.5)), min_size=1, max_size=9), st.randoms())
def test_packing_only_moves_charts_without_overlap(parts, random):
    charts = []
    for _, corners, size in parts:
        angle = np.sort([random.uniform(0, 2 * np.pi) for _ in range(corners)]) + np.arange(corners) * 1e-3
        charts.append(_chart(size * np.stack([np.cos(angle), np.sin(angle)], axis=1)))
    links = [name for name, _, _ in parts]
    layout = pack_charts(charts, links=links)
    assert layout == pack_charts(charts, links=links)
    assert all(place.angle == 0 and not place.mirrored for place in layout.placements)
    placed = [place.apply(chart.plane) for place, chart in zip(layout.placements, charts, strict=True)]
    alone = sum(crossings(outline) for outline in placed)
    assert crossings(*placed) == alone
    for unit in pair_up(links):
        if len(unit) == 2:
            left, right = (placed[k][:, 0].mean() for k in unit)
            assert left < right


def test_patches_are_packed_in_reading_order():
    middle = _boxes(_charts([(0.1, 0.1)] * 6)).mean(axis=1)
    order = sorted(range(6), key=lambda k: (-round(middle[k, 1], 3), middle[k, 0]))
    assert order == list(range(6))


def test_pairs_are_placed_symmetrically():
    links = ["torso", "l_upper_arm", "l_forearm", "r_upper_arm", "r_forearm", "l_foot", "r_foot"]
    sizes = np.array([(0.3, 0.4), (0.1, 0.2), (0.1, 0.2), (0.12, 0.2), (0.1, 0.2), (0.1, 0.2), (0.1, 0.2)])
    middle = _boxes(_charts(sizes), links).mean(axis=1)
    axis = middle[0, 0]
    for left, right in ((1, 3), (2, 4), (5, 6)):
        np.testing.assert_allclose(middle[left] - [axis, 0], (middle[right] - [axis, 0]) * [-1, 1], atol=1e-12)
        assert middle[left, 0] < axis


def test_hand_is_placed_no_nearer_to_the_middle_and_no_higher_than_its_arm():
    links = ["l_arm", "r_arm", "l_hand", "r_hand"]
    middle = _boxes(_charts([(0.1, 0.3)] * 4), links).mean(axis=1)
    assert abs(middle[2, 0] - middle[3, 0]) > abs(middle[0, 0] - middle[1, 0]) or middle[2, 1] < middle[0, 1]


@pytest.mark.parametrize(
    ("links", "units"),
    [
        (["base", "l_arm", "r_arm"], [(0,), (1, 2)]),
        (["r_arm", "l_arm"], [(1, 0)]),
        (["RightFoot", "LeftFoot", "RightToe"], [(1, 0), (2,)]),
        (["arm_left", "arm_right", "left_arm"], [(0, 1), (2,)]),
        (["l_arm", "l_arm", "r_arm", "r_arm"], [(0, 2), (1, 3)]),
        (["l_arm 1", "r_arm 2"], [(0,), (1,)]),
        (["left_right_plate", "upper", "lower", "ur5"], [(0,), (1,), (2,), (3,)]),
        ([], []),
    ],
)
def test_sides_are_recognized_by_names(links, units):
    assert pair_up(links) == units


def test_names_without_sides_do_not_affect_the_layout():
    charts = _charts(np.random.default_rng(3).uniform(0.02, 0.3, (5, 2)))
    assert pack_charts(charts, links=["a", "b", "c", "d", "e"]) == pack_charts(charts)


def test_packing_requires_a_name_for_each_chart():
    with pytest.raises(MapError, match="2 names for 3 charts"):
        pack_charts(_charts([(0.1, 0.1)] * 3), links=["a", "b"])


@pytest.mark.long
def test_packed_map_has_about_the_stated_aspect_ratio():
    width, height = _boxes(_charts([(0.1, 0.1)] * 12)).reshape(-1, 2).max(axis=0)
    assert 0.7 * PACKING_ASPECT < width / height < 1.5 * PACKING_ASPECT


def test_packing_without_charts_gives_an_empty_layout():
    assert pack_charts([]).placements == pack_charts([], links=[]).placements == ()


@pytest.mark.parametrize("true", [Placement(2.0, (0.3, -0.1), scale=1.7), Placement(-0.4, (1.0, 2.0), True, 0.6)])
def test_placement_is_recovered_from_transformed_points(true):
    plane = np.random.default_rng(3).normal(size=(12, 2))
    found = fit_placement(plane, true.apply(plane))
    assert found.mirrored == true.mirrored
    assert (found.angle, *found.offset, found.scale) == pytest.approx((true.angle, *true.offset, true.scale))


def test_rigid_fit_neither_scales_nor_mirrors():
    plane = np.random.default_rng(3).normal(size=(12, 2))
    true = Placement(2.0, (0.3, -0.1))
    expected = 1.3 * (true.apply(plane) - true.offset) + true.offset
    found = fit_placement(plane, expected + plane.mean(axis=0), rigid=True)
    assert (found.angle, found.scale, found.mirrored) == (pytest.approx(2.0), 1.0, False)
    assert not fit_placement(plane, plane * [-1, 1], rigid=True).mirrored


def test_fit_of_coincident_points_has_scale_zero():
    found = fit_placement(np.zeros((3, 2)), np.array([[0.0, 0], [3, 0], [0, 3]]))
    assert (found.scale, found.offset) == (0.0, pytest.approx((1.0, 1.0)))
