"""The quality report: right on maps whose numbers are known, and complete."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from app.maps.build import build_map
from app.maps.layout import MapLayout, Placement
from app.maps.quality import measure
from app.maps.tactile_map import TactileMap
from tests.numerics.map_surfaces import frustum, named, sheet, skin_of

PROMISED = {
    "patches", "taxels", "faces", "flips", "bijective", "symmetric_dirichlet", "edge_error", "stress",
    "trustworthiness", "continuity", "round_trip_mm", "angle", "area", "seconds", "findings",
}  # fmt: skip


@pytest.fixture(scope="module")
def flat():
    return build_map(skin_of(sheet(24, 16), sheet(16, 16, width=0.08), taxels=30))


def _with(map_, **changes):
    first = replace(map_.charts[0], **changes)
    return TactileMap(map_.skin, (first, *map_.charts[1:]), map_.layout)


def test_a_flat_skin_is_mapped_without_loss(flat):
    quality = measure(flat)
    assert (quality.patches, quality.taxels, quality.faces) == (2, 60, 2 * (24 * 16 + 16 * 16))
    assert (quality.flips, quality.bijective) == (0, True)
    assert quality.symmetric_dirichlet == pytest.approx(4, abs=1e-6)
    for spread in (quality.angle, quality.area):
        assert [spread.median, spread.p95, spread.max] == pytest.approx([1, 1, 1], abs=1e-3)
    assert quality.seam_mm == 0


def test_a_known_stretch_is_measured(flat):
    quality = measure(_with(flat, plane=flat.charts[0].plane * [2, 1]))
    assert quality.angle.max == pytest.approx(2, rel=1e-3)
    assert quality.area.max == pytest.approx(2, rel=1e-3)
    share = flat.skin.patches[0].surface.area / sum(patch.surface.area for patch in flat.skin.patches)
    assert quality.symmetric_dirichlet == pytest.approx(share * 6.25 + (1 - share) * 4, rel=1e-3)


def test_shrinking_counts_as_much_as_growing(flat):
    assert measure(_with(flat, plane=flat.charts[0].plane * 0.5)).area.max == pytest.approx(4, rel=1e-3)


def test_flips_are_counted(flat):
    plane = flat.charts[0].plane.copy()
    inner = int(np.linalg.norm(plane - plane.mean(axis=0), axis=1).argmin())
    plane[inner] += [0.02, 0]
    quality = measure(_with(flat, plane=plane))
    assert quality.flips > 0
    assert not quality.bijective


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.02, 0.01), (-0.01, 0.03)])
def test_patches_on_top_of_each_other_are_noticed(offset):
    apart = build_map(skin_of(sheet(), sheet(width=0.03, height=0.02), taxels=10))
    over = TactileMap(apart.skin, apart.charts, MapLayout((Placement(), Placement(offset=offset))))
    assert measure(apart).bijective
    assert measure(over).flips == 0
    assert not measure(over).bijective


def test_a_mirrored_patch_is_still_one_to_one(flat):
    places = (Placement(offset=(-1.0, 0.0), mirrored=True), flat.layout.placements[1])
    assert measure(TactileMap(flat.skin, flat.charts, MapLayout(places))).bijective


def test_a_round_trip_stays_within_a_pixel(three_patches):
    pixel_mm = 1e3 * np.ptp(three_patches.bounds, axis=0)[0] / 512
    assert 0.1 * pixel_mm < measure(three_patches, sources=3).round_trip_mm < 1.5 * pixel_mm


def test_the_seam_is_measured_on_the_body():
    assert measure(build_map(skin_of(frustum(length=0.2))), sources=2).seam_mm == pytest.approx(200, rel=1e-9)


def test_findings_of_skin_and_charts_are_passed_on():
    quality = measure(build_map(skin_of(named("thin faces"))))
    assert {finding.kind for finding in quality.findings} == {"thin-face", "inexact-distance"}


def test_the_report_is_json_with_the_promised_keys(three_patches):
    report = measure(three_patches, sources=3).to_json()
    assert set(report) >= PROMISED
    assert set(report["angle"]) == set(report["area"]) == {"median", "p95", "max"}
    assert json.loads(json.dumps(report, allow_nan=False)) == report


def test_what_is_unknown_is_null():
    quality = measure(build_map(skin_of(sheet(), taxels=5)))
    assert math.isnan(quality.trustworthiness)
    assert quality.to_json()["trustworthiness"] is None


def test_findings_are_told_with_kind_count_and_action():
    (note, *_) = measure(build_map(skin_of(named("thin faces")))).to_json()["findings"]
    assert {"kind", "count", "action"} <= set(note)
