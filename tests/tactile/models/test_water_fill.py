"""Water-fill: force in is force out, where the body is, spread as a bed of springs bears it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Load, Plane, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import arm, bar_skin

SKIN = bar_skin()
UP = np.array([0.0, 0.0, 1.0])
MIDDLE = np.array([0.2, 0.0, 0.02])
FELT = WaterFillModel(SKIN)
STIFFNESS = ElasticLayer().foundation


def press(point, force=5.0, radius=0.008, *, link="bar", normal=UP):
    return sphere_load(link, np.asarray(point, dtype=float), normal, force, radius)


@pytest.mark.long
def test_sphere_on_a_flat_bed_sinks_by_the_winkler_formula():
    """F = π K R d² for a shallow sphere: the peak pressure is K d, and the touched area 2 π R d."""
    skin = bar_skin(1500, finer=4)
    force = 60.0
    radius = 0.05
    pressures = WaterFillModel(skin).pressures([press(MIDDLE, force, radius)])
    depth = np.sqrt(force / (np.pi * STIFFNESS * radius))
    assert 0.9 < pressures.max() / (STIFFNESS * depth) < 1.05, "a taxel averages over its area"
    half = pressures > 0.5 * STIFFNESS * depth  # where the sphere is half as deep: half the area
    assert skin.areas[half].sum() == pytest.approx(np.pi * radius * depth, rel=0.15)


@pytest.mark.long
def test_taxels_agree_with_a_dense_integral():
    """Every point is replaced by the rings of a flat bed under the true sphere, integrated with scipy's root finder."""
    skin = bar_skin(400, finer=4)
    force = 40.0
    radius = 0.03
    points = quadrature_points(skin)
    pressures = WaterFillModel(skin).pressures([press(MIDDLE, force, radius)])
    ring = np.linspace(0, 0.04, 20_001)
    gap = np.hypot(ring, radius) - radius

    def excess(depth):
        return np.trapezoid(2 * np.pi * ring * STIFFNESS * np.maximum(depth - gap, 0), ring) - force

    depth = brentq(excess, 0, 0.01)
    away = np.linalg.norm(points.positions - MIDDLE, axis=1)
    dense = STIFFNESS * np.maximum(depth - (np.hypot(away, radius) - radius), 0) * points.areas
    expected = np.bincount(points.taxel, dense, len(skin)) / skin.areas
    assert expected.max() > 1e4
    assert pressures == pytest.approx(expected, abs=0.02 * expected.max())


@pytest.mark.parametrize(
    ("shape", "high", "area"),
    [
        (Box((0.03, 0.02, 0.01)), 0.01, 0.06 * 0.04),
        (Cylinder(0.02, 0.01), 0.01, np.pi * 0.02**2),
        (Plane(), 0.0, 0.38 * 0.1),
    ],
)
def test_flat_bodies_press_uniformly_over_their_face(shape, high, area):
    skin = bar_skin(1500, finer=4)
    turn = np.diag([1.0, -1, -1])  # the plane's solid side is up
    load = Load("bar", MIDDLE, UP, 5.0, shape, Pose(turn, MIDDLE + high * UP))
    pressures = WaterFillModel(skin).pressures([load])
    assert pressures @ skin.areas == pytest.approx(5.0, rel=1e-12)
    assert np.median(pressures[pressures > 0]) == pytest.approx(5.0 / area, rel=0.05)


def test_tilted_box_presses_with_its_edge():
    turn = np.array([[np.cos(0.5), 0, np.sin(0.5)], [0, 1, 0], [-np.sin(0.5), 0, np.cos(0.5)]])
    edge = turn @ [0.02, 0, -0.02]
    load = Load("bar", MIDDLE, UP, 5.0, Box((0.02, 0.02, 0.02)), Pose(turn, MIDDLE - edge))
    force = FELT.pressures([load]) * SKIN.areas
    centre = force @ SKIN.patches[0].taxels.positions / force.sum()
    assert abs(centre[0] - MIDDLE[0]) < 0.012
    assert abs(centre[1]) < 0.006


def test_readings_do_not_depend_on_the_depth_of_the_body():
    shallow = FELT.pressures([press(MIDDLE)])
    for depth in (-0.01, 0.001, 0.004):
        load = sphere_load("bar", MIDDLE, UP, 5.0, 0.008, depth=depth)
        assert FELT.pressures([load]) @ SKIN.areas == pytest.approx(5.0, rel=1e-12)
    big = WaterFillModel(SKIN).pressures([sphere_load("bar", MIDDLE, UP, 5.0, 1e4, depth=1e-4)])
    assert big @ SKIN.areas == pytest.approx(5.0, rel=1e-12)
    assert shallow @ SKIN.areas == pytest.approx(5.0, rel=1e-12)


def test_earlier_loads_do_not_change_a_reading():
    generator = np.random.default_rng(0)
    covered = WaterFillModel(SKIN)
    point = np.array([0.1, 0.0, 0.02])
    for _ in range(150):
        point = np.clip(point + [*generator.normal(scale=0.0015, size=2), 0.0], [0.02, -0.04, 0.02], [0.38, 0.04, 0.02])
        load = press(point, float(generator.uniform(0.5, 20)))
        assert covered.pressures([load]).tobytes() == WaterFillModel(SKIN).pressures([load]).tobytes()


def test_sudden_force_is_spread_over_all_required_points():
    for force in (1e-3, 50.0, 1e-9, 1e6, 1e290, 1.0):
        pressures = FELT.pressures([press(MIDDLE, force)])
        assert pressures @ SKIN.areas == pytest.approx(force, rel=1e-12)
        fresh = WaterFillModel(SKIN).pressures([press(MIDDLE, force)])
        assert pressures.tobytes() == fresh.tobytes()
    assert np.count_nonzero(FELT.pressures([press(MIDDLE, 1e6)])) > 0.9 * len(SKIN), "all of the bar's top bears it"


def test_load_outside_the_skin_is_noted_and_not_read():
    assert not FELT.pressures([press((-0.2, 0, 0.02))]).any()
    assert FELT.notes == (ContactNote(ContactNoteKind.OUTSIDE_SKIN, ("bar",)),)
    assert FELT.pressures([press(MIDDLE)]).any()
    assert FELT.notes == ()


def test_body_at_the_edge_is_carried_by_the_nearest_point():
    load = press((0.005, 0, 0.02), normal=np.array([-1.0, 0, 0]))
    pressures = FELT.pressures([load])
    assert pressures @ SKIN.areas == pytest.approx(5.0, rel=1e-12)
    assert np.count_nonzero(pressures) == 1
    (note,) = FELT.notes
    assert note == ContactNote(ContactNoteKind.SKIN_EDGE, ("bar",))


def test_far_side_of_a_thin_link_has_zero_readings():
    skin = arm().skin
    taxels = skin.patches[1].taxels
    load = sphere_load("forearm", taxels.positions[10], taxels.normals[10], 8.0, 0.2)
    pressed = WaterFillModel(skin).pressures([load])[skin.first[1] : skin.first[2]] > 0
    assert pressed.any()
    assert (taxels.normals[pressed] @ taxels.normals[10] > 0).all()
