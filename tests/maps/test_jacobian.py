"""The map's Jacobian and the smoothed normal: right on simple bodies, and forgiving of misplaced taxels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.jacobian import MapJacobian, affine_fit, least_norm_motion
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.skin.model.skin import Skin
from tests.support.surfaces import frustum, skin_of
from tests.support.touch import arm, bar_skin, prepared_bar

PITCH = 0.008


@pytest.mark.parametrize("kind", ["smoothed", "raw"])
def test_jacobian_predicts_motion_of_map_points_on_a_flat_skin(kind):
    map_ = prepared_bar().map
    jacobian = MapJacobian(map_)
    at = map_.skin.taxel_point(25)
    rows = jacobian.at(at, kind=kind)
    for other in range(0, 60, 7):
        there = map_.skin.taxel_point(other)
        step = map_.skin.position(there) - map_.skin.position(at)
        assert rows @ step == pytest.approx(map_.to_map(there) - map_.to_map(at), abs=2e-5)
    assert rows @ [0, 0, 1] == pytest.approx([0, 0], abs=1e-9)


def test_jacobian_scales_and_rotates_with_its_patch():
    map_ = prepared_bar().map
    drawn = TactileMap(map_.skin, map_.charts, MapLayout((Placement(angle=0.7, scale=3.0),)))
    at = map_.skin.taxel_point(25)
    old, new = (MapJacobian(one).at(at) for one in (map_, drawn))
    base = map_.layout.placements[0]
    turned = drawn.layout.placements[0].apply(base.back(np.vstack([old.T, np.zeros(2)])))
    assert new == pytest.approx((turned[:3] - turned[3]).T, abs=1e-9)


def test_triangle_and_smoothed_jacobian_agree_on_a_map_with_little_stretch():
    map_ = arm().map
    skin = arm().skin
    jacobian = MapJacobian(map_)
    apart = []
    for taxel in range(0, len(skin), 3):
        smooth, raw = (jacobian.at(skin.taxel_point(taxel), kind=kind) for kind in ("smoothed", "raw"))
        apart.append(np.linalg.norm(smooth - raw, 2))
        assert np.linalg.det(np.vstack([smooth, skin.normal(skin.taxel_point(taxel))])) != 0
    assert np.median(apart) < 0.1


def test_fit_uses_only_taxels_on_its_side_of_a_seam():
    """The fit of every taxel of a tube excludes neighbours on the other side of the cut."""
    map_ = arm().map
    jacobian = MapJacobian(arm().map)
    torn = 0
    for taxel in range(len(map_.skin)):
        ring = jacobian.two_rings(taxel)
        reach = np.linalg.norm(map_.taxel_points[ring] - map_.taxel_points[taxel], axis=1).max()
        assert reach < 4 * 2 * np.sqrt(map_.skin.areas.mean())
        torn += len(ring) < 15
    assert torn > 10, "there must be borders"


def test_triangle_jacobian_is_used_exactly_if_neighbours_are_too_few():
    map_ = prepared_bar().map
    jacobian = MapJacobian(map_)
    jacobian.two_rings = lambda taxel: np.array([taxel])
    at = map_.skin.taxel_point(25)
    assert np.array_equal(jacobian.at(at), jacobian.at(at, kind="raw"))


def test_result_does_not_depend_on_earlier_queries():
    map_ = arm().map
    asked = MapJacobian(arm().map)
    places = [map_.skin.taxel_point(taxel) for taxel in range(0, len(map_.skin), 17)]
    for at in places[::-1]:
        asked.at(at)
    for at in places:
        assert np.array_equal(asked.at(at), MapJacobian(map_).at(at))


def test_nearest_taxels_of_the_patch_are_blended():
    """The candidates stored for each triangle include the nearest taxels of every point in it."""
    map_ = arm().map
    rng = np.random.default_rng(0)
    jacobian = MapJacobian(map_)
    for taxel in range(0, len(map_.skin), 11):
        at = replace(map_.skin.taxel_point(taxel), weights=tuple(rng.dirichlet((0.5, 0.5, 0.5)).tolist()))
        own = np.arange(map_.skin.first[at.patch], map_.skin.first[at.patch + 1])
        away = np.linalg.norm(map_.taxel_points[own] - map_.to_map(at), axis=1)
        nearest = np.argsort(away)[:3]
        weights = 1 / (away[nearest] ** 2 + 1e-12)
        fits = np.array([jacobian.at(map_.skin.taxel_point(int(one))) for one in own[nearest]])
        blend = np.einsum("k,kij->ij", weights / weights.sum(), fits)
        assert jacobian.at(at) == pytest.approx(blend, abs=1e-5), "a taxel's own place is its fit, but for 1e-12 / d²"


@pytest.mark.parametrize("flatness", [1.0, 0.1, 2e-3, 5e-4, 1e-6, 0.0])
def test_smallest_motion_equals_that_of_the_pseudo_inverse(flatness):
    rng = np.random.default_rng(3)
    for _ in range(50):
        turn = np.linalg.qr(rng.normal(size=(2, 2)))[0]
        square = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        rows = turn @ np.diag([1.3, 1.3 * flatness]) @ square[:2]
        velocity = rng.normal(size=2)
        expected = np.linalg.pinv(rows, rcond=1e-3) @ velocity
        assert least_norm_motion(rows, velocity) == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())
    assert not least_norm_motion(np.zeros((2, 3)), np.ones(2)).any()


def test_degenerate_face_gives_no_jacobian_and_no_warning():
    assert np.isfinite(MapJacobian(arm().map).at(SurfacePoint(0, 0, (1.0, 0.0, 0.0)), kind="raw")).all()
    assert affine_fit(np.outer(np.arange(5.0), [1, 0, 0]), np.zeros((5, 2)), np.array([0, 0, 1.0])).shape == (2, 3)


def lattice() -> np.ndarray:
    """(19, 2) a taxel and its two rings."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)))
    inside = np.abs(i + j) <= 2
    return PITCH * np.stack([i + j / 2, j * np.sqrt(3) / 2], axis=1)[inside]


def believed(sigma, count=4000):
    """Condition, turn [deg] and determinant of (true to believed), per triangle and fitted, with misplaced taxels.

    The map is laid out by where taxels are believed to be; the body is where they are.
    """
    rng = np.random.default_rng(0)
    points = lattice()
    body = np.column_stack([points, np.zeros(len(points))])
    middle, right, up = (int(np.argmin(np.linalg.norm(points - PITCH * np.array(p), axis=1)))
                         for p in ((0, 0), (1, 0), (0.5, np.sqrt(3) / 2)))  # fmt: skip
    true = (points[[right, up]] - points[middle]).T
    raw = []
    fitted = []
    for _ in range(count):
        plane = points + rng.normal(scale=sigma, size=points.shape)
        raw.append((plane[[right, up]] - plane[middle]).T @ np.linalg.inv(true))
        fitted.append(affine_fit(body, plane, np.array([0, 0, 1.0]))[:, :2])
    return measures(np.array(raw)), measures(np.array(fitted))


def measures(maps):
    gains = np.linalg.svd(maps, compute_uv=False)
    turn = np.degrees(np.arctan2(maps[:, 1, 0] - maps[:, 0, 1], maps[:, 0, 0] + maps[:, 1, 1]))
    return gains[:, 0] / gains[:, 1], np.abs(turn), np.linalg.det(maps)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("sigma_mm", "raw_p50", "raw_p95", "inverted", "fit_p95", "fit_turn_p95"),
    [
        (0.5, 1.16, 1.36, 0.0, 1.05, 1.1),
        (1.0, 1.36, 1.94, 0.0, 1.10, 2.0),
        (2.0, 1.80, 5.2, 0.009, 1.19, 4.3),
        (3.0, 2.4, 18.0, 0.085, 1.32, 5.8),
        (7.0, 3.6, 37.0, 0.36, 2.1, 13.0),
    ],
)
def test_misplaced_taxels_affect_triangles_much_more_than_fits(
    sigma_mm, raw_p50, raw_p95, inverted, fit_p95, fit_turn_p95
):
    """The table of our theory page, roughly: at 8 mm pitch, 2 mm turn triangles over, and 7 mm turn no fit over."""
    (condition, _, area), (fit_condition, fit_turn, fit_area) = believed(1e-3 * sigma_mm)
    assert np.median(condition) == pytest.approx(raw_p50, rel=0.25)
    assert np.percentile(condition, 95) == pytest.approx(raw_p95, rel=0.6)
    assert (area <= 0).mean() == pytest.approx(inverted, abs=max(0.3 * inverted, 0.005))
    assert np.percentile(fit_condition, 95) == pytest.approx(fit_p95, rel=0.15)
    assert np.percentile(fit_turn, 95) == pytest.approx(fit_turn_p95, rel=0.35)
    assert (fit_area > 0).all()


def turned(one, other) -> float:
    """Between two unit vectors [degrees]."""
    return float(np.degrees(np.arccos(np.clip(one @ other, -1.0, 1.0))))


def test_normal_on_a_plane_is_that_of_the_plane():
    map_ = prepared_bar().map
    for face in range(0, len(map_.skin.patches[0].surface.faces), 37):
        normal = MapJacobian(map_).normal(SurfacePoint(0, face, (0.2, 0.3, 0.5)))
        assert normal == pytest.approx([0, 0, 1], abs=1e-9)


def test_normal_does_not_depend_on_the_layout_of_the_patch():
    map_ = prepared_bar().map
    drawn = TactileMap(map_.skin, map_.charts, MapLayout((Placement(angle=0.7, scale=3.0),)))
    at = map_.skin.taxel_point(25)
    assert MapJacobian(drawn).normal(at) == pytest.approx(MapJacobian(map_).normal(at), abs=1e-9)


def test_normal_on_curved_skin_follows_the_surface_between_taxels():
    map_ = arm().map
    skin = arm().skin
    jacobian = MapJacobian(map_)
    off = []
    for taxel in range(0, len(skin), 3):
        at = skin.taxel_point(taxel)
        off.append(turned(jacobian.normal(at), skin.normal(at)))
    assert np.median(off) < 4.0
    assert np.percentile(off, 95) < 10.0, "at a pitch of 30 mm on links of 36 mm: two rings would be off by 14"


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("sd", "least"), [(0.001, 2.5), (0.002, 2.5), (0.004, 2.0)])
def test_misplaced_taxels_rotate_triangle_normals_but_hardly_the_smoothed_normal(sd, least):
    """Plane at a pitch of 9 mm, where the truth is known."""
    believed = build_map(with_calibration_error(bar_skin(500, finer=3), sd, seed=1))
    jacobian = MapJacobian(believed)
    triangle = []
    smooth = []
    for taxel in range(0, 500, 7):
        at = believed.skin.taxel_point(taxel)
        triangle.append(turned(believed.skin.normal(at), np.array([0.0, 0.0, 1.0])))
        smooth.append(turned(jacobian.normal(at), np.array([0.0, 0.0, 1.0])))
    assert np.median(triangle) > 4e3 * sd, "degrees: the triangles are spoilt"
    assert np.median(smooth) < np.median(triangle) / least
    assert np.percentile(smooth, 95) < np.percentile(triangle, 95) / least


def test_normal_has_unit_length():
    map_ = arm().map
    jacobian = MapJacobian(map_)
    for taxel in range(0, len(map_.skin), 11):
        assert np.linalg.norm(jacobian.normal(map_.skin.taxel_point(taxel))) == pytest.approx(1.0, abs=1e-12)


def test_too_few_taxels_give_no_normal():
    skin = bar_skin(3)
    assert len(skin) < 4
    jacobian = MapJacobian(build_map(Skin(skin.patches)))
    corner = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    assert jacobian.normal(corner) is None
    assert jacobian.normal_rate(corner, np.array([1.0, 0.0])) == pytest.approx([0.0, 0.0, 0.0])


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_normal_turns_with_the_curvature_where_a_point_moves(scale):
    """The rate on a cylinder of 40 mm is v / r around it and zero along it, independent of the layout."""
    map_ = build_map(skin_of(frustum(0.04, 0.04, around=72, along=40), taxels=400))
    drawn = TactileMap(map_.skin, map_.charts, MapLayout((Placement(angle=0.7, scale=scale),)))
    jacobian = MapJacobian(drawn)
    skin = drawn.skin
    inside = np.flatnonzero(np.abs(skin.positions[:, 2] - 0.1) < 0.06)
    ratios = []
    for taxel in inside[::7].tolist():
        at = skin.taxel_point(taxel)
        around = np.cross([0.0, 0.0, 1.0], skin.normals[taxel])
        to_map = jacobian.at(at)
        rate = jacobian.normal_rate(at, to_map @ (0.01 * around))
        ratios.append([rate @ around, np.linalg.norm(jacobian.normal_rate(at, to_map @ [0.0, 0.0, 0.01]))])
    ratios = np.array(ratios) / (0.01 / 0.04)
    assert np.median(ratios, axis=0) == pytest.approx([1.0, 0.0], abs=0.05)
    assert np.abs(ratios - [1.0, 0.0]).max() < 0.25


def test_isometric_jacobian_has_the_rotation_of_the_smoothed_one_and_no_stretch():
    map_ = prepared_bar().map
    stretched = replace(map_.charts[0], plane=map_.charts[0].plane * [1.5, 0.8])
    drawn = TactileMap(map_.skin, (stretched,), MapLayout((Placement(angle=0.7, scale=2.0),)))
    jacobian = MapJacobian(drawn)
    at = map_.skin.taxel_point(25)
    smoothed = jacobian.at(at)
    isometric = jacobian.at(at, kind="isometric")
    assert np.linalg.svd(smoothed, compute_uv=False) == pytest.approx([3.0, 1.6], rel=0.01)
    assert np.linalg.svd(isometric, compute_uv=False) == pytest.approx([2.0, 2.0])
    assert smoothed @ isometric.T == pytest.approx((smoothed @ isometric.T).T, abs=1e-9), "no turn is left between them"
