"""Neighbourhood measures: perfect maps score perfectly, spoiled ones do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.maps.build import build_map
from app.maps.tactile_map import TactileMap
from app.maps.topography import edge_lengths, topography
from tests.numerics.map_surfaces import frustum, named, sheet, skin_of


@pytest.fixture(scope="module")
def flat():
    return build_map(skin_of(sheet(24, 16), taxels=40))


def _spoiled(map_, change):
    chart = map_.charts[0]
    return TactileMap(map_.skin, (replace(chart, plane=change(chart.plane)), *map_.charts[1:]), map_.layout)


def test_a_flat_patch_keeps_everything(flat):
    shape = topography(flat, sources=10, seed=0)
    assert shape.stress < 1e-6
    assert shape.edge_error < 1e-6
    assert shape.torn == 0
    # The heat method may swap taxels at almost the same distance.
    assert shape.trustworthiness > 0.995
    assert shape.continuity > 0.995
    assert shape.findings == ()


def test_scale_does_not_matter(flat):
    shape = topography(_spoiled(flat, lambda plane: 7 * plane), sources=10, seed=0)
    assert shape.stress < 1e-6


def test_a_stretched_map_is_worse(flat):
    stretched = _spoiled(flat, lambda plane: plane * [1.5, 1])
    ratio = np.array([1.5, 1.0])
    shape = topography(stretched, sources=10, seed=0)
    assert 0.05 < shape.edge_error < (ratio.max() - ratio.min()) / 2
    assert shape.stress > 0.05


def test_a_folded_map_has_false_neighbours(flat):
    folded = _spoiled(flat, lambda plane: np.abs(plane - plane.mean(axis=0)))
    assert topography(folded, sources=4, seed=0).trustworthiness < 0.97


def test_a_seam_loses_neighbours_but_makes_no_false_ones():
    shape = topography(build_map(skin_of(frustum(around=40, along=24), taxels=80)), sources=6, seed=0)
    assert shape.torn > 0.02
    assert shape.continuity < shape.trustworthiness - 0.005
    assert shape.edge_error < 0.004, "a tube is laid flat without any stretch; straight lines would give 0.008"


def test_patches_too_small_to_rank_are_unknown_not_perfect():
    map_ = build_map(skin_of(sheet(), taxels=6))
    assert np.isnan(topography(map_, sources=2, seed=0).trustworthiness)


def test_a_single_taxel_has_no_lengths():
    map_ = build_map(skin_of(sheet(), taxels=1))
    assert edge_lengths(map_) == (0.0, 0.0)
    assert topography(map_, sources=2, seed=0).stress == 0.0


def test_what_cannot_be_exact_is_said():
    (note,) = topography(build_map(skin_of(named("thin faces"))), sources=2, seed=0).findings
    assert note.kind == "inexact-distance"


def test_the_same_seed_gives_the_same_numbers(flat):
    assert topography(flat, sources=3, seed=5) == topography(flat, sources=3, seed=5)
