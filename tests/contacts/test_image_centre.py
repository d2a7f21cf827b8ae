"""A contact's centre from an image's pixels: as that of an image that was rendered, and back by three taxels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.detection.image_centre import BACK_PROJECTIONS, CentreSettings
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings
from tactile_maps.core.errors import SceneError
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects
from tests.support.touch import arm

PREPARED = arm()
ROBOT = PREPARED.robot
MAP = PREPARED.map
TAXEL = 150


@pytest.fixture(scope="module")
def pressures():
    """Pressures of a touch well inside a patch: highest at one taxel, lower at its neighbours."""
    found = np.zeros(len(MAP.skin))
    pairs = MAP.skin.neighbours
    around = np.setdiff1d(pairs[(pairs == TAXEL).any(axis=1)], TAXEL)
    found[TAXEL] = 12e3
    found[around] = np.linspace(2e3, 7e3, len(around))
    return found


def centre(pressures, **settings):
    (region,) = ContactDetector(MAP, centre=CentreSettings(**settings)).read(pressures)
    return region


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("pixel", "interpolation"), [(0.001, "barycentric"), *((0.004, one) for one in INTERPOLATIONS)]
)
def test_image_centre_is_the_weighted_mean_of_the_rendered_pixels(pressures, pixel, interpolation):
    found = centre(pressures, pixel=pixel, interpolation=interpolation)
    image = TactileImage(MAP, resolution=pixel, interpolation=interpolation)
    own = np.zeros_like(pressures)
    own[found.taxels] = pressures[found.taxels]
    shown = image.render(own).ravel().astype(np.float64)
    expected = shown @ image.centres() / shown.sum()
    assert found.map_point == pytest.approx(expected, abs=1e-5 * pixel + 1e-7)
    assert found.force == centre(pressures).force


def test_centre_from_three_taxels_weights_positions_and_normals_by_proximity(pressures):
    usual = centre(pressures)
    found = centre(pressures, back_projection="three-taxels")
    assert np.array_equal(found.map_point, usual.map_point)
    patch = MAP.skin.patches[usual.at.patch]
    first = MAP.skin.first[usual.at.patch]
    points = MAP.taxel_points[first : first + len(patch.taxels)]
    away = np.linalg.norm(points - usual.map_point, axis=1)
    near = np.argsort(away)[:3]
    share = 1 / away[near]
    share /= share.sum()
    assert found.link_position == pytest.approx(share @ patch.taxels.positions[near])
    normal = share @ patch.taxels.normals[near]
    assert found.link_normal == pytest.approx(normal / np.linalg.norm(normal))
    assert 0 < np.linalg.norm(found.link_position - usual.link_position) < 0.01


def test_centre_on_a_taxel_is_projected_back_to_it():
    projector = ContactDetector(MAP, centre=CentreSettings(back_projection="three-taxels"))._projector
    place = projector.place(0, MAP.taxel_points[20], near=projector.face_of(20))
    assert place.link_position == pytest.approx(MAP.skin.patches[0].taxels.positions[20], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "value"),
    [("pixel", 0.0), ("pixel", 1.0), ("pixel", float("nan")), ("interpolation", "cubic"), ("back_projection", "ray")],
)
def test_unknown_setting_is_rejected_with_the_valid_ones(name, value):
    with pytest.raises(SceneError, match=name) as refused:
        ReadingSettings(**{name: value})
    assert "Choose" in str(refused.value)


def test_settings_can_change_during_a_session_without_new_contact_ids(pressures):
    pipeline = ContactPipeline(ROBOT, MAP, SensorEffects())
    posture = ROBOT.home
    before = pipeline.read(0, 0.0, posture, pressures)[0]
    pipeline.settings = replace(pipeline.settings, pixel=0.016, interpolation="nearest")
    (after,) = pipeline.read(1, 0.005, posture, pressures)
    assert after.id == before.id
    assert not np.array_equal(after.map_point, before.map_point)
    for back in BACK_PROJECTIONS:
        pipeline.settings = ReadingSettings(back_projection=back)
        (again,) = pipeline.read(2, 0.01, posture, pressures)
        assert np.array_equal(again.map_point, before.map_point)
