"""Placing as asked for: the number, the spacing, the density, the zones, and the same again from the same seed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.skin.placement_spec import Ball, BorderStrip, Painted, PlacementSpec
from app.skin.placing.place import HEXAGON, divided, place
from tests.numerics.map_surfaces import cup, frustum, sheet, sphere

COARSE = sheet(40, 30, width=0.2, height=0.15)


def placed(surface, **wanted):
    fine, spec = divided(surface, PlacementSpec(**wanted))
    return fine.mesh, place(fine.mesh, spec)


@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
@pytest.mark.parametrize("surface", [COARSE, frustum(), sphere()], ids=["sheet", "tube", "ball"])
def test_a_pitch_is_kept(surface, pattern):
    mesh, taxels = placed(surface, pitch=0.009, pattern=pattern)
    assert len(taxels) == round(mesh.area / (HEXAGON * 0.009**2))
    assert taxels.areas.sum() == pytest.approx(mesh.area, rel=1e-12)
    apart = np.linalg.norm(np.diff(taxels.positions[taxels.neighbours], axis=1)[:, 0], axis=1)
    assert np.median(apart) == pytest.approx(0.009, rel=0.08)
    nearest = cKDTree(taxels.positions).query(taxels.positions, k=2)[0][:, 1]
    assert nearest.min() > 0.5 * 0.009


@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_a_number_is_kept(count, pattern):
    _, taxels = placed(frustum(), taxels=count, pattern=pattern)
    assert len(taxels) == count
    assert taxels.areas.min() > 0


def test_there_are_as_many_more_as_the_density_says():
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


def test_curvature_brings_taxels_to_the_rim_of_a_cup():
    surface = cup(3)
    even = placed(surface, taxels=200)[1].positions
    bent = placed(surface, taxels=200, density="curvature")[1].positions
    near = [np.abs(np.linalg.norm(p[:, :2], axis=1) - 0.02) + np.abs(p[:, 2]) < 0.004 for p in (even, bent)]
    assert near[1].sum() > 1.3 * near[0].sum() > 0


@pytest.mark.parametrize("pattern", ["even", "hexagonal", "modules"])
def test_no_taxel_lies_or_feels_in_a_zone(pattern):
    ball = Ball(np.array([0.1, 0.07, 0.0]), 0.02)
    mesh, taxels = placed(COARSE, pitch=0.005, pattern=pattern, keep_out=(ball, BorderStrip(0.006)))
    for points in (taxels.positions, taxels.quadrature.positions):
        assert np.linalg.norm(points - ball.centre, axis=1).min() > ball.radius
        assert np.minimum(points[:, :2], [0.2, 0.15] - points[:, :2]).min() > 0.006
    felt = taxels.areas.sum()
    allowed = (0.2 - 0.012) * (0.15 - 0.012) - np.pi * ball.radius**2
    if pattern == "modules":
        assert felt < allowed
    else:
        assert allowed * 0.93 < felt <= allowed
        assert len(taxels) == round(felt / (HEXAGON * 0.005**2))
    assert mesh.area == pytest.approx(0.03)


def test_what_is_painted_is_carried_to_the_divided_surface():
    marked = COARSE.vertices[:, 0] < 0.05
    density = 1 + COARSE.vertices[:, 1]
    fine, spec = divided(COARSE, PlacementSpec(pitch=0.004, density=density, keep_out=(Painted(marked),)))
    assert len(fine.mesh.vertices) > 2 * len(COARSE.vertices)
    assert spec.density == pytest.approx(1 + fine.mesh.vertices[:, 1], abs=1e-8)
    taxels = place(fine.mesh, spec)
    assert taxels.positions[:, 0].min() >= 0.05 - 1e-9
    assert taxels.areas.sum() == pytest.approx(0.15 * 0.15, rel=1e-9)


@pytest.mark.parametrize("wanted", [{"taxels": 60}, {"taxels": 60, "pattern": "hexagonal"}], ids=["even", "hexagonal"])
def test_the_same_seed_gives_the_same_taxels_bit_for_bit(wanted):
    one, two, other = (placed(frustum(), seed=seed, **wanted)[1] for seed in (3, 3, 4))
    for name in ("positions", "areas", "neighbours", "faces"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert not np.array_equal(one.positions, other.positions)


def test_a_surface_of_one_triangle():
    triangle = Mesh(0.01 * np.eye(3), np.array([[0, 1, 2]]))
    assert len(place(triangle, PlacementSpec(taxels=1))) == 1
    for pattern in ("even", "hexagonal"):
        mesh, taxels = placed(triangle, taxels=10, pattern=pattern)
        assert len(taxels) == 10
        assert taxels.areas.sum() == pytest.approx(mesh.area)


def test_a_pitch_larger_than_the_surface_gives_one_taxel():
    mesh, taxels = placed(sphere(), pitch=0.5)
    assert taxels.areas == pytest.approx([mesh.area])


def test_a_surface_too_coarse_is_refused_with_a_remedy():
    with pytest.raises(SkinError, match=r"too coarse.*Divide"):
        place(COARSE, PlacementSpec(pitch=0.002))
