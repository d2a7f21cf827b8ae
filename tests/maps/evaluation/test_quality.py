"""The quality report: right on maps whose numbers are known, and complete."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.quality import measure, overlaps
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tests.support.surfaces import frustum, named, sheet, skin_of

PROMISED = {
    "patches",
    "taxels",
    "faces",
    "flips",
    "bijective",
    "symmetric_dirichlet",
    "edge_error",
    "stress",
    "trustworthiness",
    "continuity",
    "round_trip_mm",
    "angle",
    "area",
    "seconds",
    "findings",
    "isometry",
    "energy",
    "overlaps",
    "spearman",
    "pairs",
    "torn",
    "torn_pairs",
    "seam_mm",
    "force_error",
    "coverage",
}


@pytest.fixture(scope="module")
def flat():
    return build_map(skin_of(sheet(24, 16), sheet(16, 16, width=0.08), taxels=30))


def _with(map_, **changes):
    first = replace(map_.charts[0], **changes)
    return TactileMap(map_.skin, (first, *map_.charts[1:]), map_.layout)


@pytest.mark.long
def test_flat_skin_is_mapped_without_distortion(flat):
    quality = measure(flat)
    assert (quality.patches, quality.taxels, quality.faces) == (2, 60, 2 * (24 * 16 + 16 * 16))
    assert (quality.flips, quality.bijective) == (0, True)
    assert quality.symmetric_dirichlet == pytest.approx(4, abs=1e-6)
    assert quality.energy.max == pytest.approx(4, abs=1e-5)
    for spread in (quality.angle, quality.area, quality.isometry):
        assert [spread.median, spread.p95, spread.max] == pytest.approx([1, 1, 1], abs=1e-3)
    assert quality.seam_mm == 0


@pytest.mark.long
def test_coverage_equals_that_of_the_skin(flat):
    assert measure(flat).coverage == 1.0
    half = replace(flat.skin, bare_area=sum(patch.surface.area for patch in flat.skin.patches))
    assert measure(TactileMap(half, flat.charts, flat.layout)).coverage == pytest.approx(0.5)


@pytest.mark.long
def test_known_stretch_is_measured(flat):
    quality = measure(_with(flat, plane=flat.charts[0].plane * [2, 1]))
    assert quality.angle.max == pytest.approx(2, rel=1e-3)
    assert quality.area.max == pytest.approx(2, rel=1e-3)
    share = flat.skin.patches[0].surface.area / sum(patch.surface.area for patch in flat.skin.patches)
    assert quality.symmetric_dirichlet == pytest.approx(share * 6.25 + (1 - share) * 4, rel=1e-3)


@pytest.mark.long
def test_shrinking_counts_as_much_as_growing(flat):
    assert measure(_with(flat, plane=flat.charts[0].plane * 0.5)).area.max == pytest.approx(4, rel=1e-3)


@pytest.mark.long
def test_flips_are_counted(flat):
    plane = flat.charts[0].plane.copy()
    inner = int(np.linalg.norm(plane - plane.mean(axis=0), axis=1).argmin())
    plane[inner] += [0.02, 0]
    quality = measure(_with(flat, plane=plane))
    assert quality.flips > 0
    assert not quality.bijective


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.02, 0.01), (-0.01, 0.03)])
def test_overlapping_patches_are_detected(offset):
    apart = build_map(skin_of(sheet(), sheet(width=0.03, height=0.02), taxels=10))
    over = TactileMap(apart.skin, apart.charts, MapLayout((Placement(), Placement(offset=offset))))
    assert measure(apart).bijective
    quality = measure(over)
    assert (quality.flips, quality.bijective) == (0, False)
    assert quality.overlaps > 0


def test_patch_in_the_hole_of_another_does_not_overlap():
    ring = named("sheet")
    small = sheet(4, 4, width=0.01, height=0.01)
    middle = ring.vertices[ring.faces].mean(axis=1)
    holed = Mesh(ring.vertices, ring.faces[np.abs(middle[:, :2] - [0.06, 0.04]).max(axis=1) > 0.02])
    parts = [skin_of(holed, taxels=10).patches[0], replace(skin_of(small, taxels=5).patches[0], name="small")]
    charts = [
        Chart(p.surface.faces, p.surface.vertices[:, :2], np.arange(len(p.surface.vertices)), [], "by hand")
        for p in parts
    ]
    assert len(holed.connectivity.boundary_loops) == 2
    for corner, expected in ((0.055, 0), (0.005, 1)):
        layout = MapLayout((Placement(), Placement(offset=(corner, corner - 0.02 * (corner > 0.05)))))
        assert overlaps(TactileMap(Skin(tuple(parts)), tuple(charts), layout)) >= expected
        assert (overlaps(TactileMap(Skin(tuple(parts)), tuple(charts), layout)) > 0) == (expected > 0)


@pytest.mark.long
def test_known_body_distances_are_reused(three_patches):
    body = BodyDistances(three_patches.skin, sources=3)
    image = TactileImage(three_patches)
    assert measure(three_patches, distances=body, images=(image,)) == measure(three_patches, sources=3)


@pytest.mark.long
def test_mirrored_patch_is_one_to_one(flat):
    places = (Placement(offset=(-1.0, 0.0), mirrored=True), flat.layout.placements[1])
    assert measure(TactileMap(flat.skin, flat.charts, MapLayout(places))).bijective


@pytest.mark.long
def test_round_trip_stays_within_a_pixel(three_patches):
    pixel_mm = 1e3 * np.ptp(three_patches.bounds, axis=0)[0] / 512
    assert 0.1 * pixel_mm < measure(three_patches, sources=3).round_trip_mm < 1.5 * pixel_mm


@pytest.mark.long
def test_image_conserves_the_force(three_patches):
    assert measure(three_patches, sources=3).force_error < 1e-12


@pytest.mark.long
def test_seam_is_measured_on_the_body():
    assert measure(build_map(skin_of(frustum(length=0.2))), sources=2).seam_mm == pytest.approx(200, rel=1e-9)


@pytest.mark.long
def test_findings_of_skin_and_charts_are_passed_on():
    quality = measure(build_map(skin_of(named("thin faces"))))
    assert {finding.kind for finding in quality.findings} == {"thin-face", "inexact-distance"}


@pytest.mark.long
def test_report_is_json_with_the_documented_keys(three_patches):
    report = measure(three_patches, sources=3).to_json()
    assert set(report) >= PROMISED
    for name in ("angle", "area", "isometry", "energy"):
        assert set(report[name]) == {"median", "p95", "max"}
    assert json.loads(json.dumps(report, allow_nan=False)) == report


@pytest.mark.long
def test_unknown_measure_is_null_in_json():
    quality = measure(build_map(skin_of(sheet(), taxels=5)))
    assert quality.trustworthiness is None
    assert quality.to_json()["trustworthiness"] is None


@pytest.mark.long
def test_findings_have_kind_count_and_action():
    (note, *_) = measure(build_map(skin_of(named("thin faces")))).to_json()["findings"]
    assert {"kind", "count", "action"} <= set(note)
