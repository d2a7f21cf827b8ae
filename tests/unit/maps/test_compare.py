"""Two maps side by side: alike when they are alike, and the better one named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.errors import MapError
from app.maps.body_distances import BodyDistances
from app.maps.build import build_map
from app.maps.compare import IDEALS, TaxelLayout, compare, procrustes
from app.maps.quality import measure
from app.maps.tactile_map import TactileMap
from tests.numerics.map_surfaces import named, sheet, skin_of

ICUB = Path(__file__).parents[4] / "shared" / "data" / "icub-skin"


@pytest.fixture(scope="module")
def automatic():
    return build_map(skin_of(named("saddle"), sheet(), taxels=30))


@pytest.fixture(scope="module")
def body(automatic):
    return BodyDistances(automatic.skin)


def _row(comparison, name):
    (row,) = [row for row in comparison.measures if row.name == name]
    return row


def test_a_map_against_itself(automatic, body):
    comparison = compare(automatic, automatic, distances=body)
    assert comparison.procrustes_mm < 1e-9
    assert {row.better for row in comparison.measures} == {"neither"}
    assert all(row.first == row.second for row in comparison.measures)
    assert comparison.first == comparison.second == measure(automatic, distances=body)


def test_the_stretched_one_is_worse_where_it_is(automatic, body):
    (first, second) = automatic.charts
    stretched = TactileMap(automatic.skin, (replace(first, plane=first.plane * [1.6, 1]), second), automatic.layout)
    comparison = compare(stretched, automatic, distances=body)
    for name in ("angle", "area", "isometry", "symmetric_dirichlet", "edge_error", "stress"):
        row = _row(comparison, name)
        assert row.better == "second", row
        assert abs(row.first - IDEALS[name]) > abs(row.second - IDEALS[name])
    assert _row(comparison, "flips").better == "neither"
    assert comparison.procrustes_mm > 3


def test_a_layout_is_judged_by_its_points_alone(automatic, body):
    shuffled = np.random.default_rng(0).permutation(len(automatic.skin))
    by_hand = TaxelLayout(2 * automatic.taxel_points[shuffled] + 1, shuffled)
    comparison = compare(automatic, by_hand, distances=body)
    assert comparison.procrustes_mm < 1e-9, "moved, grown and in another order it is the same map"
    assert _row(comparison, "trustworthiness").better == "neither"
    assert np.isnan(_row(comparison, "angle").second)
    assert _row(comparison, "angle").better == "neither"
    assert {row.name for row in comparison.measures} <= set(IDEALS)


def test_the_body_is_asked_of_the_map_where_it_is_not_given(automatic, body):
    by_hand = TaxelLayout(automatic.taxel_points)
    assert compare(by_hand, automatic).to_json() == compare(by_hand, automatic, distances=body).to_json()


def test_the_table_is_json(automatic, body):
    report = compare(automatic, TaxelLayout(automatic.taxel_points), distances=body).to_json()
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert report["measures"][0].keys() == {"name", "first", "second", "better"}


@pytest.mark.parametrize(
    ("points", "numbers", "problem"),
    [
        (np.zeros((3, 2)), None, "same taxels"),
        (np.zeros((60, 2)), np.zeros(60), "each taxel once"),
        (np.full((60, 2), np.nan), None, "no finite place"),
    ],
)
def test_other_taxels_cannot_be_compared(automatic, body, points, numbers, problem):
    with pytest.raises(MapError, match=problem):
        compare(automatic, TaxelLayout(points, numbers), distances=body)


def test_two_layouts_need_a_body(body, automatic):
    layout = TaxelLayout(automatic.taxel_points)
    with pytest.raises(MapError, match="nothing about the body"):
        compare(layout, layout)
    assert compare(layout, layout, distances=body).procrustes_mm < 1e-9


def test_procrustes_finds_the_best_similarity_of_each_part():
    generator = np.random.default_rng(1)
    first, noise = generator.normal(size=(50, 2)), 1e-3 * generator.normal(size=(50, 2))
    second = np.empty_like(first)
    for part, angle, mirror in ((slice(0, 20), 0.5, 1), (slice(20, 50), -2.0, -1)):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag([mirror, 1])
        second[part] = 3 * (first[part] + noise[part]) @ turn.T + generator.normal(size=2)
    found = procrustes(first, second, np.array([0, 20, 50]))
    rms = np.sqrt((noise**2).sum(axis=1).mean())
    assert 0.8 * rms < found < rms
    assert procrustes(first, second, np.array([0, 50])) > 0.1


def test_points_all_in_one_place_are_as_far_as_the_map_is_wide():
    first = np.array([[0.0, 0], [2, 0], [0, 2], [2, 2]])
    assert procrustes(first, np.zeros((4, 2)), np.array([0, 4])) == pytest.approx(np.sqrt(2))


def _icub_positions(name):
    """(n, 3) the file's rows, unused ones all zero, by a reading of our own."""
    rows = []
    for line in (ICUB / "positions" / f"{name}.txt").read_text().split("[calibration]")[1].splitlines():
        words = line.split()
        if len(words) >= 3 and words[0][0] in "-.0123456789":
            rows.append([float(word) for word in words[:3]])
    return np.array(rows)


def _icub_layout(name):
    """Taxel number -> map point, by the viewer's rules: mirror, turn, move; the first of two lines counts."""
    x = np.array((257.2, 385.83, 128.62, 0, -128.62, -385.83, -256.3, -257.2, -128.62, 0, 0, 128.62)) / 40e3
    y = np.array((0, -222.83, -222.83, 0, -222.83, -222.83, -147.64, 0, 222.83, 445.54, 296.55, 222.83)) / 40e3
    points = {}
    for line in (ICUB / "layouts" / f"{name}.ini").read_text().splitlines():
        words = line.split()
        if words and words[0] == "triangle_10pad":
            turn = np.exp(1j * np.deg2rad(float(words[4])))
            pads = turn * ((-x if words[6:7] == ["1"] else x) + 1j * y) + 1e-3 * complex(
                float(words[2]), float(words[3])
            )
            for pad, point in enumerate(pads):
                points.setdefault(12 * int(words[1]) + pad, (point.real, point.imag))
    return points


@pytest.mark.skipif(not ICUB.exists(), reason="the real iCub skin files are not beside this checkout")
def test_the_left_arms_hand_made_map_scores_as_known():
    """350 taxels; 674 pairs under 8 mm, one torn, and that of 44 between modules; both scores 0.999."""
    positions, layout = _icub_positions("left_arm"), _icub_layout("left_arm_V2_7")
    used = np.array([k for k in range(len(positions)) if positions[k].any() and k in layout and k % 12 not in (6, 10)])
    by_hand, modules = TaxelLayout(np.array([layout[k] for k in used])), used // 12
    body = BodyDistances.straight(positions[used])
    shape = compare(by_hand, by_hand, distances=body, modules=modules).first
    assert (len(used), shape.pairs, shape.torn_pairs) == (350, 674, 1)
    assert (shape.pairs_between_modules, shape.torn_between_modules) == (44, 1)
    assert (shape.trustworthiness, shape.continuity) == pytest.approx((0.999, 0.999), abs=5e-4)
    assert shape.trustworthiness_between_modules < shape.trustworthiness
