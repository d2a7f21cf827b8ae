"""How contacts are read is checked where it comes in."""

from __future__ import annotations

import pytest

from app.contacts.accuracy import ReadingErrors
from app.contacts.estimators.names import ESTIMATORS
from app.contacts.reader import THRESHOLD
from app.contacts.reading_settings import ReadingSettings, reading_from
from app.errors import SceneError


def test_the_usual_is_the_area_sum_above_the_usual_threshold():
    usual = reading_from({})
    assert usual == ReadingSettings()
    assert usual.estimator == "area-sum"
    assert usual.threshold_for(ReadingErrors()) == THRESHOLD


@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_estimator_can_be_named(name):
    assert reading_from({"estimator": name, "threshold": 2000}).estimator == name


@pytest.mark.parametrize(("noise", "threshold"), [(0.0, 1000.0), (333.0, 1000.0), (400.0, 1200.0), (2e3, 6e3)])
def test_the_threshold_stays_above_the_noise(noise, threshold):
    assert ReadingSettings().threshold_for(ReadingErrors(noise=noise)) == threshold


def test_what_a_person_sets_stands():
    assert ReadingSettings(threshold=200.0).threshold_for(ReadingErrors(noise=5e3)) == 200.0


@pytest.mark.parametrize(("values", "words"), [
    ({"estimator": "tikonov"}, "contacts.estimator.*no such force estimator.*tikonov.*Did you mean tikhonov"),
    ({"estimator": 3}, "contacts.estimator"),
    ({"threshold": 0.0}, "contacts.threshold.*0.0.*Choose 1 to 1e\\+06 Pa"),
    ({"threshold": float("nan")}, "contacts.threshold"),
    ({"threshold": float("inf")}, "contacts.threshold"),
    ({"threshold": True}, "contacts.threshold"),
    ({"threshold": "high"}, "contacts.threshold.*high"),
    ({"wrench_noise": -1.0}, "contacts.wrench_noise.*Choose 0 to 10 N"),
    ({"threshold_pa": 1e3}, "contacts.threshold_pa.*no such setting.*Did you mean threshold"),
])  # fmt: skip
def test_a_mistake_is_named(values, words):
    with pytest.raises(SceneError, match=words):
        reading_from(values)


def test_whole_numbers_are_numbers():
    assert ReadingSettings(threshold=2000) == ReadingSettings(threshold=2000.0)
    assert isinstance(ReadingSettings(threshold=2000).threshold, float)
