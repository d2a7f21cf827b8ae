"""Estimators by name, and the regions that they give forces to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.detection.error_budget import combine_parts
from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS, EstimateRefusal, Wrench
from tactile_maps.contacts.force_estimation.estimation import RegionForceEstimator, build_estimator
from tactile_maps.core.arrays import readonly
from tactile_maps.maps.build import build_map
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.sensors.sensor_effects import GainSpread, Hysteresis, Noise, SensorEffects
from tests.contacts.force_estimation.readings_by_hand import PLACE, SKIN, UP, reading
from tests.support.touch import bar_map, bar_skin


@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_estimator_recovers_the_force(name):
    given = reading(depth=0.003, wrench=Wrench(-10.0 * UP, np.cross(PLACE, -10.0 * UP)))
    found = build_estimator(name, SKIN, depth=0.003).estimate(given)
    assert found.force == pytest.approx(10.0, rel=0.1)
    assert found.refused is None
    assert np.linalg.norm(SKIN.position(found.at) - PLACE) < 0.004


FOREARM_SKIN = bar_skin(400)
MAP = bar_map(400)
DEPTH = 0.5 * float(np.sqrt(np.median(FOREARM_SKIN.areas)))
UPWARDS = np.array([0.0, 0.0, 1.0])
EXACT = SensorUncertainty()


def ball(x: float, force: float = 10.0) -> Load:
    return sphere_load("bar", np.array([x, 0.005, 0.02]), UPWARDS, force, 0.02)


def felt(*loads: Load, below: bool = False) -> np.ndarray:
    layer = ElasticLayer(depth=DEPTH)
    model = HalfSpaceModel(FOREARM_SKIN, layer=layer) if below else WaterFillModel(FOREARM_SKIN, layer=layer)
    return model.pressures(list(loads))


def wrench_of(*loads: Load) -> dict[str, np.ndarray]:
    forces = [-load.force * load.normal for load in loads]
    torques = [np.cross(load.point, force) for load, force in zip(loads, forces, strict=True)]
    return {"bar": np.concatenate([sum(forces), sum(torques)])}


def test_area_sum_leaves_regions_unchanged():
    pressures = felt(ball(0.2))
    regions = ContactDetector(MAP).read(pressures)
    got, estimates = RegionForceEstimator(MAP).read(regions, pressures, EXACT)
    assert got is regions
    assert estimates == {}


@pytest.mark.parametrize("name", ["area-sum", "local-nnls", "tikhonov"])
def test_ring_taxels_between_two_contacts_count_once(name):
    pressures = felt(ball(0.19), ball(0.215), below=True)
    regions = ContactDetector(MAP, threshold=0.4 * pressures.max()).read(pressures)
    assert len(np.intersect1d(*[region.taxels for region in regions])) > 2
    assert sum(pressures[region.taxels] @ FOREARM_SKIN.areas[region.taxels] for region in regions) > 21.0
    got, _ = RegionForceEstimator(MAP, estimator=name, depth=DEPTH).read(regions, pressures, EXACT)
    assert sum(region.force for region in got) == pytest.approx(20.0, rel=0.02)


@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_region_carries_the_estimated_force_and_its_error(name):
    pressures = felt(ball(0.2), below=True)
    errors = SensorUncertainty(noise=300.0, gain=0.05)
    regions = ContactDetector(MAP, errors=errors).read(pressures)
    (got,), estimates = RegionForceEstimator(MAP, estimator=name, depth=DEPTH).read(regions, pressures, errors)
    (before,), reported = regions, estimates[got.id]
    assert (got.force, got.force_error) == (reported.force, reported.force_error)
    assert got.force != before.force
    assert got.force == pytest.approx(10.0, rel=0.1)
    assert reported.force_error > 0
    assert (got.at, got.place_error) == (before.at, before.place_error), "the place stays the region's own"
    assert reported.forces.sum() == pytest.approx(reported.force)
    assert reported.peak > before.peak, "the blur is undone"
    assert 0 < reported.mean < reported.peak


@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_uncertainty_of_an_estimate_combines_sensor_and_estimator_parts(name):
    sensor = SensorEffects(noise=Noise(300.0), gain_spread=GainSpread(0.05), hysteresis=Hysteresis())
    pressures = felt(ball(0.2), below=True)
    errors = SensorUncertainty.of_sensor(sensor)
    regions = ContactDetector(MAP, errors=errors).read(pressures)
    (got,), estimates = RegionForceEstimator(MAP, estimator=name, depth=DEPTH).read(regions, pressures, errors)
    parts = got.force_parts
    before = regions[0].force_parts
    assert parts["hysteresis"] == before["hysteresis"] > 0
    assert got.force_limits["hysteresis"] == regions[0].force_limits["hysteresis"] > 2.2 * parts["hysteresis"]
    assert got.force_limits["estimator"] == parts["estimator"]
    assert parts["estimator"] == pytest.approx(abs(got.force - regions[0].force))
    assert parts["noise"] / parts["gain_spread"] == pytest.approx(before["noise"] / before["gain_spread"])
    assert parts["noise"] > before["noise"], "undoing the blur amplifies noise"
    assert got.force_error == pytest.approx(combine_parts(parts))
    assert got.force_error == estimates[got.id].force_error


def test_force_torque_sensor_has_no_uncertainty_from_the_skin():
    errors = SensorUncertainty.of_sensor(SensorEffects(hysteresis=Hysteresis()))
    pressures = felt(ball(0.2))
    load = ball(0.2)
    regions = ContactDetector(MAP, errors=errors).read(pressures)
    estimator = RegionForceEstimator(MAP, estimator="lumped", wrench_noise=0.2)
    (got,), _ = estimator.read(regions, pressures, errors, wrench_of(load))
    assert (got.force_error, got.force_parts) == (0.2, {"wrench": 0.2})
    assert got.force_interval == pytest.approx((got.force - 0.4, got.force + 0.4))


def test_held_sample_is_estimated_once():
    pressures = readonly(felt(ball(0.2), below=True))
    estimator = RegionForceEstimator(MAP, estimator="tikhonov", depth=DEPTH)
    regions = ContactDetector(MAP).read(pressures)
    first = estimator.read(regions, pressures, EXACT)
    assert estimator.read(regions, pressures, EXACT) is first
    noisy = estimator.read(regions, pressures, SensorUncertainty(noise=50.0))
    assert noisy[0][0].force_error > first[0][0].force_error, "another sensor's errors"
    estimator.estimator = "local-nnls"
    other = estimator.read(regions, pressures, EXACT)
    assert other[1][regions[0].id].peak != first[1][regions[0].id].peak, "another method"
    estimator.estimator = "lumped"
    wrenches = [wrench_of(ball(0.2, force)) for force in (8.0, 9.0)]
    forces = [estimator.read(regions, pressures, EXACT, wrench)[0][0].force for wrench in wrenches]
    assert forces == pytest.approx([8.0, 9.0]), "a force-torque sensor holds nothing"


@pytest.mark.long
def test_region_keeps_the_area_sum_if_an_estimator_fails():
    deep = 4 * DEPTH
    pressures = HalfSpaceModel(FOREARM_SKIN, layer=ElasticLayer(depth=deep)).pressures([ball(0.2)])
    noise = 0.1 * float(pressures.max())
    pressures = pressures + np.random.default_rng(0).normal(0, noise, len(pressures))
    regions = ContactDetector(MAP, threshold=3 * noise).read(pressures)
    got, estimates = RegionForceEstimator(MAP, estimator="tikhonov", depth=deep).read(
        regions, pressures, SensorUncertainty(noise)
    )
    assert estimates[regions[0].id].refused is EstimateRefusal.RANK
    assert got[0].force == regions[0].force
    assert len(estimates[regions[0].id].forces) == 0


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
@pytest.mark.parametrize("broken", [np.nan, np.inf])
def test_invalid_reading_counts_as_unpressed(name, broken):
    pressures = felt(ball(0.2), below=True)
    taxel = int(ContactDetector(MAP).read(pressures)[0].taxels[3])
    forces = RegionForceEstimator(MAP, estimator=name, depth=DEPTH)
    got = []
    for value in (broken, 0.0):
        pressures[taxel] = value
        regions = ContactDetector(MAP).read(pressures)
        assert taxel in regions[0].taxels
        got.append(forces.read(regions, pressures, EXACT)[0][0].force)
    assert got[0] == got[1] > 0


def test_pull_is_not_a_contact_force():
    pressures = felt(ball(0.2))
    (region,) = ContactDetector(MAP).read(pressures)
    pressures = np.full_like(pressures, -1.0)
    (got,), estimates = RegionForceEstimator(MAP, estimator="tikhonov", depth=DEPTH).read((region,), pressures, EXACT)
    assert estimates[region.id].refused is EstimateRefusal.PULL
    assert got.force == region.force > 0


def test_link_sensor_measures_a_single_contact_exactly():
    pressures = felt(ball(0.2))
    regions = ContactDetector(MAP).read(pressures)
    (got,), _ = RegionForceEstimator(MAP, estimator="lumped").read(regions, pressures, EXACT, wrench_of(ball(0.2)))
    assert got.force == pytest.approx(10.0)
    assert got.link_position == pytest.approx((0.2, 0.005, 0.02), abs=1e-9)
    assert got.map_point == pytest.approx(MAP.to_map(got.at))
    assert FOREARM_SKIN.position(got.at) == pytest.approx(got.link_position)
    assert got.link_normal == pytest.approx(UPWARDS)
    assert not got.link_axes.any()
    assert (got.force_error, got.place_error) == (0.0, 0.0)


def test_link_sensor_measures_two_contacts_as_one_between_them():
    loads = ball(0.1), ball(0.3, 5.0)
    pressures = felt(*loads)
    regions = ContactDetector(MAP).read(pressures)
    assert len(regions) == 2
    (got,), estimates = RegionForceEstimator(MAP, estimator="lumped").read(regions, pressures, EXACT, wrench_of(*loads))
    assert got.force == pytest.approx(15.0)
    assert got.link_position[0] == pytest.approx((10 * 0.1 + 5 * 0.3) / 15)
    assert estimates.keys() == {got.id}


def test_lumped_contact_keeps_its_id_while_regions_change():
    detector = ContactDetector(MAP)
    forces = RegionForceEstimator(MAP, estimator="lumped")
    names = []
    for loads in [(ball(0.1),), (ball(0.1), ball(0.3)), (ball(0.3),)]:
        pressures = felt(*loads)
        (got,), _ = forces.read(detector.read(pressures), pressures, EXACT, wrench_of(*loads))
        names.append(got.id)
    assert names == [1, 1, 1]
    assert [region.id for region in detector.read(felt(ball(0.3)))] == [2], "to the skin it is another"
    assert forces.read((), felt(), EXACT) == ((), {})
    pressures = felt(ball(0.3))
    (got,), _ = forces.read(detector.read(pressures), pressures, EXACT, wrench_of(ball(0.3)))
    assert got.id == 2, "once let go, it is another"


def test_lumped_contact_is_kept_while_a_lost_contact_of_its_link_is_kept():
    forces = RegionForceEstimator(MAP, estimator="lumped")
    pressures = felt(ball(0.2))
    regions = tuple(replace(region, id=5) for region in ContactDetector(MAP).read(pressures))
    forces.read(regions, pressures, EXACT, wrench_of(ball(0.2)))
    forces.read((), felt(), EXACT, awaited={9: "bar"})
    assert set(forces.awaited) == {5}
    back = tuple(replace(region, id=9) for region in regions)
    (got,), _ = forces.read(back, pressures, EXACT, wrench_of(ball(0.2)))
    assert got.id == 5
    assert set(forces.awaited) == set()
    forces.read((), felt(), EXACT, awaited={9: "elsewhere"})
    assert set(forces.awaited) == set()


def test_wrench_line_that_misses_the_skin_keeps_the_strongest_contact():
    pressures = felt(ball(0.2), ball(0.1, 5.0))
    regions = ContactDetector(MAP).read(pressures)
    twist = {"bar": np.array([0, 0, -10.0, 5.0, 5.0, 0])}
    (got,), estimates = RegionForceEstimator(MAP, estimator="lumped").read(regions, pressures, EXACT, twist)
    assert estimates[got.id].refused is EstimateRefusal.OFF_SKIN
    assert (got.force, got.at) == (regions[0].force, regions[0].at), "the strongest contact's"


@pytest.mark.long
def test_error_bars_match_the_noise_of_the_sensor():
    pressures = felt(ball(0.2))
    noise = 0.05
    regions = ContactDetector(MAP).read(pressures)
    forces = RegionForceEstimator(MAP, estimator="lumped", wrench_noise=noise, seed=3)
    runs = [forces.read(regions, pressures, EXACT, wrench_of(ball(0.2)))[0][0] for _ in range(300)]
    off = np.array([run.link_position - (0.2, 0.005, 0.02) for run in runs])
    assert np.std([run.force for run in runs]) == pytest.approx(noise, rel=0.15)
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) == pytest.approx(runs[0].place_error, rel=0.15)
    forces.reset()
    (again,), _ = forces.read(regions, pressures, EXACT, wrench_of(ball(0.2)))
    assert again.force == runs[0].force, "a reset starts the noise again"


def test_equations_are_rebuilt_for_another_skin():
    moved = build_map(bar_skin(200, finer=2))
    assert len(moved.skin.patches[0].surface.faces) > len(FOREARM_SKIN.patches[0].surface.faces)
    pressures = felt(ball(0.2))
    forces = RegionForceEstimator(MAP, estimator="lumped")
    forces.use(moved)
    regions = ContactDetector(moved).read(WaterFillModel(moved.skin).pressures([ball(0.2)]))
    (got,), _ = forces.read(regions, pressures, EXACT, wrench_of(ball(0.2)))
    assert moved.skin.position(got.at) == pytest.approx((0.2, 0.005, 0.02), abs=1e-9)
