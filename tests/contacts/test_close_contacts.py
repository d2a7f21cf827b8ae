"""Contacts side by side on a tared skin: when they are separated, and when they are one contact."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.close_contacts import CloseContactSeparator
from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.detection.regions import TaxelGraph, TaxelGroup
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings
from tactile_maps.core.errors import SceneError
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import (
    Crosstalk,
    GainSpread,
    Noise,
    Quantisation,
    SensorEffects,
    Threshold,
)
from tests.support.touch import bar, bar_map

MAP = bar_map(400, finer=3)
SKIN = MAP.skin
POSITIONS = SKIN.patches[0].taxels.positions
PITCH = float(np.median(np.linalg.norm(POSITIONS[SKIN.neighbours[:, 0]] - POSITIONS[SKIN.neighbours[:, 1]], axis=1)))
CENTRE = np.array([0.2, 0.0, 0.02])
NOISE = 50.0
"""Standard deviation of a reading [Pa]."""
TIP = 1.5 * PITCH
"""Radius of a fingertip [m]."""


def tared(**settings):
    """Pipeline of a skin whose noise was measured."""
    sense = ContactPipeline(bar(), MAP, SensorEffects(), settings=ReadingSettings(**settings))
    sense.set_measured_noise(TaxelNoise(np.full(len(SKIN), NOISE), np.full(len(SKIN), 49.0)))
    return sense


def pressed(*along, peak=20e3, radius=TIP, seed=0):
    """Readings (taxels,) of fingertips at these distances along the bar from its centre, in pitches."""
    found = NOISE * np.random.default_rng(seed).standard_normal(len(SKIN))
    for distance in along:
        away = np.linalg.norm(POSITIONS - CENTRE - [distance * PITCH, 0, 0], axis=1)
        found += peak * np.clip(1 - (away / radius) ** 2, 0, None)
    return found


def read(sense, readings, tick=1):
    return sense.read(tick, 0.02 * tick, np.zeros(1), readings)


def test_connected_fingertips_are_two_contacts_that_share_the_force():
    touching = pressed(-1.25, 1.25)
    (joined,) = read(tared(close_contacts="joined"), touching)
    both = read(tared(), touching)
    assert len(both) == 2
    assert sum(region.touched for region in both) == joined.touched
    places = sorted(float(region.link_position[0]) for region in both)
    assert places == pytest.approx([0.2 - 1.25 * PITCH, 0.2 + 1.25 * PITCH], abs=0.3 * PITCH)
    assert sum(region.force for region in both) == pytest.approx(joined.force, rel=0.01)


@pytest.mark.parametrize(("half", "radius"), [(0.0, 1.5), (0.4, 1.5), (1.0, 1.5), (1.5, 2.0)])
def test_contacts_without_a_deep_dip_are_one(half, radius):
    assert len(read(tared(), pressed(-half, half, radius=radius * PITCH))) == 1


def test_dip_within_the_noise_does_not_separate():
    noisy = TaxelNoise(np.full(len(SKIN), 3e3), np.full(len(SKIN), 1e9))
    sense = tared(threshold=1000.0)
    assert len(read(sense, pressed(-1.25, 1.25))) == 2
    sense.set_measured_noise(noisy)
    assert len(read(sense, pressed(-1.25, 1.25), tick=2)) == 1


def test_gains_that_differ_by_a_fifth_do_not_split_a_fingertip():
    found = []
    for seed in range(40):
        gains = np.random.default_rng(seed).uniform(0.8, 1.2, len(SKIN))
        found.append(len(read(tared(), gains * pressed(0.0, radius=2.5 * PITCH, seed=seed))))
    assert found == [1] * 40


def test_skin_without_tare_reads_connected_contacts_as_one():
    sense = ContactPipeline(bar(), MAP, SensorEffects())
    assert len(read(sense, pressed(-1.25, 1.25))) == 1


def test_ids_are_kept_when_contacts_merge_and_separate():
    sense = tared()
    apart = {region.id for region in read(sense, pressed(-1.25, 1.25))}
    read(sense, pressed(-0.4, 0.4), tick=2)
    assert {region.id for region in read(sense, pressed(-1.25, 1.25), tick=3)} == apart


LIMIT = 2500.0
"""Threshold of a sensor [Pa]."""


def in_a_row(*readings):
    """Readings (taxels,) of neighbours along the bar [Pa], of which only the next ones are neighbours."""
    graph = TaxelGraph(SKIN)
    line = [int(np.argmin(np.linalg.norm(POSITIONS - CENTRE, axis=1)))]
    while len(line) < len(readings):
        line.append(max(graph.near[line[-1]], key=lambda taxel: POSITIONS[taxel, 0]))
    found = np.zeros(len(SKIN))
    found[line] = readings
    return found


def with_sensor_threshold():
    """Detector of a sensor that reads 0 below its threshold."""
    effects = SensorEffects(threshold=Threshold(at=LIMIT), noise=Noise(sd=100.0))
    return ContactDetector(MAP, errors=SensorUncertainty.of_sensor(effects))


def test_contact_whose_middle_falls_below_the_threshold_remains_one():
    detector = with_sensor_threshold()
    (before,) = detector.read(in_a_row(2600, 2700, 2650))
    (held,) = detector.read(in_a_row(2600, 0, 2650))
    assert held.id == before.id
    assert (held.touched, held.split_from) == (2, None)
    (after,) = detector.read(in_a_row(2600, 2700, 2650))
    assert (after.id, after.merged) == (before.id, ())


def test_contacts_separated_by_a_deep_dip_are_two_immediately():
    detector = with_sensor_threshold()
    (before,) = detector.read(in_a_row(6000, 5000, 6500))
    both = detector.read(in_a_row(6000, 0, 6500))
    assert len(both) == 2
    assert {region.split_from for region in both} == {None, before.id}
    detector = ContactDetector(MAP, errors=SensorUncertainty(noise=100.0))
    detector.read(in_a_row(1400, 1200, 1500))
    assert len(detector.read(in_a_row(1400, 499, 1500))) == 2, "below the level at which a taxel is released"
    detector = ContactDetector(MAP, errors=SensorUncertainty(noise=250.0))
    detector.read(in_a_row(1400, 1200, 1500))
    assert len(detector.read(in_a_row(1400, 499, 1500))) == 1, "noise may be as large"


def test_second_touch_near_a_contact_is_detected_immediately():
    detector = with_sensor_threshold()
    detector.read(in_a_row(2600, 0, 0))
    assert len(detector.read(in_a_row(2600, 0, 2600))) == 2


def test_box_with_the_pressure_of_the_threshold_is_one_contact():
    """A box at rest on a skin with all effects of the sensor does not split and merge with the noise."""
    effects = SensorEffects(
        crosstalk=Crosstalk(),
        gain_spread=GainSpread(),
        noise=Noise(),
        threshold=Threshold(),
        quantisation=Quantisation(),
    )
    places = np.abs(POSITIONS - CENTRE)
    pressures = np.where((places[:, 0] < 4.2 * PITCH) & (places[:, 1] < 0.02) & (places[:, 2] < 1e-3), 2750.0, 0.0)
    parted = []
    for seed in range(3):
        chain = SensorChain(SKIN, effects, tick=0.02, seed=seed)
        detector = ContactDetector(MAP, errors=SensorUncertainty.of_sensor(effects))
        for step in range(40):
            regions = detector.read(chain.read(pressures), time=0.02 * step)
            parted += [region.id for region in regions if step and region.split_from is not None]
            parted += [region.id for region in regions if step and region.merged]
        assert len(regions) >= 1
    assert len(parted) <= 3


def test_separated_cores_are_a_partition_and_rings_are_untouched():
    graph = TaxelGraph(SKIN)
    readings = pressed(-3.5, 0.0, 3.5, radius=2 * PITCH)
    (group,) = graph.groups(np.flatnonzero(readings > 1e3).tolist())
    separator = CloseContactSeparator(graph.near)
    noise = separator.smoothed_noise(np.full(len(SKIN), 150.0))
    parts = separator.separated([group], readings, noise)
    assert len(parts) == 3
    assert sorted(taxel for part in parts for taxel in part.core) == sorted(group.core)
    assert frozenset().union(*[part.ring for part in parts]) == group.ring
    small = TaxelGroup(frozenset(sorted(group.core)[:2]), frozenset())
    assert separator.separated([small], readings, noise) == [small]
    assert np.median(noise) == pytest.approx(75.0 * np.sqrt(1 + 1 / 6), rel=0.02)


def test_residual_pressure_of_creep_is_not_a_contact_but_a_new_touch_is():
    sense = tared()
    assert read(sense, pressed(0.0))
    left = pressed(0.0, peak=1.2e3)
    assert not read(sense, left, tick=2)
    assert read(tared(), left), "the same readings without an earlier touch"
    assert read(sense, pressed(0.0, peak=5e3), tick=3)
    read(sense, pressed(peak=0.0), tick=4)
    assert read(sense, left, tick=5), "the skin was at rest in between"


def test_unknown_treatment_of_close_contacts_is_rejected():
    with pytest.raises(SceneError, match="unknown treatment of close contacts"):
        ReadingSettings(close_contacts="merged")
