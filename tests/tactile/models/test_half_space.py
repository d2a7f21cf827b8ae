"""The half-space model: the blur of theory, on flat skin and across seams, with every newton kept."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.half_space_stress import point_stress, subsurface_field
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.mechanics.receptive_field import disc_field, quadrature_points
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tests.support.references import disc_stress
from tests.support.touch import arm, bar_skin, each_point_a_taxel

pytestmark = pytest.mark.long

UP = np.array([0.0, 0.0, 1.0])
MIDDLE = np.array([0.2, 0.0, 0.02])
FINE = bar_skin(480, finer=4, length=0.12)


def press(force=5.0, radius=0.008, at=(0, 0, 0), link="bar"):
    return sphere_load(link, MIDDLE + at, UP, force, radius)


def places(skin):
    return np.concatenate([patch.taxels.positions for patch in skin.patches])


def place_of_a_point(skin, depth):
    """The quadrature point that is felt closest to where it is: taken together with others, it moves the least."""
    points = quadrature_points(skin)
    cluster = subsurface_field(skin, depth).cluster
    whole = np.bincount(cluster, points.areas)
    middles = np.stack([np.bincount(cluster, points.areas * points.positions[:, k]) / whole for k in range(3)], axis=1)
    off = np.linalg.norm(points.positions - middles[cluster], axis=1) + (points.areas < 0.99 * points.areas.max())
    return points.positions[(off + 0.01 * np.linalg.norm(points.positions - MIDDLE, axis=1)).argmin()]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("depth", [0.5e-3, 2e-3, 8e-3])
def test_force_is_conserved_to_rounding_everywhere(depth):
    skin = arm().skin
    model = HalfSpaceModel(skin, layer=ElasticLayer(depth=depth))
    generator = np.random.default_rng(0)
    for _ in range(20):
        patch = skin.patches[generator.integers(len(skin.patches))]
        taxel = generator.integers(len(patch.taxels))
        load = sphere_load(patch.link, patch.taxels.positions[taxel], patch.taxels.normals[taxel], 7.0, 0.01)
        assert model.pressures([load]) @ skin.areas == pytest.approx(7.0, rel=1e-9)


def test_small_contact_follows_boussinesq():
    points = quadrature_points(FINE)
    point = place_of_a_point(FINE, 4e-3)
    depth = 4e-3
    load = sphere_load("bar", point, UP, 1e-4, 1e-3)  # so small a force that one point bears it
    pressures = 1e4 * HalfSpaceModel(FINE, layer=ElasticLayer(depth=depth), share=1e-3).pressures([load])
    stress = point_stress(np.linalg.norm(points.positions - point, axis=1), depth)
    expected = np.bincount(points.taxel, points.areas * stress) / FINE.areas
    assert (expected > 0.1 * expected.max()).sum() > 3, "a taxel is 5 mm wide, a point 2"
    np.testing.assert_allclose(pressures, expected, atol=0.05 * expected.max())


@pytest.mark.parametrize("depth", [4e-3, 8e-3])
def test_grouping_points_keeps_the_position_of_a_contact(depth):
    skin = each_point_a_taxel(bar_skin(finer=2))
    at = places(skin)
    rows = np.flatnonzero(np.linalg.norm(at - MIDDLE, axis=1) < 0.01)
    field = subsurface_field(skin, depth)
    for row in rows:
        pressures = np.zeros(len(skin))
        field.add(pressures, np.array([row]), np.ones(1))
        aside = (pressures * skin.areas) @ (at - at[row])
        assert np.linalg.norm(aside) < 0.15 * depth


@pytest.mark.long
def test_uniform_pressure_on_a_disc_follows_love_on_its_axis():
    points = quadrature_points(FINE)
    radius = 0.012
    depth = 0.005
    field = subsurface_field(FINE, depth, share=1e-3)
    pressed = np.flatnonzero(np.linalg.norm(points.positions - MIDDLE, axis=1) < radius)
    pressures = np.zeros(len(FINE))
    field.add(pressures, pressed, points.areas[pressed])
    centre = np.linalg.norm(places(FINE) - MIDDLE, axis=1).argmin()
    assert pressures[centre] == pytest.approx(disc_stress(radius, depth), rel=0.04)


def test_seam_between_patches_of_a_link_is_not_a_border():
    """The plate cut in two feels, point for point, what the whole one does."""
    whole = bar_skin(finer=2).patches[0]
    left = whole.surface.vertices[whole.surface.faces].mean(axis=1)[:, 0] < MIDDLE[0]
    halves = [Mesh(whole.surface.vertices, whole.surface.faces[side]) for side in (left, ~left)]
    pieces = (Patch(str(k), "bar", half, place_evenly(half, 4, seed=0)) for k, half in enumerate(halves))
    one = each_point_a_taxel(Skin((whole,)))
    cut = each_point_a_taxel(Skin(tuple(pieces)))
    load = press(5.0, 0.004, at=(-0.005, 0, 0))
    layer = ElasticLayer(depth=5e-3)
    felt, apart = (HalfSpaceModel(skin, layer=layer).pressures([load]) for skin in (one, cut))
    assert 0.5 < (felt * one.areas)[~left].sum() < 2.5, "some of it is felt on the other side"
    np.testing.assert_allclose(apart, np.concatenate([felt[left], felt[~left]]), rtol=1e-9, atol=1e-9)


@pytest.mark.long
def test_far_side_of_a_thin_link_has_zero_readings():
    plate = FINE.patches[0].surface
    back = Mesh(plate.vertices - [0, 0, 0.002], plate.faces[:, ::-1])
    both = (
        Patch("top", "bar", plate, place_evenly(plate, 100, seed=0)),
        Patch("back", "bar", back, place_evenly(back, 100, seed=0)),
    )
    pressures = HalfSpaceModel(Skin(both), layer=ElasticLayer(depth=5e-3)).pressures([press()])
    assert pressures[:100].any()
    assert not pressures[100:].any()


def test_pads_average_the_transmitted_pressure():
    """Cells and pads read a uniform pressure unchanged."""
    points = quadrature_points(FINE)
    inner = (np.abs(places(FINE) - MIDDLE) < [0.04, 0.03, 1]).all(axis=1)
    for field in (None, disc_field(FINE, 0.003)):
        pressures = np.zeros(len(FINE))
        subsurface_field(FINE, 2e-3, field=field).add(pressures, np.arange(len(points.areas)), 1e4 * points.areas)
        assert inner.sum() > 100
        np.testing.assert_allclose(pressures[inner], 1e4, rtol=0.05)
