"""Comparison of two maps, and drawings given by the taxels of a skin."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import IDEALS, TaxelLayout, compare_maps, drawn_layout, procrustes
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.real_icub import LAYOUTS, POSITIONS, needs_files
from tests.support.straight_distances import straight_distances
from tests.support.surfaces import named, sheet, skin_of


@pytest.fixture(scope="module")
def automatic():
    return build_map(skin_of(named("saddle"), sheet(), taxels=30))


@pytest.fixture(scope="module")
def body(automatic):
    return BodyDistances(automatic.skin)


def _row(comparison, name):
    (row,) = [row for row in comparison.measures if row.name == name]
    return row


@pytest.mark.long
def test_comparison_of_a_map_with_itself_has_no_difference(automatic, body):
    comparison = compare_maps(automatic, automatic, distances=body)
    assert comparison.procrustes_mm < 1e-9
    assert {row.better for row in comparison.measures} == {"neither"}
    assert all(row.first == row.second for row in comparison.measures)
    assert comparison.first == comparison.second == measure(automatic, distances=body)


@pytest.mark.long
def test_stretched_map_is_worse_where_it_is_stretched(automatic, body):
    (first, second) = automatic.charts
    stretched = TactileMap(automatic.skin, (replace(first, plane=first.plane * [1.6, 1]), second), automatic.layout)
    comparison = compare_maps(stretched, automatic, distances=body)
    for name in ("angle", "area", "isometry", "symmetric_dirichlet", "edge_error", "stress"):
        row = _row(comparison, name)
        assert row.better == "second", row
        assert abs(row.first - IDEALS[name]) > abs(row.second - IDEALS[name])
    assert _row(comparison, "flips").better == "neither"
    assert comparison.procrustes_mm > 3


@pytest.mark.long
def test_layout_is_evaluated_only_by_its_points(automatic, body):
    shuffled = np.random.default_rng(0).permutation(len(automatic.skin))
    by_hand = TaxelLayout(2 * automatic.taxel_points[shuffled] + 1, shuffled)
    comparison = compare_maps(automatic, by_hand, distances=body)
    assert comparison.procrustes_mm < 1e-9, "moved, grown and in another order it is the same map"
    assert _row(comparison, "trustworthiness").better == "neither"
    assert _row(comparison, "angle").second is None
    assert _row(comparison, "angle").better == "neither"
    assert {row.name for row in comparison.measures} <= set(IDEALS)


@pytest.mark.long
def test_body_distances_default_to_those_of_the_map(automatic, body):
    by_hand = TaxelLayout(automatic.taxel_points)
    assert compare_maps(by_hand, automatic).to_json() == compare_maps(by_hand, automatic, distances=body).to_json()


@pytest.mark.long
def test_comparison_table_is_valid_json(automatic, body):
    report = compare_maps(automatic, TaxelLayout(automatic.taxel_points), distances=body).to_json()
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert report["measures"][0].keys() == {"name", "first", "second", "better"}


@pytest.mark.parametrize(
    ("points", "numbers", "problem"),
    [
        (np.zeros((3, 2)), None, "same taxels"),
        (np.zeros((60, 2)), np.zeros(60), "each taxel once"),
        (np.full((60, 2), np.nan), None, "not finite"),
    ],
)
def test_maps_of_different_taxels_are_rejected(automatic, body, points, numbers, problem):
    with pytest.raises(MapError, match=problem):
        compare_maps(automatic, TaxelLayout(points, numbers), distances=body)


def test_comparison_of_two_layouts_requires_a_body(body, automatic):
    layout = TaxelLayout(automatic.taxel_points)
    with pytest.raises(MapError, match="no distances on the body"):
        compare_maps(layout, layout)
    assert compare_maps(layout, layout, distances=body).procrustes_mm < 1e-9


def test_procrustes_finds_the_best_similarity_of_each_part():
    generator = np.random.default_rng(1)
    first = generator.normal(size=(50, 2))
    noise = 1e-3 * generator.normal(size=(50, 2))
    second = np.empty_like(first)
    for part, angle, mirror in ((slice(0, 20), 0.5, 1), (slice(20, 50), -2.0, -1)):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag([mirror, 1])
        second[part] = 3 * (first[part] + noise[part]) @ turn.T + generator.normal(size=2)
    found = procrustes(first, second, np.array([0, 20, 50]))
    rms = np.sqrt((noise**2).sum(axis=1).mean())
    assert 0.8 * rms < found < rms
    assert procrustes(first, second, np.array([0, 50])) > 0.1


def test_coincident_points_have_the_error_of_the_map_width():
    first = np.array([[0.0, 0], [2, 0], [0, 2], [2, 2]])
    assert procrustes(first, np.zeros((4, 2)), np.array([0, 4])) == pytest.approx(np.sqrt(2))


def _icub_positions(name):
    """(n, 3) the file's rows, unused ones all zero, by a reading of our own."""
    rows = []
    for line in (POSITIONS / f"{name}.txt").read_text().split("[calibration]")[1].splitlines():
        words = line.split()
        if len(words) >= 3 and words[0][0] in "-.0123456789":
            rows.append([float(word) for word in words[:3]])
    return np.array(rows)


def _icub_layout(name):
    """Taxel number -> map point, by the viewer's rules: mirror, turn, move; the first of two lines counts."""
    x = np.array((257.2, 385.83, 128.62, 0, -128.62, -385.83, -256.3, -257.2, -128.62, 0, 0, 128.62)) / 40e3
    y = np.array((0, -222.83, -222.83, 0, -222.83, -222.83, -147.64, 0, 222.83, 445.54, 296.55, 222.83)) / 40e3
    points = {}
    for line in (LAYOUTS / f"{name}.ini").read_text().splitlines():
        words = line.split()
        if words and words[0] == "triangle_10pad":
            turn = np.exp(1j * np.deg2rad(float(words[4])))
            pads = turn * ((-x if words[6:7] == ["1"] else x) + 1j * y) + 1e-3 * complex(
                float(words[2]), float(words[3])
            )
            for pad, point in enumerate(pads):
                points.setdefault(12 * int(words[1]) + pad, (point.real, point.imag))
    return points


@needs_files
def test_hand_made_map_of_the_left_arm_has_the_known_scores():
    """350 taxels; 674 pairs under 8 mm, one torn; both scores 0.999."""
    positions = _icub_positions("left_arm")
    layout = _icub_layout("left_arm_V2_7")
    used = np.array([k for k in range(len(positions)) if positions[k].any() and k in layout and k % 12 not in (6, 10)])
    by_hand = TaxelLayout(np.array([layout[k] for k in used]))
    body = straight_distances(positions[used])
    shape = compare_maps(by_hand, by_hand, distances=body).first
    assert (len(used), shape.pairs, shape.torn_pairs) == (350, 674, 1)
    assert (shape.trustworthiness, shape.continuity) == pytest.approx((0.999, 0.999), abs=5e-4)


@pytest.fixture
def skin():
    return skin_of(sheet())


@pytest.fixture
def drawn(skin):
    positions = skin.patches[0].taxels.positions
    points = positions[:, :2] * 2.0
    points[3] = np.nan
    order = np.random.default_rng(0).permutation(len(positions))
    return TaxelSet("drawn", "patch", np.arange(len(order)), positions[order], points=points[order])


def test_each_point_is_assigned_to_its_taxel(skin, drawn):
    layout = drawn_layout(drawn, skin)
    positions = skin.patches[0].taxels.positions
    assert len(layout.points) == len(positions) - 1
    assert 3 not in layout.numbers
    np.testing.assert_allclose(layout.points, 2 * positions[layout.numbers, :2])


def test_taxel_drawn_twice_counts_once(skin, drawn):
    assert drawn.points is not None
    twice = TaxelSet(
        "twice",
        "patch",
        np.arange(2 * len(drawn)),
        np.tile(drawn.positions, (2, 1)),
        points=np.tile(drawn.points, (2, 1)),
    )
    numbers = drawn_layout(twice, skin).numbers
    assert len(np.unique(numbers)) == len(numbers)


def test_drawing_of_another_body_is_rejected(skin, drawn):
    with pytest.raises(MapError, match=r"not of this skin.*mm \(median\) from"):
        drawn_layout(replace(drawn, positions=drawn.positions + 0.5), skin)


def test_file_without_points_is_rejected(skin, drawn):
    with pytest.raises(MapError, match="no map points"):
        drawn_layout(replace(drawn, points=None), skin)
