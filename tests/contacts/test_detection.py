"""Contact regions: what is found, where it is put, and that it is the same one as before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD, ContactDetector
from tactile_maps.contacts.detection.regions import TaxelGraph
from tactile_maps.core.arrays import readonly
from tactile_maps.core.errors import MapError
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import (
    Crosstalk,
    Hysteresis,
    OffsetDrift,
    Sampling,
    SensorEffects,
    crosstalk_matrix,
)
from tests.support.touch import arm, prepared_bar

BAR = prepared_bar()
MAP = BAR.map
SKIN = BAR.map.skin
POSITIONS = SKIN.patches[0].taxels.positions


def around(point, *, kilopascals=10.0, radius=0.03):
    """A round touch on the bar."""
    away = np.linalg.norm(POSITIONS - np.asarray(point), axis=1)
    return 1e3 * kilopascals * np.clip(1 - (away / radius) ** 2, 0, None)


def test_touch_gives_one_region_with_its_force_and_position():
    pressures = around((0.2, 0, 0.02))
    (region,) = ContactDetector(MAP).read(pressures)
    assert region.force == pytest.approx(pressures @ SKIN.areas, rel=1e-12), "the ring brings what is below threshold"
    assert region.peak == pressures.max()
    assert region.link == "bar"
    assert not region.torn
    mean = pressures * SKIN.areas @ POSITIONS / (pressures @ SKIN.areas)
    assert region.link_position == pytest.approx(mean, abs=5e-4), (
        "flat skin: the mean on the map is the mean on the body"
    )
    assert region.link_normal == pytest.approx([0, 0, 1])
    assert MAP.to_map(region.at) == pytest.approx(region.map_point, abs=1e-12)
    touched = pressures >= TOUCH_THRESHOLD
    assert region.area == pytest.approx(SKIN.areas[touched].sum())
    assert set(np.flatnonzero(touched)) < set(region.taxels)


def test_force_that_crosstalk_passes_beyond_the_ring_is_added():
    true = around((0.2, 0, 0.02), kilopascals=2.0)
    exact = ContactDetector(MAP).read(true)[0]
    detector = ContactDetector(MAP)
    noisy = SensorUncertainty(noise=100.0)
    for share in (0.05, 0.3):
        pressures = crosstalk_matrix(SKIN, share) @ true
        (plain,) = ContactDetector(MAP, errors=noisy).read(pressures)
        lost = 1 - plain.force / exact.force
        assert lost > 0.05 * share, "the ring bears force of its own, which it passes on"
        corrected = SensorUncertainty.of_sensor(SensorEffects(crosstalk=Crosstalk(share)))
        for errors in (replace(corrected, noise=noisy.noise), corrected):
            detector.errors = errors
            (region,) = detector.read(pressures)
            assert abs(region.force / exact.force - 1) < (1e-9 if share < 0.1 else 1e-3 * lost)
        assert region.force_error == pytest.approx(exact.force_error, abs=1e-12)


def plate(kilopascals):
    """A flat object on top of the bar, whose pressure rises from a tenth to all of ``kilopascals``."""
    x, y, z = POSITIONS.T
    under = (np.abs(x - 0.2) < 0.06) & (np.abs(y) < 0.02) & (z > 0)
    return np.where(under, 1e3 * kilopascals * (0.1 + 0.9 * (x - 0.14) / 0.12), 0.0)


@pytest.mark.parametrize("kilopascals", [1.2, 2.0, 5.0])
def test_force_of_a_flat_object_includes_its_taxels_below_the_threshold(kilopascals):
    pressures = plate(kilopascals)
    (region,) = ContactDetector(MAP, errors=SensorUncertainty()).read(pressures)
    assert region.force == pytest.approx(pressures @ SKIN.areas, rel=1e-12)
    low, high = region.force_interval
    assert low <= pressures @ SKIN.areas * (1 + 1e-12)
    assert high < 1.1 * region.force


@pytest.mark.parametrize(
    "errors",
    [
        ContactDetector(MAP).errors,
        SensorUncertainty.of_sensor(SensorEffects(hysteresis=Hysteresis())),
        SensorUncertainty.of_sensor(SensorEffects(offset_drift=OffsetDrift(sd=10.0, walk=1.0))),
    ],
    ids=["noise not stated", "hysteresis", "drift"],
)
def test_force_of_a_flat_object_is_within_its_interval_with_any_sensor(errors):
    detector = ContactDetector(MAP, errors=errors)
    pressures = plate(1.2)
    true = pressures @ SKIN.areas
    for seed in range(10):
        noise = np.random.default_rng(seed).normal(0, 0.0 if errors.effects.hysteresis else 10.0, len(SKIN))
        (region,) = detector.read(pressures + noise)
        low, high = region.force_interval
        assert region.force == pytest.approx(true, rel=0.03)
        assert high - low < 0.3 * true
        assert low <= true <= high or seed > 8


def test_creep_of_a_contact_that_moved_is_not_added():
    """A taxel that was pressed reads up to the delayed share of it for some time constants."""
    sensor = SensorEffects(hysteresis=Hysteresis(share=0.02))
    chain = SensorChain(SKIN, sensor, tick=0.01, seed=0)
    detector = ContactDetector(MAP, errors=SensorUncertainty.of_sensor(sensor))
    here = around((0.2, 0, 0.02), kilopascals=20.0)
    there = around((0.13, 0, 0.02), kilopascals=20.0, radius=0.06)
    for step in range(200):
        detector.read(chain.read(there), time=0.01 * step)
    readings = chain.read(here)
    (region,) = detector.read(readings, time=2.0)
    (alone,) = ContactDetector(MAP, errors=SensorUncertainty(noise=300.0)).read(readings)
    assert (readings[np.setdiff1d(np.flatnonzero(there), region.taxels)] > 10.0).any(), "some of it creeps"
    assert np.array_equal(region.taxels, alone.taxels)


def test_offset_of_noise_that_is_not_stated_is_part_of_the_interval():
    pressures = around((0.2, 0, 0.02), kilopascals=20.0)
    noise = np.random.default_rng(1).normal(0, 30.0, len(SKIN))
    (exact,) = ContactDetector(MAP).read(pressures)
    (region,) = ContactDetector(MAP).read(pressures + noise + 150.0)
    assert np.array_equal(region.taxels, exact.taxels)
    excess = region.force - exact.force
    assert region.force_parts["offset_drift"] == pytest.approx(excess, rel=0.2)
    assert region.force_interval[0] <= exact.force
    assert region.force_parts["noise"] == pytest.approx(30.0 * np.linalg.norm(SKIN.areas[region.taxels]), rel=0.3)


def test_readings_that_noise_explains_are_not_added_to_a_contact():
    noisy = ContactDetector(MAP, errors=SensorUncertainty(noise=100.0))
    (region,) = noisy.read(around((0.2, 0, 0.02), kilopascals=20.0) + 90.0)
    (exact,) = ContactDetector(MAP, errors=SensorUncertainty()).read(around((0.2, 0, 0.02), kilopascals=20.0))
    assert np.array_equal(region.taxels, exact.taxels)


def test_ring_taxels_of_two_contacts_are_shared_and_count_once():
    pressures = np.where(np.linalg.norm(POSITIONS - (0.2, 0, 0.02), axis=1) < 0.05, 0.9 * TOUCH_THRESHOLD, 0.0)
    middle = int(np.argmin(np.linalg.norm(POSITIONS - (0.2, 0, 0.02), axis=1)))
    graph = TaxelGraph(SKIN)
    near = graph.near[middle]
    first = min(near)
    second = max(near, key=lambda one: float(np.linalg.norm(POSITIONS[one] - POSITIONS[first])))
    pressures[[first, second]] = 2 * TOUCH_THRESHOLD
    found = ContactDetector(MAP, errors=SensorUncertainty()).read(pressures)
    assert len(found) == 2
    assert middle in np.intersect1d(*[region.taxels for region in found])
    assert sum(region.force for region in found) == pytest.approx(pressures @ SKIN.areas, rel=1e-12)
    for region in found:
        own = pressures[region.taxels] @ SKIN.areas[region.taxels]
        assert region.force <= own - 0.4 * pressures[middle] * SKIN.areas[middle], "each has its part"


def test_taxels_between_two_contacts_belong_to_the_nearer_one():
    pressures = np.zeros(len(SKIN))
    first, last = (int(np.argmin(np.linalg.norm(POSITIONS - (x, 0, 0.02), axis=1))) for x in (0.1, 0.3))
    x, y, z = POSITIONS.T
    pressures[(np.abs(y) < 0.02) & (x > 0.1) & (x < 0.3) & (z > 0)] = 200.0
    pressures[[first, last]] = 3 * TOUCH_THRESHOLD
    regions = ContactDetector(MAP, errors=SensorUncertainty()).read(pressures)
    assert len(regions) == 2
    assert sum(region.force for region in regions) == pytest.approx(pressures @ SKIN.areas, rel=1e-12)
    for region in regions:
        assert np.ptp(POSITIONS[region.taxels, 0]) < 0.15


def test_taxel_stays_touched_down_to_half_the_threshold():
    tracked = ContactDetector(MAP)
    pressures = np.zeros(len(SKIN))
    for level, found in ((0.9, 0), (1.0, 1), (0.6, 1), (0.49, 0), (0.6, 0)):
        pressures[7] = level * TOUCH_THRESHOLD
        assert len(tracked.read(pressures)) == found, level


def test_area_mean_and_peak_cover_the_touched_taxels():
    """A ring taxel may read more than a touched one, which stays touched down to half of the threshold."""
    tracked = ContactDetector(MAP)
    pressures = np.zeros(len(SKIN))
    middle = int(np.argmin(np.linalg.norm(POSITIONS - (0.2, 0, 0.02), axis=1)))
    ring = sorted(SKIN.neighbours[(SKIN.neighbours == middle).any(axis=1)].ravel())
    pressures[middle] = 2 * TOUCH_THRESHOLD
    tracked.read(pressures)
    pressures[ring] = 0.9 * TOUCH_THRESHOLD
    pressures[middle] = 0.6 * TOUCH_THRESHOLD
    (region,) = tracked.read(pressures)
    assert len(region.taxels) > region.touched == 1
    assert region.area == SKIN.areas[middle]
    assert region.peak == pytest.approx(0.6 * TOUCH_THRESHOLD)
    assert region.mean == pytest.approx(0.6 * TOUCH_THRESHOLD)


def test_held_sample_is_processed_once_with_the_same_result():
    held_by = ContactDetector(MAP)
    fresh_detector = ContactDetector(MAP)
    apart = around((0.08, 0, 0.02)) + around((0.2, 0, 0.02))
    for detector in (held_by, fresh_detector):
        detector.read(apart)
    sample = readonly(np.maximum(apart, 5e3))  # which merges the two
    reported = [(held_by.read(sample), fresh_detector.read(sample.copy())) for _ in range(4)]
    for (held,), (fresh,) in reported:
        assert (held.id, held.force, held.merged) == (fresh.id, fresh.force, fresh.merged)
        assert (held.map_point == fresh.map_point).all()
    assert [bool(held[0].merged) for held, _ in reported] == [True, False, False, False]
    assert reported[3][0] is reported[2][0] is reported[1][0]
    held_by.errors = SensorUncertainty(noise=100.0)
    assert held_by.read(sample)[0].force_error > 0, "another sensor's errors"
    held_by.use(MAP)
    assert held_by.read(sample) is not reported[3][0], "another map's places"


def test_region_has_axes_mean_pressure_and_error_bars():
    (region,) = ContactDetector(MAP, errors=SensorUncertainty(noise=100.0)).read(around((0.2, 0, 0.02), radius=0.06))
    touched = around((0.2, 0, 0.02), radius=0.06) >= TOUCH_THRESHOLD
    assert region.mean == pytest.approx(
        around((0.2, 0, 0.02), radius=0.06)[touched] @ SKIN.areas[touched] / SKIN.areas[touched].sum()
    )
    assert region.mean < region.peak
    assert region.link_axes @ region.link_normal == pytest.approx([0, 0], abs=1e-12)
    assert 0.02 < np.linalg.norm(region.link_axes[1]) <= np.linalg.norm(region.link_axes[0]) < 0.06
    lengths = np.linalg.norm(region.map_axes, axis=1)
    assert lengths == pytest.approx(np.linalg.norm(region.link_axes, axis=1), rel=1e-6), "flat skin is mapped truly"
    assert region.place_error > ContactDetector(MAP).read(around((0.2, 0, 0.02), radius=0.06))[0].place_error > 0
    assert region.force_parts["noise"] == pytest.approx(100.0 * np.linalg.norm(SKIN.areas[region.taxels]))


def test_uncertainty_grows_with_the_time_that_offsets_have_drifted():
    drift = SensorUncertainty.of_sensor(SensorEffects(offset_drift=OffsetDrift(0.0, 10.0)))
    detector = ContactDetector(MAP, errors=drift)
    pressures = around((0.2, 0, 0.02))

    def drifted(time: float) -> float:
        (region,) = detector.read(pressures, time=time)
        return region.force_parts["offset_drift"] / np.linalg.norm(SKIN.areas[region.taxels])

    assert [drifted(time) for time in (5.0, 9.0, 30.0)] == pytest.approx([0.0, 20.0, 50.0]), "since the first reading"
    detector.errors = replace(drift, noise=50.0)
    assert drifted(41.0) == pytest.approx(60.0), "the same offsets drift on"
    assert detector.errors_now.elapsed == 36.0
    detector.errors = SensorUncertainty.of_sensor(SensorEffects(offset_drift=OffsetDrift(3.0, 10.0)))
    assert drifted(50.0) == pytest.approx(3.0), "other offsets"
    detector.reset()
    assert drifted(60.0) == pytest.approx(3.0)


def test_uncertainty_of_a_changing_force_grows_with_the_age_of_the_sample():
    errors = SensorUncertainty.of_sensor(SensorEffects(sampling=Sampling(10.0, 0.1)))
    detector = ContactDetector(MAP, errors=errors)
    exact = ContactDetector(MAP)
    pressures = around((0.2, 0, 0.02))
    for step in range(30):
        sample = readonly((1 + 0.01 * step) * pressures)
        for tick in range(4):  # it is held for some ticks
            (region,) = detector.read(sample, time=0.1 * step + 0.025 * tick)
    (still,) = exact.read(pressures)
    assert region.force_parts["sampling"] == pytest.approx(0.1 * still.force * errors.lag, rel=1e-6)
    detector.read(0 * pressures, time=3.0)
    (again,) = detector.read(pressures, time=3.1)
    assert again.force_parts["sampling"] == pytest.approx(still.force), "it began since the last sample"


@pytest.mark.parametrize("reading", [float("nan"), float("inf"), -float("inf")])
def test_invalid_reading_counts_as_unpressed(reading):
    pressures = around((0.2, 0, 0.02))
    broken = pressures.copy()
    taxel = int(pressures.argmax())
    broken[taxel] = reading
    pressures[taxel] = 0.0
    broken[3] = reading
    found = ContactDetector(MAP).read(broken)
    expected = ContactDetector(MAP).read(pressures)
    assert [region.force for region in found] == [region.force for region in expected]
    assert np.isfinite([region.place_error for region in found]).all()


def test_ring_with_negative_noise_is_excluded():
    pressures = np.zeros(len(SKIN))
    pressures[30] = TOUCH_THRESHOLD
    (alone,) = ContactDetector(MAP).read(pressures)
    pressures[[taxel for taxel in alone.taxels if taxel != 30]] = -0.5 * TOUCH_THRESHOLD
    (region,) = ContactDetector(MAP).read(pressures)
    assert region.force == alone.force
    assert region.link_position == pytest.approx(alone.link_position)


@pytest.mark.long
def test_region_under_strong_noise_has_axes():
    """Large ring taxels that read below zero outweigh the touched one's area."""
    chance = np.random.default_rng(3)
    sizes = []
    detector = ContactDetector(MAP)
    for _ in range(400):
        pressures = chance.normal(0.0, 800.0, len(SKIN))
        pressures[chance.integers(len(SKIN))] = 2.0 * TOUCH_THRESHOLD
        sizes += [np.linalg.norm(region.link_axes, axis=1) for region in detector.read(pressures)]
    assert len(sizes) > 1000
    assert np.min(sizes) > 1e-3, "half a taxel and more"


def test_edited_map_moves_a_contact_without_changing_its_id():
    tracked = ContactDetector(MAP)
    pressures = around((0.2, 0, 0.02))
    (before,) = tracked.read(pressures)
    moved = replace(MAP, layout=MapLayout(tuple(replace(p, offset=(1.0, 2.0)) for p in MAP.layout.placements)))
    tracked.use(moved)
    (after,) = tracked.read(pressures)
    assert after.id == before.id
    assert after.link_position == pytest.approx(before.link_position, abs=1e-9)
    assert np.linalg.norm(after.map_point - before.map_point) > 0.5


def test_touch_across_a_seam_is_one_region_located_on_the_body():
    prepared = arm()
    tracked = ContactDetector(prepared.map)
    assert len(tracked._seams.pairs), "the arm's tubes are cut somewhere"
    skin = prepared.skin
    torn = 0
    body = np.concatenate([patch.taxels.positions for patch in skin.patches])
    for one, other in tracked._seams.pairs:
        pressures = np.zeros(len(skin))
        pressures[[one, other]] = 5e3
        tracked.reset()
        (region,) = tracked.read(pressures)
        middle = body[[one, other]].T @ skin.areas[[one, other]] / skin.areas[[one, other]].sum()
        torn += region.torn
        assert np.linalg.norm(region.link_position - middle) < 0.6 * np.linalg.norm(body[one] - body[other])
        assert region.force == pytest.approx(5e3 * skin.areas[[one, other]].sum(), rel=1e-12)
    assert torn == len(tracked._seams.pairs)


def test_scaling_a_patch_does_not_change_its_seam_pairs():
    map_ = arm().map
    large = MapLayout(tuple(replace(place, scale=4.0) for place in map_.layout.placements))
    np.testing.assert_array_equal(
        ContactDetector(replace(map_, layout=large))._seams.pairs, ContactDetector(map_)._seams.pairs
    )


def test_finger_anywhere_on_the_arm_is_located_correctly():
    prepared = arm()
    skin = prepared.skin
    felt = WaterFillModel(prepared.skin)
    missed = []
    tracked = ContactDetector(prepared.map)
    for taxel in range(0, len(skin), 5):
        at = skin.taxel_point(taxel)
        load = sphere_load(skin.link(at), skin.position(at), skin.normal(at), 5.0, 0.008)
        tracked.reset()
        (region,) = tracked.read(felt.pressures([load]))
        assert region.force == pytest.approx(5.0, rel=1e-6)
        assert region.at.patch == at.patch
        missed.append(np.linalg.norm(region.link_position - load.point))
    pitch = np.sqrt(np.median(skin.areas))
    assert np.median(missed) < 0.3 * pitch
    assert max(missed) < pitch


@pytest.mark.parametrize("threshold", [0.0, -1.0, float("nan"), float("inf")])
def test_invalid_threshold_is_rejected(threshold):
    with pytest.raises(MapError, match="threshold"):
        ContactDetector(MAP, threshold=threshold)
