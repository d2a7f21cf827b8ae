"""Contact regions where the truth is known: followed through motion, gaps, noise, meeting and parting; error bars
against chance; self-touch.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD, ContactDetector
from tactile_maps.contacts.detection.tracking import GAP
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import AreaAveraging, Sampling
from tests.support.touch import bar_map, bar_skin, prepared_bar

SKIN = bar_skin(400)
MAP = bar_map(400)
POSITIONS = SKIN.patches[0].taxels.positions
RADIUS = 0.025


def press(*centres, kilopascals=20.0) -> np.ndarray:
    """Round touches, each of one strength, on the bar's top."""
    total = np.zeros(len(SKIN))
    for x, y in centres:
        away = np.linalg.norm(POSITIONS - [x, y, 0.02], axis=1)
        total += 1e3 * kilopascals * np.clip(1 - (away / RADIUS) ** 2, 0, None)
    return total


@pytest.mark.long
@pytest.mark.rotating
@pytest.mark.parametrize("pace", [0.001, 0.005, 0.02])
@pytest.mark.parametrize("noise", [0.0, 150.0])
def test_moving_contact_is_one_contact_at_the_correct_position(pace, noise):
    """Up to 20 mm from frame to frame, two pitches: 4 m/s at 200 Hz."""
    random = np.random.default_rng(0)
    detector = ContactDetector(MAP)
    missed = []
    for step in range(200):
        x = 0.2 + 0.15 * np.sin(pace / 0.15 * step)
        regions = detector.read(press((x, 0.0)) + random.normal(0, noise, len(SKIN)) * (noise > 0))
        assert [region.id for region in regions] == [1]
        missed.append(np.linalg.norm(regions[0].link_position - [x, 0, 0.02]))
    assert max(missed) < 0.0015, "a seventh of the pitch"


def test_each_touched_taxel_is_in_one_region_and_ids_are_unique():
    """Whatever is pressed: each touched taxel is in one region, and ids are all different."""
    random = np.random.default_rng(0)
    detector = ContactDetector(MAP)
    for _ in range(100):
        count = int(random.integers(0, 5))
        centres = np.column_stack([random.uniform(0.03, 0.37, count), random.uniform(-0.04, 0.04, count)])
        pressures = press(*centres)
        regions = detector.read(pressures)
        assert len({region.id for region in regions}) == len(regions)
        assert list(regions) == sorted(regions, key=lambda region: -region.force)
        touched = np.flatnonzero(pressures >= TOUCH_THRESHOLD)
        held = np.bincount(
            np.concatenate([region.taxels for region in regions] or [[]]).astype(int), minlength=len(SKIN)
        )
        assert (held[touched] >= 1).all()
        total = sum(region.force for region in regions)
        assert total >= 0.97 * float(pressures @ SKIN.areas), "rings bring what is below the threshold"
        detector.reset()


TIP = Finger(radius=0.006, max_force=5.0, speed=1.0)
"""Finger that is narrower than the gaps."""


@cache
def gappy() -> PreparedScene:
    """The bar, fixed, in taxels 11 mm apart; faces of 4 mm, so that several points are in each electrode."""
    skin = bar_skin(300, finer=2)
    bare = prepared_bar(hinged=False)
    return PreparedScene(bare.scene, bare.robot, skin, build_map(skin))


def session_at(rate: float) -> Session:
    """Electrodes of 1.9 mm radius, read ``rate`` times a second."""
    prepared = gappy()
    effects = prepared.scene.effects
    sensor = replace(effects.sensor, area_averaging=AreaAveraging(), sampling=Sampling(rate, 0.0))
    return Session(prepared, effects=replace(effects, fingers=True, sensor=sensor), scripted=False)


def place(x: float, y: float) -> SurfacePoint:
    """Return a point on the top of the bar."""
    faces, weights, _ = ClosestPoint(gappy().skin.patches[0].surface).query(np.array([[x, y, 0.02]]))
    a, b, c = weights[0].tolist()
    return SurfacePoint(0, int(faces[0]), (a, b, c))


def kinds(events, *expected: str) -> list[str]:
    return [event.kind for event in events if event.kind in expected]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [5.0, 20.0, 100.0])
def test_stroke_over_gaps_is_one_contact(rate, seed):
    random = np.random.default_rng(seed)
    session = session_at(rate)
    speed = 0.08
    events = []
    away = gappy().skin.patches[0].taxels.positions
    start = away[np.argmin(np.hypot(away[:, 0] - 0.06, away[:, 1] - random.uniform(-0.03, 0.03)))]
    tick = gappy().scene.tick
    lost = 0
    ids = set()
    session.submit(PokePressed(1, place(*start[:2]), TIP))
    for number in range(60 + round(0.25 / speed / tick)):
        if number > 60:
            session.submit(PokeMoved(1, place(start[0] + speed * tick * (number - 60), start[1])))
        frame = session.tick()
        events += frame.events
        lost += number > 60 and not frame.regions
        ids |= {region.id for region in frame.regions}
    assert lost * tick > 0.1, "it falls between taxels"
    assert kinds(events, "touch", "release") == ["touch"]
    assert len(ids) == 1
    session.submit(PokeReleased(1))
    for _ in range(round((GAP + 2.5 / rate) / tick)):
        events += session.tick().events
    assert kinds(events, "touch", "release", "stroke") == ["touch", "stroke", "stroke", "release"]
    way = next(event.travelled for event in events if event.kind == "stroke" and event.phase == "ended")
    assert 0.15 < way < 0.4, "from taxel to taxel, aside as well"


@pytest.mark.long
@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_repeated_taps_at_one_place_are_counted_correctly(rate):
    session = session_at(rate)
    events = []
    at = gappy().skin.taxel_point(130)
    for _ in range(4):
        session.submit(PokePressed(1, at, TIP))
        for _ in range(30):
            events += session.tick().events
        session.submit(PokeReleased(1))
        for _ in range(30):
            events += session.tick().events
    for _ in range(100):
        events += session.tick().events
    assert kinds(events, "tap") == ["tap"] * 4
    assert kinds(events, "touch", "release") == ["touch", "release"] * 4


UP = np.array([0.0, 0.0, 1.0])


def detector(noise: float) -> ContactDetector:
    errors = SensorUncertainty(noise=noise)
    return ContactDetector(MAP, threshold=ReadingSettings().threshold_for(errors), errors=errors)


@pytest.mark.long
@pytest.mark.parametrize("noise", [100.0, 500.0, 2000.0])
def test_noise_alone_is_not_a_contact(noise):
    random = np.random.default_rng(0)
    own = detector(noise)
    high = 0
    found = 0
    for _ in range(2000):
        pressures = random.normal(0, noise, len(SKIN))
        high += int((pressures >= own.threshold).sum())
        found += len(own.read(pressures))
    assert high > 500 or noise < TOUCH_THRESHOLD / 3, "many a taxel reads three deviations"
    assert found == 0


@pytest.mark.long
@pytest.mark.parametrize("noise", [500.0, 2000.0])
def test_contact_above_the_noise_is_found_and_keeps_its_id(noise):
    random = np.random.default_rng(0)
    own = detector(noise)
    exact = WaterFillModel(SKIN).pressures([sphere_load("bar", np.array([0.2, 0.0, 0.02]), UP, 10.0, 0.02)])
    assert exact.max() > 6 * noise
    ids = [[region.id for region in own.read(exact + random.normal(0, noise, len(SKIN)))] for _ in range(500)]
    assert all(ids)
    assert [seen for seen in ids if seen != [1]] == []


def test_many_lightly_touched_taxels_form_a_contact_and_few_do_not():
    """Four deviations on one taxel are noise, on nine they are not."""
    noise = 1000.0
    middle = int(np.hypot(*(SKIN.patches[0].taxels.positions[:, :2] - (0.2, 0.0)).T).argmin())
    around = np.argsort(
        np.linalg.norm(SKIN.patches[0].taxels.positions - SKIN.patches[0].taxels.positions[middle], axis=1)
    )
    for count, contacts in ((1, 0), (9, 1)):
        pressures = np.zeros(len(SKIN))
        pressures[around[:count]] = 4 * noise
        assert len(detector(noise).read(pressures)) == contacts


def test_rejected_contact_is_tested_again():
    """The same taxels, harder: the mask of touched taxels has not changed, its meaning has."""
    noise = 1000.0
    own = detector(1000.0)
    pressures = np.zeros(len(SKIN))
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


def test_light_touch_next_to_a_firm_one_is_detected():
    """A threshold of a tenth of the peak would hide it."""
    loads = [sphere_load("bar", np.array([x, 0.0, 0.02]), UP, force, 0.02) for x, force in ((0.1, 40.0), (0.3, 0.4))]
    pressures = WaterFillModel(SKIN).pressures(loads)
    light = WaterFillModel(SKIN).pressures(loads[1:])
    assert light.max() < 0.1 * pressures.max()
    assert len(detector(0.0).read(pressures)) == 2


BAR = prepared_bar()
PITCHED_SKIN = BAR.skin
TRIES = 600


def wide() -> np.ndarray:
    """Six or so taxels pressed well above the threshold."""
    return WaterFillModel(PITCHED_SKIN).pressures([sphere_load("bar", np.array([0.2, 0.0, 0.02]), UP, 200.0, 0.08)])


def test_scatter_of_the_centre_for_misplaced_taxels_matches_the_error_bars():
    """The centre of pressure of taxels that sit elsewhere than they are said to, independently."""
    random = np.random.default_rng(0)
    sd = 0.002
    (region,) = ContactDetector(BAR.map, errors=SensorUncertainty(calibration=sd)).read(wide())
    forces = wide()[region.taxels] * PITCHED_SKIN.areas[region.taxels]
    shifts = random.normal(0, sd, (20 * TRIES, len(forces), 2))
    centres = np.einsum("k,nkc->nc", forces / forces.sum(), shifts)
    (trusted,) = ContactDetector(BAR.map).read(wide())
    said = np.sqrt(region.place_error**2 - trusted.place_error**2)
    assert np.sqrt(centres.var(axis=0).sum()) == pytest.approx(said, rel=0.03)


@cache
def run() -> tuple[PreparedScene, tuple[Frame, ...]]:
    prepared = prepare_cached(load_scene("self_touch"))
    session = Session(prepared)
    return prepared, tuple(session.tick() for _ in range(round(7.5 / prepared.scene.tick)))


@pytest.mark.long
def test_both_sides_are_linked_while_both_are_measured():
    _, frames = run()
    both = [frame.regions for frame in frames if len({region.link for region in frame.regions}) == 2]
    assert len(both) > 500, "they touch for seconds"
    for one, other in both:
        assert (one.partner, other.partner) == (other.id, one.id)


@pytest.mark.long
def test_partners_measure_the_same_force_at_the_same_place():
    prepared, frames = run()
    configuration = Configuration(prepared.robot)
    for frame in frames[::20]:
        if len(frame.regions) == 2:
            configuration.update(frame.posture)
            one, other = frame.regions
            at = [configuration.pose(region.link).points(region.link_position) for region in frame.regions]
            assert one.force == pytest.approx(other.force, rel=1e-6)
            assert np.linalg.norm(at[0] - at[1]) < one.place_error + other.place_error


@pytest.mark.long
def test_self_touch_events_have_descriptions():
    _, frames = run()
    events = [event for frame in frames for event in frame.events]
    assert [event.kind for event in events].count("self-touch") == 2
    reported = [event for event in events if event.phase == "ended"]
    words = [event.words for event in reported]
    assert any(text.startswith("left hand touches right forearm, ") for text in words)
    stroke = next(event for event in reported if event.kind == "stroke")
    assert stroke.links == ("right_forearm",), "along it goes the hand, which is pressed at one place"
    assert 0.04 < stroke.travelled < 0.12
    assert not any(event.kind == "grasp" for event in events)
