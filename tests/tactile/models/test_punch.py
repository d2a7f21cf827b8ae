"""Punch: the force acts where the solver says, to rounding, or the notes say that it does not."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Box, Load, Sphere, sphere_load
from tactile_maps.tactile.models.punch import PunchModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import arm, bar_skin, each_point_a_taxel

UP = np.array([0.0, 0.0, 1.0])
MIDDLE = np.array([0.2, 0.0, 0.02])


FLAT = each_point_a_taxel(bar_skin(finer=2))


def at_places(skin: Skin):
    return np.concatenate([patch.taxels.positions for patch in skin.patches])


def shifted(load: Load, by) -> Load:
    """The same force at the same place, from a body that is said to be elsewhere."""
    pose = Pose(load.pose.rotation, load.pose.translation + np.asarray(by))
    return Load(load.link, load.point, load.normal, load.force, load.shape, pose, load.by)


def off(skin: Skin, pressures, load: Load) -> float:
    """Distance along the skin between the centre of pressure and the load [m]."""
    forces = pressures * skin.areas
    aside = forces @ (at_places(skin) - load.point) / forces.sum()
    return float(np.linalg.norm(aside - (aside @ load.normal) * load.normal))


@pytest.mark.parametrize("radius", [0.01, 0.05, 0.4])
@pytest.mark.parametrize("by", [(0, 0, 0), (1e-3, 0, 0), (-0.5e-3, 2e-3, 1e-3)])
def test_force_and_centre_equal_those_of_the_load(radius, by):
    model = PunchModel(FLAT)
    load = shifted(sphere_load("bar", MIDDLE + [1e-3, 2e-3, 0], UP, 20.0, radius), by)
    pressures = model.pressures([load])
    assert pressures @ FLAT.areas == pytest.approx(20.0, rel=1e-9)
    assert off(FLAT, pressures, load) < 1e-9
    assert model.notes == ()
    if any(by):
        assert off(FLAT, WaterFillModel(FLAT).pressures([load]), load) > 1e-4, "water-fill believes the body"


def test_force_and_centre_of_a_box_on_its_edge_are_matched():
    load = Load(
        "bar", MIDDLE + [0.004, 0.003, 0], UP, 30.0, Box((0.02, 0.01, 0.01)), Pose(np.eye(3), MIDDLE + [0, 0, 0.0095])
    )
    model = PunchModel(FLAT)
    pressures = model.pressures([load])
    assert model.notes == ()
    assert off(FLAT, pressures, load) < 1e-9
    assert pressures[at_places(FLAT)[:, 0] > 0.21].sum() > 2 * pressures[at_places(FLAT)[:, 0] < 0.19].sum()


def test_centre_of_pressure_is_kept_on_the_curved_links_of_an_arm():
    skin = each_point_a_taxel(arm().skin)
    model = PunchModel(skin)
    generator = np.random.default_rng(0)
    matched = 0
    for _ in range(40):
        patch = skin.patches[generator.integers(len(skin.patches))]
        taxel = generator.integers(len(patch.taxels))
        point = patch.taxels.positions[taxel]
        normal = patch.taxels.normals[taxel]
        load = shifted(sphere_load(patch.link, point, normal, 15.0, 0.02), generator.normal(scale=5e-4, size=3))
        forces = model.pressures([load]) * skin.areas
        assert forces.sum() == pytest.approx(15.0, rel=1e-9)
        if not model.notes:
            matched += 1
            aside = np.where(forces > 0, forces, 0) @ (at_places(skin) - point) / 15.0
            assert np.linalg.norm(aside - (aside @ normal) * normal) < 1e-9
    assert matched > 25, "the others are at borders, or press one point"


def test_centre_outside_the_points_keeps_the_force_and_is_noted():
    load = sphere_load("bar", MIDDLE, UP, 5.0, 0.01)
    nearby = Load("bar", np.array([-0.05, 0.0, 0.02]), UP, 5.0, load.shape, load.pose, "thumb")
    model = PunchModel(FLAT)
    pressures = model.pressures([nearby])
    np.testing.assert_array_equal(pressures, WaterFillModel(FLAT).pressures([nearby]))
    assert model.notes == (ContactNote(ContactNoteKind.MOMENT_IGNORED, ("thumb", "bar")),)
    model.pressures([load])
    assert model.notes == (), "notes are of the last reading"


def test_contact_smaller_than_the_point_spacing_is_detected():
    skin = bar_skin()
    for step in np.linspace(0, 8e-3, 9):
        load = sphere_load("bar", MIDDLE + [step, 0.3 * step, 0], UP, 0.5, 0.002)
        assert PunchModel(skin).pressures([load]) @ skin.areas == pytest.approx(0.5, rel=1e-9)


def test_large_tilt_reaches_points_that_the_untilted_body_does_not_touch():
    """The neighbourhood is searched again, wider, until the tilted body is all in it."""
    skin = FLAT
    load = Load("bar", MIDDLE + [0.03, 0, 0], UP, 200.0, Sphere(2.0), Pose(np.eye(3), MIDDLE + [0, 0, 2.0]))
    model = PunchModel(skin, layer=ElasticLayer(modulus=2e4))
    pressures = model.pressures([load])
    assert model.notes == ()
    assert off(skin, pressures, load) < 1e-9
    straight = WaterFillModel(skin, layer=ElasticLayer(modulus=2e4)).pressures([load])
    assert ((pressures > 0) & (straight == 0)).any()
