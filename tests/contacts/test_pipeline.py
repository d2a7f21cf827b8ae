"""Contact detection, and the whole pipeline from readings to contacts."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.detection.tracking import DWELL, GAP, MISSED
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings, read_contacts, reading_from
from tactile_maps.core.errors import MapError, SceneError
from tactile_maps.tactile.press import press_skin
from tactile_maps.tactile.sensors.sensor_effects import AreaAveraging, DeadTaxels, Sampling, SensorEffects
from tests.support.touch import arm, prepared_bar


@pytest.mark.parametrize(("noise", "threshold"), [(0.0, 1000.0), (333.0, 1000.0), (400.0, 1200.0), (2e3, 6e3)])
def test_threshold_stays_above_the_noise(noise, threshold):
    assert ReadingSettings().threshold_for(SensorUncertainty(noise=noise)) == threshold


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"estimator": "tikonov"}, "contacts.estimator.*unknown force estimator.*tikonov.*Did you mean tikhonov"),
        ({"estimator": 3}, "contacts.estimator"),
        ({"threshold": 0.0}, "contacts.threshold.*0 Pa.*Choose 1 to 1e\\+11 Pa"),
        ({"threshold": float("nan")}, "contacts.threshold"),
        ({"threshold": float("inf")}, "contacts.threshold"),
        ({"threshold": True}, "contacts.threshold"),
        ({"threshold": "high"}, "contacts.threshold.*high"),
        ({"wrench_noise": -1.0}, "contacts.wrench_noise.*Choose 0 to 10 N"),
        ({"threshold_pa": 1e3}, "contacts.threshold_pa.*no such key.*Did you mean threshold"),
    ],
)
def test_invalid_entry_is_reported_with_its_place(values, words):
    with pytest.raises(SceneError, match=words):
        reading_from(values)


BAR = prepared_bar()
PRESSED = np.where(np.arange(len(BAR.skin)) == 7, 5e3, 0.0)
HOME = BAR.robot.home


def test_pipeline_returns_regions_and_events():
    sense = ContactPipeline(BAR.robot, BAR.map, SensorEffects())
    (region,) = sense.read(1, 0.01, HOME, PRESSED)
    assert region.id == 1
    assert [event.kind for event in sense.recent] == ["touch"]
    assert sense.read(2, 0.02, HOME, 0 * PRESSED) == ()
    assert sense.read(3, 0.02 + 0.99 * DWELL, HOME, 0 * PRESSED) == ()
    assert [event.kind for event in sense.recent] == ["touch"], "it may come back"
    assert sense.read(4, 0.02 + DWELL, HOME, 0 * PRESSED) == ()
    assert [event.kind for event in sense.recent] == ["release", "tap", "touch"]
    assert sense.recent[0].duration == pytest.approx(0.01), "until it was gone, not until that was certain"
    sense.reset()
    assert sense.recent == ()
    assert sense.read(1, 0.01, HOME, PRESSED)[0].id == 1


@pytest.mark.parametrize(
    ("sensor", "wait"),
    [
        (SensorEffects(), DWELL),
        (SensorEffects(area_averaging=AreaAveraging()), GAP),
        (SensorEffects(dead_taxels=DeadTaxels()), GAP),
        (SensorEffects(sampling=Sampling(5.0)), MISSED / 5.0),
    ],
)
def test_time_to_wait_for_a_lost_contact_follows_from_the_sensor(sensor, wait):
    for waited, released in ((0.99 * wait, False), (1.01 * wait, True)):
        sense = ContactPipeline(BAR.robot, BAR.map, SensorEffects())
        sense.set_sensor_model(sensor)
        sense.read(1, 0.0, HOME, PRESSED)
        sense.read(2, 0.005, HOME, 0 * PRESSED)
        sense.read(3, 0.005 + waited, HOME, 0 * PRESSED)
        assert ("release" in [event.kind for event in sense.recent]) is released


def test_force_from_pads_below_the_surface_is_less_certain():
    pads = SensorEffects(area_averaging=AreaAveraging(0.001))
    sense = ContactPipeline(BAR.robot, BAR.map, SensorEffects(), depth=0.001)
    found = []
    for tick, model in enumerate(("water-fill", "half-space")):
        sense.set_sensor_model(pads, model=model)
        found.append(sense.read(tick, 0.01 * tick, HOME, PRESSED)[0])
    surface, deep = found
    widths = [region.force_interval[1] - region.force for region in (surface, deep)]
    assert widths[1] > 3 * widths[0]
    assert deep.place_error > surface.place_error


def test_each_taxel_has_a_threshold_above_its_own_measured_noise():
    noisy, other = BAR.skin.neighbours[30].tolist()
    sd = np.full(len(BAR.skin), 10.0)
    sd[noisy] = 1000.0
    sense = ContactPipeline(BAR.robot, BAR.map, SensorEffects())
    sense.set_measured_noise(TaxelNoise(sd, np.full(len(sd), 1e9)))
    pressures = np.zeros(len(sd))
    pressures[noisy] = pressures[other] = 2500.0
    (region,) = sense.read(1, 0.01, HOME, pressures)
    assert (region.touched, region.area) == (1, BAR.skin.areas[other])
    assert region.force_parts["noise"] == pytest.approx(np.linalg.norm((sd * BAR.skin.areas)[region.taxels]))
    assert region.place_error > 0
    sense.settings = ReadingSettings(threshold=2000.0)
    assert sense.read(2, 0.02, HOME, pressures)[0].touched == 2
    sense.reset()
    pressures[other] = 0.0
    assert sense.read(3, 0.03, HOME, pressures) == (), "a new contact has to exceed the noise"
    pressures[noisy] = 7000.0
    assert len(sense.read(4, 0.04, HOME, pressures)) == 1
    sense.set_measured_noise(None)
    assert sense.read(5, 0.05, HOME, pressures)[0].force_error == 0.0


@pytest.mark.parametrize("estimator", ["local-nnls", "tikhonov"])
def test_estimators_use_the_noise_of_the_contact(estimator):
    sense = ContactPipeline(BAR.robot, BAR.map, SensorEffects(), settings=ReadingSettings(estimator))
    exact = sense.read(1, 0.01, HOME, PRESSED)
    assert sense.estimates[exact[0].id].noise == 0.0
    sd = np.full(len(BAR.skin), 1e3)
    sd[exact[0].taxels] = 10.0
    sense.set_measured_noise(TaxelNoise(sd, np.full(len(sd), 1e9)))
    (region,) = sense.read(2, 0.02, HOME, PRESSED)
    assert sense.estimates[region.id].noise == pytest.approx(10.0)


def test_separate_touches_of_two_links_are_not_a_self_touch():
    prepared = arm()
    skin = prepared.skin
    pressed = np.zeros(len(prepared.skin))
    pressed[[int(skin.first[0]), int(skin.first[2])]] = 5e3
    sense = ContactPipeline(prepared.robot, prepared.map, SensorEffects())
    regions = sense.read(1, 0.01, prepared.robot.home, pressed)
    assert len({region.link for region in regions}) == 2
    assert [region.partner for region in regions] == [None, None]


@pytest.mark.parametrize("estimator", ["area-sum", "local-nnls", "tikhonov"])
def test_single_reading_is_processed_without_history(estimator):
    prepared = prepared_bar()
    skin = prepared.skin
    at = prepared.skin.taxel_point(30)
    pressures = press_skin(skin, at, force=3.0, model="water-fill" if estimator == "area-sum" else "half-space")
    (contact,) = read_contacts(prepared.map, pressures, estimator=estimator)
    assert contact.force == pytest.approx(3.0, rel=1e-9 if estimator == "area-sum" else 0.2)
    assert np.linalg.norm(contact.link_position - skin.position(at)) < 0.01
    assert read_contacts(prepared.map, pressures, threshold=1e6) == ()


def test_invalid_reading_is_rejected():
    map_ = prepared_bar().map
    with pytest.raises(MapError, match="pressures do not fit this skin"):
        read_contacts(map_, np.zeros(3))
    with pytest.raises(MapError, match="not read from pressures"):
        read_contacts(map_, np.zeros(len(map_.skin)), estimator="lumped")
    with pytest.raises(SceneError, match="unknown force estimator"):
        read_contacts(map_, np.zeros(len(map_.skin)), estimator="nnls")
