"""Contacts side by side on a tared skin: when they are separated, and when they are one contact."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.close_contacts import CloseContactSeparator
from tactile_maps.contacts.detection.regions import TaxelGraph, TaxelGroup
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings
from tactile_maps.core.errors import SceneError
from tactile_maps.maps.build import build_map
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects
from tests.support.touch import bar, bar_skin

SKIN = bar_skin(400, finer=3)
MAP = build_map(SKIN)
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


def test_gains_that_differ_by_a_fifth_do_not_divide_a_fingertip():
    found = []
    for seed in range(40):
        gains = np.random.default_rng(seed).uniform(0.8, 1.2, len(SKIN))
        found.append(len(read(tared(), gains * pressed(0.0, radius=2.5 * PITCH, seed=seed))))
    assert found == [1] * 40


def test_skin_without_tare_reads_connected_contacts_as_one():
    sense = ContactPipeline(bar(), MAP, SensorEffects())
    assert len(read(sense, pressed(-1.25, 1.25))) == 1


def test_ids_are_kept_where_contacts_join_and_part():
    sense = tared()
    apart = {region.id for region in read(sense, pressed(-1.25, 1.25))}
    read(sense, pressed(-0.4, 0.4), tick=2)
    assert {region.id for region in read(sense, pressed(-1.25, 1.25), tick=3)} == apart


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


def test_what_creep_leaves_of_a_touch_is_no_contact_but_a_new_touch_is():
    sense = tared()
    assert read(sense, pressed(0.0))
    left = pressed(0.0, peak=1.2e3)
    assert not read(sense, left, tick=2)
    assert read(tared(), left), "the same readings without an earlier touch"
    assert read(sense, pressed(0.0, peak=5e3), tick=3)
    read(sense, pressed(peak=0.0), tick=4)
    assert read(sense, left, tick=5), "the skin was at rest in between"


def test_unknown_treatment_is_refused():
    with pytest.raises(SceneError, match="unknown treatment of close contacts"):
        ReadingSettings(close_contacts="merged")
