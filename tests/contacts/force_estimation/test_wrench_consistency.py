"""Test of whether one touch explains a wrench, on the bar, with loads whose wrench is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.force_estimation.estimate import Wrench
from tactile_maps.contacts.force_estimation.wrench_consistency import wrench_mismatch
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import bar_map

MAP = bar_map(400)
SKIN = MAP.skin
POSITIONS = SKIN.positions
UP = np.array([0.0, 0.0, 1.0])


def ball(x: float, force: float = 10.0) -> Load:
    return sphere_load("bar", np.array([x, 0.005, 0.02]), UP, force, 0.02)


def seen(*loads: Load):
    """The skin's contacts along the bar."""
    regions = ContactDetector(MAP).read(WaterFillModel(SKIN).pressures(list(loads)))
    return sorted(regions, key=lambda region: region.link_position[0])


def wrench_of(*loads: Load, drag: float = 0.0, noise: float = 0.0) -> Wrench:
    forces = [load.force * (-load.normal + drag * np.array([0.0, 1.0, 0.0])) for load in loads]
    torques = [np.cross(load.point, force) for load, force in zip(loads, forces, strict=True)]
    return Wrench(sum(forces), sum(torques), force_noise=noise, torque_noise=0.02 * noise)


def mismatch(regions, wrench):
    return wrench_mismatch("bar", wrench, regions, POSITIONS)


def test_single_region_is_never_a_mismatch():
    (region,) = seen(ball(0.2))
    assert mismatch((region,), wrench_of(ball(0.1), ball(0.3))) is None
    assert mismatch((), wrench_of(ball(0.2))) is None


def test_two_equal_touches_are_a_mismatch_with_its_size():
    loads = ball(0.1), ball(0.3)
    found = mismatch(seen(*loads), wrench_of(*loads))
    assert found is not None
    assert (found.link, found.touches) == ("bar", 2)
    assert found.torque == pytest.approx(10 * 0.2, rel=0.02), "the other one's, about this one"
    assert found.force == pytest.approx(10.0, rel=0.02)
    assert found.torque > found.max_torque
    assert found.strongest == pytest.approx(10.0, rel=0.02)


def test_touch_next_to_a_weak_one_explains_the_wrench():
    (strong, weak), loads = seen(ball(0.1), ball(0.3, 5.0)), (ball(0.1), ball(0.3, 0.1))
    assert mismatch((strong, replace(weak, force=0.1)), wrench_of(*loads)) is None


@pytest.mark.parametrize("drag", [0.0, 0.5])
def test_dragging_touch_next_to_a_weak_one_explains_the_wrench(drag):
    first, second = seen(ball(0.1), ball(0.3))
    assert mismatch((first, replace(second, force=0.0)), wrench_of(ball(0.1), drag=drag)) is None


def test_forces_without_a_resultant_are_a_mismatch():
    """Two contacts squeeze the bar: their wrenches cancel, so the resultant contains nothing about their forces."""
    first, second = seen(ball(0.1), ball(0.3))
    found = mismatch((first, second), Wrench(np.zeros(3), np.zeros(3)))
    assert found is not None
    assert found.strongest == pytest.approx(10.0, rel=0.02)


def test_sensor_noise_is_not_a_mismatch():
    """The threshold is 4 standard deviations: none of 300 readings is a mismatch if the second contact has no force."""
    rng = np.random.default_rng(0)
    noise = 0.5
    true = wrench_of(ball(0.1))
    first, second = seen(ball(0.1), ball(0.3))
    for _ in range(300):
        force, torque = rng.normal(size=(2, 3))
        read = Wrench(true.force + noise * force, true.torque + 0.02 * noise * torque, noise, 0.02 * noise)
        assert mismatch((first, replace(second, force=0.0)), read) is None


def test_body_over_a_gap_in_the_skin_is_one_contact():
    """The force acts between two regions whose extents overlap, which is not a mismatch."""
    (region,) = seen(ball(0.2))
    reach = np.linalg.norm(POSITIONS[region.taxels] - region.link_position, axis=1).max()
    halves = [
        replace(region, id=k, force=5.0, link_position=region.link_position + np.array([side * 0.8 * reach, 0, 0]))
        for k, side in ((1, -1), (2, 1))
    ]
    assert mismatch(tuple(halves), wrench_of(ball(0.2))) is None
