"""Taxels as a person asks for them: the specification, the placement, keep-out zones, densities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.taxel_placement.placement import (
    HEXAGON_AREA,
    MAX_DENSITY_RATIO,
    BoundaryZone,
    BoxZone,
    PaintedZone,
    PlacementSpec,
    SphereZone,
    allowed_faces,
    curvature,
    curvature_density,
    face_density,
    place_taxels,
    refine_for_spec,
)
from tests.hard_cases.meshes import spiked
from tests.support.surfaces import cup, frustum, sheet, sphere


@pytest.mark.parametrize(
    ("requested", "problem"),
    [
        ({}, "state the pitch or the number"),
        ({"pitch": 0.01, "taxels": 5}, "state the pitch or the number"),
        ({"pitch": 0.0}, "pitch is out of range"),
        ({"pitch": float("nan")}, "pitch is out of range"),
        ({"taxels": 0}, "number of taxels"),
        ({"taxels": 10**6}, "number of taxels"),
        ({"taxels": 5, "pattern": "square"}, "unknown pattern"),
        ({"taxels": 5, "density": "dense"}, "unknown density"),
        ({"taxels": 5, "density": np.array([1.0, 0.0])}, "above zero"),
        ({"taxels": 5, "density": np.array([1.0, np.inf])}, "above zero"),
        ({"taxels": 5, "density": "curvature", "pattern": "hexagonal"}, "only the even pattern"),
        ({"taxels": 50, "pattern": "modules"}, "as many modules"),
    ],
)
def test_invalid_placements_are_rejected(requested, problem):
    with pytest.raises(SkinError, match=problem):
        PlacementSpec(**requested)


@pytest.mark.parametrize(
    "make",
    [
        lambda: SphereZone(np.zeros(3), 0.0),
        lambda: SphereZone(np.zeros(2), 1.0),
        lambda: SphereZone(np.full(3, np.nan), 1.0),
        lambda: BoxZone(np.ones(3), np.zeros(3)),
        lambda: BoundaryZone(-1.0),
    ],
)
def test_invalid_zones_are_rejected(make):
    with pytest.raises(SkinError):
        make()


def test_placement_and_zones_are_immutable():
    density = np.ones(3)
    spec = PlacementSpec(taxels=3, density=density)
    density[0] = 9
    assert spec.density.tolist() == [1, 1, 1]
    assert not spec.density.flags.writeable
    assert not SphereZone(np.zeros(3), 1.0).centre.flags.writeable


def test_part_has_its_share_of_the_painted_density():
    ball = SphereZone(np.zeros(3), 1.0)
    zones = (ball, PaintedZone(np.array([True, False, True])))
    part = PlacementSpec(taxels=9, density=np.arange(1.0, 4.0), keep_out=zones).restricted_to(
        np.array([2, 1]), taxels=4
    )
    assert part.taxels == 4
    assert part.density.tolist() == [3, 2]
    assert part.keep_out[0] is ball
    assert part.keep_out[1].vertices.tolist() == [True, False]
    assert PlacementSpec(pitch=0.01, density="curvature").restricted_to(np.array([0])).density == "curvature"


COARSE = sheet(40, 30, width=0.2, height=0.15)


def placed(surface, **requested):
    fine, spec = refine_for_spec(surface, PlacementSpec(**requested))
    return fine.mesh, place_taxels(fine.mesh, spec)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
@pytest.mark.parametrize("surface", [COARSE, frustum(), sphere()], ids=["sheet", "tube", "ball"])
def test_spacing_matches_the_requested_pitch(surface, pattern):
    mesh, taxels = placed(surface, pitch=0.009, pattern=pattern)
    assert len(taxels) == round(mesh.area / (HEXAGON_AREA * 0.009**2))
    assert taxels.areas.sum() == pytest.approx(mesh.area, rel=1e-12)
    apart = np.linalg.norm(np.diff(taxels.positions[taxels.neighbours], axis=1)[:, 0], axis=1)
    assert np.median(apart) == pytest.approx(0.009, rel=0.08)
    nearest = cKDTree(taxels.positions).query(taxels.positions, k=2)[0][:, 1]
    assert nearest.min() > 0.5 * 0.009


@pytest.mark.long
def test_number_of_taxels_follows_the_density():
    surface = sheet(60, 20, width=0.3, height=0.1)
    x = surface.vertices[:, 0] / 0.3
    _, taxels = placed(surface, taxels=600, density=16.0**x)
    slope = np.polyfit(taxels.positions[:, 0] / 0.3, np.log2(1 / taxels.areas), 1)[0]
    assert slope == pytest.approx(4, rel=0.1)
    step = np.where(x < 0.5, 9.0, 1.0)
    _, taxels = placed(surface, taxels=600, density=step)
    left = (taxels.positions[:, 0] < 0.14).sum() / (taxels.positions[:, 0] > 0.16).sum()
    assert left == pytest.approx(9, rel=0.12)


def test_only_ratios_of_densities_count():
    density = 1.0 + COARSE.vertices[:, 0]
    one, other = (placed(COARSE, taxels=80, density=scale * density)[1] for scale in (1.0, 1e6))
    assert one.positions == pytest.approx(other.positions, abs=1e-9)


@pytest.mark.long
def test_curvature_brings_taxels_to_the_rim_of_a_cup():
    surface = cup(3)
    even = placed(surface, taxels=200)[1].positions
    bent = placed(surface, taxels=200, density="curvature")[1].positions
    near = [np.abs(np.linalg.norm(p[:, :2], axis=1) - 0.02) + np.abs(p[:, 2]) < 0.004 for p in (even, bent)]
    assert near[1].sum() > 1.3 * near[0].sum() > 0


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("pattern", ["even", "hexagonal", "modules"])
def test_no_taxel_or_quadrature_point_is_in_a_zone(pattern):
    ball = SphereZone(np.array([0.1, 0.07, 0.0]), 0.02)
    mesh, taxels = placed(COARSE, pitch=0.005, pattern=pattern, keep_out=(ball, BoundaryZone(0.006)))
    for points in (taxels.positions, taxels.quadrature.positions):
        assert np.linalg.norm(points - ball.centre, axis=1).min() > ball.radius
        assert np.minimum(points[:, :2], [0.2, 0.15] - points[:, :2]).min() > 0.006
    felt = taxels.areas.sum()
    allowed = (0.2 - 0.012) * (0.15 - 0.012) - np.pi * ball.radius**2
    if pattern == "modules":
        assert felt < allowed
    else:
        assert allowed * 0.93 < felt <= allowed
        assert len(taxels) == round(felt / (HEXAGON_AREA * 0.005**2))
    assert mesh.area == pytest.approx(0.03)


@pytest.mark.long
def test_painted_density_is_transferred_to_the_divided_surface():
    marked = COARSE.vertices[:, 0] < 0.05
    density = 1 + COARSE.vertices[:, 1]
    fine, spec = refine_for_spec(COARSE, PlacementSpec(pitch=0.004, density=density, keep_out=(PaintedZone(marked),)))
    assert len(fine.mesh.vertices) > 2 * len(COARSE.vertices)
    assert spec.density == pytest.approx(1 + fine.mesh.vertices[:, 1], abs=1e-8)
    taxels = place_taxels(fine.mesh, spec)
    assert taxels.positions[:, 0].min() >= 0.05 - 1e-9
    assert taxels.areas.sum() == pytest.approx(0.15 * 0.15, rel=1e-9)


@pytest.mark.parametrize(
    "requested", [{"taxels": 60}, {"taxels": 60, "pattern": "hexagonal"}], ids=["even", "hexagonal"]
)
def test_same_seed_gives_the_same_taxels_bit_for_bit(requested):
    one, two, other = (placed(frustum(), seed=seed, **requested)[1] for seed in (3, 3, 4))
    for name in ("positions", "areas", "neighbours", "faces"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert not np.array_equal(one.positions, other.positions)


def test_single_triangle_surface_gets_taxels():
    triangle = Mesh(0.01 * np.eye(3), np.array([[0, 1, 2]]))
    assert len(place_taxels(triangle, PlacementSpec(taxels=1))) == 1
    for pattern in ("even", "hexagonal"):
        mesh, taxels = placed(triangle, taxels=10, pattern=pattern)
        assert len(taxels) == 10
        assert taxels.areas.sum() == pytest.approx(mesh.area)


def test_pitch_larger_than_the_surface_gives_one_taxel():
    mesh, taxels = placed(sphere(), pitch=0.5)
    assert taxels.areas == pytest.approx([mesh.area])


def test_too_coarse_surface_is_rejected_with_a_remedy():
    with pytest.raises(SkinError, match=r"too coarse.*Divide"):
        place_taxels(COARSE, PlacementSpec(pitch=0.002))


SHEET = sheet(24, 16)
CORNERS = SHEET.corners
MIDDLES = CORNERS.mean(axis=1)
EDGE = float(np.linalg.norm(np.ptp(CORNERS, axis=1), axis=1).max())
SHARES = np.random.default_rng(0).dirichlet(np.ones(3), 300)
SAMPLES = np.einsum("sc,mcd->msd", SHARES, CORNERS)  # many points of each face


@pytest.mark.parametrize("height", [0.0, 0.006])
@pytest.mark.parametrize("radius", [0.001, 0.01, 0.03])
def test_faces_within_a_sphere_zone_are_excluded(radius, height):
    centre = np.array([0.0511, 0.0377, height])
    kept = allowed_faces(SHEET, [SphereZone(centre, radius)])
    away = np.linalg.norm(SAMPLES - centre, axis=2).min(axis=1)
    assert not kept[away < radius].any()
    assert kept[away > radius + 0.2 * EDGE].all()


def test_sphere_zone_smaller_than_a_face_excludes_it():
    assert (~allowed_faces(SHEET, [SphereZone(MIDDLES[100], 1e-6)])).sum() == 1


def test_faces_within_a_box_zone_are_excluded():
    low = np.array([0.02, 0.03, -1.0])
    high = np.array([0.0601, 0.05, 1.0])
    kept = allowed_faces(SHEET, [BoxZone(low, high)])
    points = SAMPLES
    middles = CORNERS.mean(axis=1)
    touched = ((low < points) & (points < high)).all(axis=2).any(axis=1)
    assert touched.any()
    assert not kept[touched].any()
    assert kept[((middles < low - EDGE) | (middles > high + EDGE)).any(axis=1)].all()


def test_faces_within_a_border_strip_are_excluded():
    kept = allowed_faces(SHEET, [BoundaryZone(0.0149)])
    edge = np.minimum(CORNERS[:, :, :2], [0.12, 0.08] - CORNERS[:, :, :2]).min(axis=(1, 2))
    assert np.array_equal(kept, edge >= 0.0149)


def test_border_zone_excludes_nothing_on_a_closed_surface():
    assert allowed_faces(sphere(), [BoundaryZone(0.5)]).all()


def test_faces_at_painted_vertices_are_excluded():
    marked = np.zeros(len(SHEET.vertices), dtype=bool)
    marked[30] = True
    kept = allowed_faces(SHEET, [PaintedZone(marked)])
    assert np.array_equal(~kept, (SHEET.faces == 30).any(axis=1))
    with pytest.raises(SkinError, match="one mark for each vertex"):
        allowed_faces(SHEET, [PaintedZone(marked[1:])])


def test_zones_are_combined_and_must_leave_some_surface():
    one = SphereZone(MIDDLES[0], 0.01)
    other = SphereZone(MIDDLES[-1], 0.02)
    both = allowed_faces(SHEET, [one, other])
    assert np.array_equal(both, allowed_faces(SHEET, [one]) & allowed_faces(SHEET, [other]))
    with pytest.raises(SkinError, match="nothing of the surface is left"):
        allowed_faces(SHEET, [SphereZone(np.zeros(3), 1.0)])


def test_curvature_is_correct_for_ball_tube_and_plane():
    assert curvature(sphere(radius=0.05, subdivisions=4)) * 0.05 == pytest.approx(np.sqrt(2), rel=0.07)
    assert curvature(frustum(0.04, 0.04, around=72)) * 0.04 == pytest.approx(1, rel=0.01)
    assert curvature(sheet()) == pytest.approx(0)


def test_density_does_not_depend_on_the_size_of_the_surface():
    small = cup(2)
    large = Mesh(10 * small.vertices, small.faces)
    assert curvature_density(large, over=0.1) == pytest.approx(curvature_density(small, over=0.01))


def test_rim_of_a_cup_is_denser_than_its_flat_bottom():
    surface = cup(3)
    density = curvature_density(surface, over=0.004)
    radius = np.linalg.norm(surface.vertices[:, :2], axis=1)
    assert density.min() >= 1
    assert density.max() < MAX_DENSITY_RATIO
    on_rim = (radius > 0.0199) & (surface.vertices[:, 2] > -1e-9)
    assert density[on_rim].min() > 1.5 * density[(radius < 0.01) & (surface.vertices[:, 2] > -1e-9)].max()


@pytest.mark.parametrize("surface", [sheet(), Mesh(0.01 * np.eye(3), np.array([[0, 1, 2]]))], ids=["sheet", "triangle"])
def test_flat_surface_has_uniform_density(surface):
    assert curvature_density(surface, over=0.01) == pytest.approx(1)


def test_paint_is_averaged_over_faces_and_its_length_checked():
    surface = sheet()
    painted = 1.0 + np.arange(len(surface.vertices))
    found = face_density(surface, PlacementSpec(taxels=5, density=painted), pitch=0.01)
    assert found[7] == pytest.approx(painted[surface.faces[7]].mean())
    assert face_density(surface, PlacementSpec(taxels=5), pitch=0.01).tolist() == [1.0] * len(surface.faces)
    with pytest.raises(SkinError, match="one value for each vertex"):
        face_density(surface, PlacementSpec(taxels=5, density=painted[1:]), pitch=0.01)


def test_needle_shaped_faces_are_refined_only_as_far_as_taxels_require():
    needle = spiked(1e5)
    mesh, taxels = placed(needle, taxels=100)
    assert len(taxels) == 100
    assert len(mesh.faces) <= 50 * 100 * 1.01 + 4 * len(needle.faces)
    assert mesh.area == pytest.approx(needle.area)
