"""Noise makes no contacts, and hides none that stand out of it."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.accuracy import ReadingErrors
from app.contacts.reader import THRESHOLD, ContactReader
from app.contacts.reading_settings import ReadingSettings
from app.maps.build import build_map
from app.touch.load import ball_load
from app.touch.models.water_fill import WaterFill
from tests.touch import bar_skin

SKIN = bar_skin(400)
MAP = build_map(SKIN)
UP = np.array([0.0, 0.0, 1.0])


def reader(noise: float) -> ContactReader:
    errors = ReadingErrors(noise=noise)
    return ContactReader(MAP, threshold=ReadingSettings().threshold_for(errors), errors=errors)


@pytest.mark.parametrize("noise", [100.0, 500.0, 2000.0])
def test_noise_alone_is_no_contact(noise):
    random, own = np.random.default_rng(0), reader(noise)
    high, found = 0, 0
    for _ in range(2000):
        pressures = random.normal(0, noise, len(SKIN))
        high += int((pressures >= own.threshold).sum())
        found += len(own.read(pressures))
    assert high > 500 or noise < THRESHOLD / 3, "many a taxel reads three deviations"
    assert found == 0


@pytest.mark.parametrize("noise", [500.0, 2000.0])
def test_a_contact_that_stands_out_is_found_and_stays_one(noise):
    random, own = np.random.default_rng(0), reader(noise)
    exact = WaterFill(SKIN).pressures([ball_load("bar", np.array([0.2, 0.0, 0.02]), UP, 10.0, 0.02)])
    assert exact.max() > 6 * noise
    ids = [[region.id for region in own.read(exact + random.normal(0, noise, len(SKIN)))] for _ in range(500)]
    assert all(ids)
    assert [seen for seen in ids if seen != [1]] == []


def test_many_taxels_that_just_touch_are_a_contact_and_few_are_not():
    """Four deviations on one taxel are noise, on nine they are not."""
    noise = 1000.0
    middle = int(np.hypot(*(SKIN.patches[0].taxels.positions[:, :2] - (0.2, 0.0)).T).argmin())
    around = np.argsort(
        np.linalg.norm(SKIN.patches[0].taxels.positions - SKIN.patches[0].taxels.positions[middle], axis=1)
    )
    for count, contacts in ((1, 0), (9, 1)):
        pressures = np.zeros(len(SKIN))
        pressures[around[:count]] = 4 * noise
        assert len(reader(noise).read(pressures)) == contacts


def test_what_was_not_believed_is_looked_at_again():
    """The same taxels, harder: the mask of touched taxels has not changed, its meaning has."""
    noise, own, pressures = 1000.0, reader(1000.0), np.zeros(len(SKIN))
    pressures[7] = 4 * noise
    assert own.read(pressures) == ()
    pressures[7] = 8 * noise
    assert [region.id for region in own.read(pressures)] == [1]
    pressures[7] = 1.6 * noise
    assert [region.id for region in own.read(pressures)] == [1], "it stays down to half of the threshold"
    pressures[30] = 8 * noise
    assert [region.id for region in own.read(pressures)] == [2, 1], "and is believed while others come"
    pressures[7] = 1.4 * noise
    pressures[30] = 0.0
    assert own.read(pressures) == ()


def test_a_light_touch_beside_a_firm_one_is_read():
    """Which a threshold of a tenth of the peak would hide."""
    loads = [ball_load("bar", np.array([x, 0.0, 0.02]), UP, force, 0.02) for x, force in ((0.1, 40.0), (0.3, 0.4))]
    pressures = WaterFill(SKIN).pressures(loads)
    light = WaterFill(SKIN).pressures(loads[1:])
    assert light.max() < 0.1 * pressures.max()
    assert len(reader(0.0).read(pressures)) == 2
