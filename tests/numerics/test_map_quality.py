"""Laws of the quality report: what must not change it, what must, and what it must never be."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.maps.body_distances import BodyDistances
from app.maps.build import build_map
from app.maps.distortion import distortion
from app.maps.glue import Gluing
from app.maps.layout import MapLayout, Placement
from app.maps.quality import measure
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.maps.topography import topography
from tests.numerics.map_surfaces import SURFACES, cap, named, skin_of
from tests.numerics.straight_walk import unrolled

HARD = ["nearly closed", "sieve", "spiral", "thin faces", "needles", "one wide", "loose vertices", "two handles"]
SHAPE = ("edge_error", "torn", "stress", "spearman", "trustworthiness", "continuity")


@cache
def _measured(name):
    map_ = build_map(skin_of(named(name), taxels=25))
    body = BodyDistances(map_.skin)
    return map_, body, measure(map_, distances=body, images=(TactileImage(map_, width=100),))


@pytest.mark.parametrize("name", HARD)
def test_no_number_is_wrong_without_saying_so(name):
    map_, _, quality = _measured(name)
    report = json.loads(json.dumps(quality.to_json(), allow_nan=False))
    assert quality.bijective
    assert (quality.flips, quality.overlaps) == (0, 0)
    for key in ("trustworthiness", "continuity", "torn"):
        assert 0 <= report[key] <= 1
    assert -1 <= report["spearman"] <= 1
    for key in ("angle", "area", "isometry"):
        spread = report[key]
        assert 1 - 1e-9 <= spread["median"] <= spread["p95"] <= spread["max"]
    assert report["isometry"]["max"] ** 2 >= report["area"]["max"] * (1 - 1e-9), "no area changes more than two lengths"
    assert report["energy"]["max"] >= report["symmetric_dirichlet"] >= 4 - 1e-9
    assert quality.symmetric_dirichlet == pytest.approx(map_.charts[0].energies[-1], rel=1e-3)
    if name == "thin faces":
        assert "inexact-distance" in {finding.kind for finding in quality.findings}


@pytest.mark.parametrize("name", ["bumpy tube", "hemisphere"])
def test_moving_and_mirroring_a_patch_changes_no_number_of_shape(name):
    map_, body, quality = _measured(name)
    layout = MapLayout((Placement(2.1, (-3.0, 0.4), mirrored=True),))
    moved = topography(TactileMap(map_.skin, map_.charts, layout).taxel_points, body)
    for key in SHAPE:
        assert getattr(moved, key) == pytest.approx(getattr(quality, key), abs=1e-9), key


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_size_changes_no_ratio(scale):
    surface = named("saddle")
    plain = _measured("saddle")[2]
    map_ = build_map(skin_of(Mesh(scale * surface.vertices, surface.faces), taxels=25))
    quality = measure(map_, images=(TactileImage(map_, width=100),))
    for key in SHAPE:
        assert getattr(quality, key) == pytest.approx(getattr(plain, key), abs=1e-4), key
    assert quality.round_trip_mm == pytest.approx(scale * plain.round_trip_mm, rel=0.1)


@pytest.mark.parametrize("name", ["tube", "cone"])
def test_what_can_be_laid_flat_loses_nothing_but_the_seam(name):
    map_ = unrolled(named(name), taxels=25)
    faces = distortion(map_)
    assert faces.isometry.max() < 1 + 1e-9
    assert faces.energy.max() < 4 + 1e-9
    body = BodyDistances(map_.skin)
    torn = topography(map_.taxel_points, body)
    assert torn.torn > 0
    # Glued, a taxel's neighbours lie where they are on the body, and none is torn.
    here, there = body.pairs.T
    glued = np.linalg.norm(Gluing(map_).seen(here, there) - map_.taxel_points[here], axis=1)
    np.testing.assert_allclose(glued, body.lengths, rtol=1e-3)


def test_no_map_of_a_cap_is_better_than_milnors_bound():
    """Milnor 1969: the largest over the smallest stretch of a cap of angle a is at least a / sin a."""
    for angle in (0.5, 1.0, np.pi / 2):
        map_ = build_map(skin_of(cap(angle), taxels=10))
        stretch = distortion(map_).stretch
        ratio = stretch[:, 0].max() / stretch[:, 1].min()
        assert angle / np.sin(angle) * 0.99 < ratio < 1.3 * angle / np.sin(angle)


def test_worse_maps_get_worse_numbers():
    map_, body, _ = _measured("saddle")
    (chart,) = map_.charts
    last = None
    for stretch in (1.0, 1.2, 1.6, 2.4):
        worse = TactileMap(map_.skin, (replace(chart, plane=chart.plane * [stretch, 1]),), map_.layout)
        image = TactileImage(worse, width=100)
        now = measure(worse, distances=body, images=(image,))
        if last is not None:
            for key in ("edge_error", "stress", "symmetric_dirichlet"):
                assert getattr(now, key) > getattr(last, key)
            assert now.angle.median > last.angle.median
            assert now.spearman < last.spearman
        last = now


def test_every_surface_of_the_catalogue_has_distances():
    for name in sorted(set(SURFACES) - {"deep cup"}):
        skin = skin_of(named(name), taxels=8)
        (patch,) = BodyDistances(skin).patches
        assert np.isfinite(patch.exact).all(), name
        np.testing.assert_allclose(patch.exact, patch.exact.T, rtol=1e-6, atol=1e-9, err_msg=name)
        straight = np.linalg.norm(skin.patches[0].taxels.positions[:, None] - skin.patches[0].taxels.positions, axis=2)
        assert (patch.exact >= straight - 2e-2 * skin.patches[0].surface.size / 10).all(), name
