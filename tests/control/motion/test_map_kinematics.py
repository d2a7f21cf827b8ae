"""Jacobians of the map, and distances across seams and links."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import touch_on
from tests.support.touch import arm, prepared_bar


class Bench:
    """The map of a robot at home."""

    def __init__(self, prepared):
        self.map = prepared.map
        self.kinematics = MapKinematics(prepared.map)
        self.configuration = Configuration(prepared.robot)

    def jacobian(self, taxel):
        return self.kinematics.jacobian(self.map.skin.taxel_point(taxel), "smoothed", self.configuration)

    def error(self, here, there):
        """Return the error from a contact at one taxel to another taxel, and the Jacobian at the contact."""
        jacobian = self.jacobian(here)
        target = self.map.skin.taxel_point(there)
        return self.kinematics.error(target, touch_on(self.map, here, 1.0), jacobian, self.configuration), jacobian

    def place(self, taxel):
        skin = self.map.skin
        at = skin.taxel_point(taxel)
        return self.configuration.pose(skin.link(at)).points(skin.position(at))


def test_jacobian_rotates_with_the_link():
    bench = Bench(prepared_bar())
    assert bench.kinematics.pitch == pytest.approx(np.sqrt(0.38 * 0.1 / 60), rel=0.01)
    assert bench.kinematics.transitions is bench.kinematics.transitions
    flat = bench.jacobian(20)
    bench.configuration.update(np.array([0.7]))
    rotation = bench.configuration.pose("bar").rotation
    assert bench.jacobian(20) == pytest.approx(flat @ rotation.T)
    assert bench.jacobian(20) @ rotation[:, 2] == pytest.approx([0, 0], abs=1e-9), "none for motion along the normal"


def test_error_within_a_patch_is_the_straight_map_vector():
    bench = Bench(prepared_bar())
    assert bench.error(10, 50)[0] == pytest.approx(bench.map.taxel_points[50] - bench.map.taxel_points[10])


def test_error_across_a_seam_is_as_long_as_on_the_body():
    """Neighbours on the body, whose map points a seam takes apart."""
    bench = Bench(arm())
    points = bench.map.taxel_points
    count = 0
    for here, there in bench.map.skin.neighbours.tolist():
        body = np.linalg.norm(bench.place(here) - bench.place(there))
        if np.linalg.norm(points[here] - points[there]) >= 4 * body:
            error, jacobian = bench.error(here, there)
            assert np.linalg.norm(np.linalg.pinv(jacobian) @ error) == pytest.approx(body, rel=1e-6)
            count += 1
    assert count > 3


def test_error_between_links_is_the_distance_in_space():
    bench = Bench(arm())
    here = int(bench.map.skin.first[1]) + 10
    error, jacobian = bench.error(here, 3)
    way = bench.place(3) - bench.place(here)
    length = np.linalg.norm(way)
    assert error / np.linalg.norm(error) == pytest.approx(jacobian @ way / np.linalg.norm(jacobian @ way))
    assert np.linalg.norm(error) == pytest.approx(length, rel=0.2)
    ends = [bench.map.skin.taxel_point(taxel) for taxel in (3, here)]
    assert bench.kinematics.apart(*ends, bench.configuration) == pytest.approx(length)
    touched = touch_on(bench.map, here, 1.0)
    assert bench.kinematics.away(ends[0], touched, bench.configuration) == pytest.approx(length)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_curvature_is_that_of_the_body_along_the_motion(turn):
    """The forearm is round about its axis, and straight along it."""
    bench = Bench(arm())
    bench.configuration.update(arm().robot.home + turn)
    skin = bench.map.skin
    rotation = bench.configuration.pose("forearm").rotation
    taxels = [n for n in range(len(skin)) if skin.patch_of[n] == 1 and 0.1 < skin.positions[n, 2] < 0.2]
    assert len(taxels) > 20
    around = []
    along = []
    for taxel in taxels:
        jacobian = bench.jacobian(taxel)
        region = touch_on(bench.map, taxel, 1.0)
        sideways = rotation @ np.cross([0.0, 0.0, 1.0], skin.normals[taxel])
        radius = np.linalg.norm(skin.positions[taxel, :2])
        around.append(radius * bench.kinematics.curvature(region, jacobian @ sideways, jacobian))
        along.append(radius * bench.kinematics.curvature(region, jacobian @ rotation[:, 2], jacobian))
        assert bench.kinematics.curvature(region, np.zeros(2), jacobian) == 0.0
    assert np.median(around) == pytest.approx(1.0, abs=0.15), "the section is nearly a circle"
    assert np.median(along) == pytest.approx(0.0, abs=0.1)
