"""The sense of touch as a whole."""

from __future__ import annotations

import numpy as np

from app.contacts.sense import ContactSense
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
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
    assert [event.kind for event in sense.recent] == ["release", "tap", "touch"]
    sense.reset()
    assert sense.recent == ()
    assert sense.read(1, 0.01, HOME, PRESSED)[0].id == 1


def test_without_skin_nothing_is_felt():
    sense = ContactSense(BAR.robot, BAR.map, SensorEffects())
    sense.read(1, 0.01, HOME, PRESSED)
    assert sense.read(2, 0.02, HOME, None) == ()
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
