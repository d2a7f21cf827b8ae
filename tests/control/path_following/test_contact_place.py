"""Place of a contact between coarse taxels, read at the nearest one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import ActiveLimits
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.control.path_following.contact_place import MOST_OFF, SPARSE, ContactPlace
from tactile_maps.maps.model.layout import MapLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, touch_on
from tests.support.touch import arm

PITCH = 0.018
"""Distance between the taxels at which contacts are read [m]."""


class Slid:
    """A forearm that slides under a point of an object at 10 mm/s, which is read at the nearest of coarse places."""

    def __init__(self, *, pitch: float = PITCH, rests: bool = True) -> None:
        self.prepared = arm()
        self.kinematics = MapKinematics(self.prepared.map)
        self.kinematics.pitch = pitch
        self.rests = rests
        self.place = ContactPlace()
        self.configuration = Configuration(self.prepared.robot)
        skin = self.prepared.skin
        first = int(skin.first[[patch.link for patch in skin.patches].index("forearm")])
        points = self.prepared.map.taxel_points[first:]
        centre = first + int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmin())
        self.region = touch_on(self.prepared.map, centre, 3.0)

    def run(self, seconds: float, velocity: tuple[float, float], *, offset: float = 0.0):
        """Return true places, readings and estimates (k, 2) on the map [m]."""
        posture = self.prepared.robot.home
        kinematics = self.kinematics
        start = self.region.map_point
        true = np.zeros(2)
        region = self.region
        rows = []
        for _ in range(round(seconds / TICK)):
            self.configuration.update(posture)
            read = start + PITCH * np.round((true + offset) / PITCH)
            at = kinematics.map.to_body(read)
            skin = kinematics.map.skin
            region = replace(
                region, map_point=read, at=at, link_position=skin.position(at), link_normal=skin.normal(at)
            )
            settings = ControlSettings(task="follow_path")
            now = TaskTick(settings, (region,), kinematics, self.configuration, TICK, ActiveLimits())
            rows.append((start + true, read, self.place.look(now, region).map_point))
            if self.rests:  # else the object moves with the skin, and the arm does not
                jacobian = kinematics.jacobian(at, settings.jacobian, self.configuration)
                move = self.configuration.jacobian(region.link, region.link_position)
                posture = posture - TICK * np.linalg.pinv(jacobian @ move) @ velocity
            true = true + TICK * np.array(velocity)
        return np.array(rows).transpose(1, 0, 2)


def rms(errors):
    """Root mean square distance [m]."""
    return float(np.sqrt((errors**2).sum(axis=1).mean()))


@pytest.mark.parametrize("velocity", [(0.01, 0.0), pytest.param((0.007, 0.007), marks=pytest.mark.long)])
def test_place_of_a_resting_object_is_estimated_between_taxels(velocity):
    true, read, found = Slid().run(6.0, velocity)
    passed = slice(400, None)  # a pitch and more
    assert rms((read - true)[passed]) > 0.005
    assert rms((found - true)[passed]) < 0.5 * rms((read - true)[passed])
    assert np.abs(np.diff(found[passed], axis=0)).max() < 5e-4, "no steps"


def test_estimated_place_of_a_moving_object_stays_near_its_reading():
    true, read, found = Slid(rests=False).run(4.0, (0.02, 0.0))
    assert np.linalg.norm(found - read, axis=1).max() <= MOST_OFF * PITCH * (1 + 1e-9)
    assert np.linalg.norm(found[-1] - true[-1]) < PITCH


def test_readings_of_fine_taxels_are_used_unchanged():
    _, read, found = Slid(pitch=SPARSE).run(0.5, (0.01, 0.0))
    assert np.array_equal(read, found)


def test_new_contact_starts_at_its_measured_position():
    slid = Slid()
    slid.run(2.0, (0.01, 0.0))
    slid.region = replace(slid.region, id=2)
    _, read, found = slid.run(TICK, (0.01, 0.0))
    assert found[0] == pytest.approx(read[0], abs=1e-9)


def test_place_on_the_body_is_kept_when_patches_are_moved():
    slid = Slid()
    _, read, found = slid.run(2.2, (0.01, 0.0))
    assert np.linalg.norm(found[-1] - read[-1]) > 0.003
    shift = np.array([0.01, 0.02])
    placements = tuple(
        replace(one, offset=tuple(np.add(one.offset, shift))) for one in slid.prepared.map.layout.placements
    )
    slid.kinematics = MapKinematics(TactileMap(slid.prepared.skin, slid.prepared.map.charts, MapLayout(placements)))
    slid.kinematics.pitch = PITCH
    slid.region = replace(slid.region, map_point=slid.region.map_point + shift)
    _, _, after = slid.run(TICK, (0.0, 0.0), offset=0.022)
    assert after[0] - shift == pytest.approx(found[-1], abs=5e-4)
