"""The sense of touch as a whole."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.lost import DWELL, GAP, MISSED
from app.contacts.sense import ContactSense
from app.touch.sensor.area_averaging import AreaAveraging
from app.touch.sensor.dead_taxels import DeadTaxels
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from app.touch.sensor.sampling import Sampling
from tests.touch import arm, prepared_bar

BAR = prepared_bar()
PRESSED = np.where(np.arange(len(BAR.skin)) == 7, 5e3, 0.0)
HOME = BAR.robot.home


def test_it_tells_regions_and_events():
    sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
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


@pytest.mark.parametrize(("sensor", "wait"), [
    (SensorEffects(), DWELL),
    (SensorEffects(area_averaging=AreaAveraging()), GAP),
    (SensorEffects(dead_taxels=DeadTaxels()), GAP),
    (SensorEffects(sampling=Sampling(5.0)), MISSED / 5.0),
])  # fmt: skip
def test_how_long_a_contact_is_awaited_follows_the_sensor(sensor, wait):
    for waited, released in ((0.99 * wait, False), (1.01 * wait, True)):
        sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
        sense.trust(sensor)
        sense.read(1, 0.0, HOME, PRESSED)
        sense.read(2, 0.005, HOME, 0 * PRESSED)
        sense.read(3, 0.005 + waited, HOME, 0 * PRESSED)
        assert ("release" in [event.kind for event in sense.recent]) is released


def test_without_skin_nothing_is_felt():
    sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
    sense.read(1, 0.01, HOME, PRESSED)
    assert sense.read(2, 0.02, HOME, None) == ()
    assert sense.read(3, 0.02 + DWELL, HOME, None) == ()
    assert sense.recent[0].kind == "release"


def test_error_bars_follow_the_sensor():
    sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
    assert sense.read(1, 0.01, HOME, PRESSED)[0].force_error == 0
    sense.trust(SensorEffects(noise=Noise(100.0)))
    assert sense.read(2, 0.02, HOME, PRESSED)[0].force_error > 0


def test_two_links_touched_apart_are_no_self_touch():
    prepared = arm()
    skin, pressed = prepared.skin, np.zeros(len(prepared.skin))
    pressed[[int(skin.first[0]), int(skin.first[2])]] = 5e3
    sense = ContactSense(prepared.robot, prepared.map, SensorEffects())
    regions = sense.read(1, 0.01, prepared.robot.home, pressed)
    assert len({region.link for region in regions}) == 2
    assert [region.partner for region in regions] == [0, 0]


def test_an_edited_map_is_used():
    sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
    sense.use(BAR.map)
    assert sense.read(1, 0.01, HOME, PRESSED)[0].id == 1
