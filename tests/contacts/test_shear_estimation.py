"""Shear of contacts, read from tractions on a flat map, and the slip of a ball that is pulled along a skin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import Slip
from tactile_maps.contacts.detection.shear_estimation import ShearEstimator
from tactile_maps.contacts.events import STICKS
from tactile_maps.contacts.pipeline import read_contacts
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tests.support.references import unrolled
from tests.support.touch import bar_skin

FRICTION = 0.5


def pressed():
    """Return a flat map, the pressures of a ball in its middle, and the one contact."""
    map_ = unrolled(bar_skin().patches[0].surface, taxels=200)
    places = map_.skin.patches[0].taxels.positions
    away = np.linalg.norm(places - [0.2, 0.0, 0.02], axis=1)
    pressures = np.maximum(0.0, 5e4 * (1 - (away / 0.03) ** 2))
    (region,) = read_contacts(map_, pressures)
    return map_, pressures, region


@pytest.mark.parametrize(("share", "slip"), [(0.5, Slip.STICKING), (0.96, Slip.SLIDING)])
@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_uniform_usage_is_read_as_force_usage_and_state(share, slip, angle):
    map_, pressures, region = pressed()
    direction = np.array([np.cos(angle), np.sin(angle)])
    reader = ShearEstimator(map_, FRICTION)
    reader.noise = 10.0
    (found,) = reader.read(0.0, [region], pressures, share * FRICTION * pressures[:, None] * direction)
    expected = share * FRICTION * region.force * direction @ taxel_frames(map_)[region.taxels[0], :2]
    np.testing.assert_allclose(found.shear.force, expected, atol=1e-9)
    assert found.shear.usage == pytest.approx(share)
    assert found.shear.slip is slip
    areas = map_.skin.areas[region.taxels]
    assert found.shear.force_error == pytest.approx(10.0 * np.sqrt((areas**2).sum()))


def test_rotating_tractions_are_read_as_a_torque():
    map_, pressures, region = pressed()
    arms = map_.skin.patches[0].taxels.positions - region.link_position
    turning = np.einsum("ijk,ik->ij", taxel_frames(map_)[:, :2], np.cross(region.link_normal, arms))
    (found,) = ShearEstimator(map_, FRICTION).read(0.0, [region], pressures, pressures[:, None] * turning)
    weights = map_.skin.areas * pressures
    assert found.shear.torque == pytest.approx(float(weights @ (arms**2).sum(axis=1)), rel=1e-6)


def test_shear_on_ring_taxels_of_two_contacts_counts_once():
    map_, pressures, region = pressed()
    order = np.argsort(map_.skin.patches[0].taxels.positions[region.taxels, 0])
    halves = [np.sort(region.taxels[order[:-5]]), np.sort(region.taxels[order[5:]])]
    along = FRICTION * pressures[:, None] * [0.5, 0.0]
    parts = [replace(region, id=number, taxels=own) for number, own in enumerate(halves, start=1)]
    (whole,) = ShearEstimator(map_, FRICTION).read(0.0, [region], pressures, along)
    both = ShearEstimator(map_, FRICTION).read(0.0, parts, pressures, along)
    np.testing.assert_allclose(sum(np.array(part.shear.force) for part in both), whole.shear.force, rtol=1e-9)


def test_errors_of_force_and_torque_cover_the_noise_of_the_taxels():
    map_, pressures, region = pressed()
    rng = np.random.default_rng(3)
    reader = ShearEstimator(map_, FRICTION)
    reader.noise = 200.0
    noise = [rng.normal(scale=200.0, size=(len(pressures), 2)) for _ in range(300)]
    found = [reader.read(0.0, [region], pressures, shear)[0].shear for shear in noise]
    along = np.array([shear.force for shear in found]) @ taxel_frames(map_)[region.taxels[0], 0]
    assert along.std() == pytest.approx(found[0].force_error, rel=0.15)
    assert np.std([shear.torque for shear in found]) == pytest.approx(found[0].torque_error, rel=0.15)


@pytest.mark.parametrize(
    ("rises", "usages", "estimated"),
    [(1.0, [0.4] * 20, 0.2), (1.05, [0.4] * 20, None), (1.0, [0.4] * 12 + [0.8] * 5, None)],
    ids=["steady force", "rising force", "more shear later"],
)
def test_friction_is_measured_from_a_moving_contact_that_slides(rises, usages, estimated):
    map_, pressures, region = pressed()
    reader = ShearEstimator(map_, FRICTION)
    for tick, usage in enumerate(usages):
        moved = replace(region, link_position=region.link_position + [0.01 * tick, 0.0, 0.0])
        loaded = replace(moved, force=region.force * rises**tick)
        shear = usage * FRICTION * rises**tick * pressures[:, None] * [1.0, 0.0]
        (found,) = reader.read(0.01 * tick, [loaded], rises**tick * pressures, shear)
    assert found.shear.estimated == (estimated is not None)
    assert found.shear.friction == pytest.approx(estimated or FRICTION)


def test_friction_is_not_measured_from_a_contact_that_rolls():
    """Its shear is not proportional to its pressure."""
    map_, pressures, region = pressed()
    reader = ShearEstimator(map_, FRICTION)
    shear = np.where(pressures[:, None] > 0, [0.1 * pressures.max(), 0.0], 0.0)
    for tick in range(20):
        moved = replace(region, link_position=region.link_position + [0.01 * tick, 0.0, 0.0])
        (found,) = reader.read(0.01 * tick, [moved], pressures, shear)
    assert not found.shear.estimated


@pytest.fixture(scope="module")
def frames():
    """Frames of the shipped scene until the ball has turned back and stuck."""
    session = Session(prepare_cached(load_scene("slip")))
    return [session.tick() for _ in range(1010 + round(STICKS / 0.005))]


def test_pulled_ball_sticks_then_starts_to_slip_then_slides(frames):
    events = [(event.kind, event.phase) for frame in frames for event in frame.events if "slip" in event.kind]
    assert events == [("incipient-slip", "began"), ("slip", "began"), ("slip", "ended")]
    sliding = frames[700].regions[0].shear
    assert sliding.slip is Slip.SLIDING
    assert sliding.estimated
    assert sliding.friction == pytest.approx(0.5, rel=0.02)
    limits = FRICTION * frames[700].pressures
    assert (np.linalg.norm(frames[700].shear, axis=1) <= limits * (1 + 1e-9) + 1e-9).all()


def test_behaviour_that_waits_for_slip_switches_shear_on():
    scene = replace(load_scene("slip"), outputs=("posture", "force"))
    assert not scene.effects.shear
    assert replace(scene, behaviours=({"on": "slip", "then": {"task": "retreat"}},)).effects.shear
