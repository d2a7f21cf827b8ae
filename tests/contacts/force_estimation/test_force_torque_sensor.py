"""The paper's baseline: a force-torque sensor in the link and its surface."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.force_estimation.estimate import ContactReading, EstimateRefusal, Wrench
from tactile_maps.contacts.force_estimation.force_torque_sensor import ForceTorqueSensor
from tactile_maps.core.errors import MapError
from tests.contacts.force_estimation.readings_by_hand import PLACE, SKIN, UP, reading
from tests.support.touch import arm


def wrench_at(point, force) -> Wrench:
    return Wrench(force, np.cross(point, force))


def test_pushes_anywhere_on_an_arm_are_located_correctly():
    """The line of force enters a tube on the pushed side, and its exit is never chosen."""
    skin = arm().skin
    detector = ContactDetector(arm().map)
    lumped = ForceTorqueSensor(arm().skin)
    for taxel in range(0, len(skin), 7):
        at = skin.taxel_point(taxel)
        point = skin.position(at)
        normal = skin.normal(at)
        pressures = np.zeros(len(skin))
        pressures[taxel] = 5e3
        detector.reset()
        given = ContactReading(detector.read(pressures)[0], pressures, wrench=wrench_at(point, -4.0 * normal))
        found = lumped.estimate(given)
        assert found.at is not None
        assert skin.position(found.at) == pytest.approx(point, abs=1e-4)
        assert found.force == pytest.approx(4.0, rel=0.05)


def test_friction_tilts_the_force_but_does_not_move_its_position():
    force = np.array([3.0, 0.0, -10.0])
    found = ForceTorqueSensor(SKIN).estimate(reading(wrench=wrench_at(PLACE, force)))
    assert SKIN.position(found.at) == pytest.approx(PLACE, abs=1e-6)
    assert found.force == pytest.approx(10.0), "its normal part"


@pytest.mark.parametrize(
    ("wrench", "why"),
    [
        (wrench_at(np.array([0.6, 0, 0.02]), -10.0 * UP), EstimateRefusal.OFF_SKIN),
        (wrench_at(PLACE, 10.0 * UP), EstimateRefusal.OFF_SKIN),
        (Wrench(np.zeros(3), np.ones(3)), EstimateRefusal.NO_FORCE),
    ],
    ids=["outside", "pulling", "torque alone"],
)
def test_estimate_without_position_states_the_reason(wrench, why):
    found = ForceTorqueSensor(SKIN).estimate(reading(wrench=wrench))
    assert found.at is None
    assert found.refused is why


def test_missing_sensor_is_rejected():
    with pytest.raises(MapError, match="no force-torque data"):
        ForceTorqueSensor(SKIN).estimate(reading())
