"""What a controller sees of the map."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import touch_on
from tests.support.touch import arm, prepared_bar


def test_the_pitch_is_that_of_the_taxels():
    map_kinematics = MapKinematics(prepared_bar().map)
    assert map_kinematics.pitch == pytest.approx(np.sqrt(0.38 * 0.1 / 60), rel=0.01)


def test_the_jacobian_turns_with_the_link():
    prepared = prepared_bar()
    map_kinematics = MapKinematics(prepared.map)
    configuration = Configuration(prepared.robot)
    at = prepared.skin.taxel_point(20)
    flat = map_kinematics.jacobian(at, "smoothed", configuration)
    configuration.update(np.array([0.7]))
    turned = map_kinematics.jacobian(at, "smoothed", configuration)
    rotation = configuration.pose("bar").rotation
    assert turned == pytest.approx(flat @ rotation.T)
    assert turned @ rotation[:, 2] == pytest.approx([0, 0], abs=1e-9), "nothing comes of motion along the normal"


def test_on_one_piece_the_way_is_straight_on_the_map():
    prepared = prepared_bar()
    map_kinematics = MapKinematics(prepared.map)
    configuration = Configuration(prepared.robot)
    region = touch_on(prepared.map, 10, 1.0)
    target = prepared.skin.taxel_point(50)
    jacobian = map_kinematics.jacobian(region.at, "smoothed", configuration)
    wanted = prepared.map.taxel_points[50] - prepared.map.taxel_points[10]
    assert map_kinematics.error(target, region, jacobian, configuration) == pytest.approx(wanted)


def test_over_a_seam_the_way_is_as_long_as_on_the_body():
    """Neighbours on the body, whose map points a seam takes apart."""
    prepared = arm()
    map_kinematics = MapKinematics(prepared.map)
    skin = prepared.skin
    configuration = Configuration(prepared.robot)
    points = prepared.map.taxel_points
    seen = 0
    for here, there in skin.neighbours:
        body = np.linalg.norm(skin.position(skin.taxel_point(here)) - skin.position(skin.taxel_point(there)))
        if np.linalg.norm(points[here] - points[there]) < 4 * body:
            continue
        region = touch_on(prepared.map, int(here), 1.0)
        jacobian = map_kinematics.jacobian(region.at, "smoothed", configuration)
        error = map_kinematics.error(skin.taxel_point(int(there)), region, jacobian, configuration)
        assert np.linalg.norm(np.linalg.pinv(jacobian) @ error) == pytest.approx(body, rel=1e-6)
        seen += 1
    assert seen > 3


def test_from_link_to_link_the_way_is_that_in_space():
    prepared = arm()
    map_kinematics = MapKinematics(prepared.map)
    skin = prepared.skin
    configuration = Configuration(prepared.robot)
    region = touch_on(prepared.map, int(skin.first[1]) + 10, 1.0)
    jacobian = map_kinematics.jacobian(region.at, "smoothed", configuration)
    target = skin.taxel_point(3)
    assert target.patch != region.at.patch
    places = [configuration.pose(skin.link(at)).points(skin.position(at)) for at in (region.at, target)]
    error = map_kinematics.error(target, region, jacobian, configuration)
    way = places[1] - places[0]
    assert error / np.linalg.norm(error) == pytest.approx(jacobian @ way / np.linalg.norm(jacobian @ way))
    assert np.linalg.norm(error) == pytest.approx(np.linalg.norm(way), rel=0.2)


def test_the_gluing_is_made_once():
    map_kinematics = MapKinematics(prepared_bar().map)
    assert map_kinematics.transitions is map_kinematics.transitions


def test_how_far_places_and_contacts_are_apart_is_measured_in_space():
    prepared = arm()
    map_kinematics = MapKinematics(prepared.map)
    skin = prepared.skin
    configuration = Configuration(prepared.robot)
    here = skin.taxel_point(3)
    there = skin.taxel_point(int(skin.first[1]) + 10)
    places = [configuration.pose(skin.link(at)).points(skin.position(at)) for at in (here, there)]
    apart = map_kinematics.apart(here, there, configuration)
    assert apart == pytest.approx(np.linalg.norm(places[0] - places[1]))
    assert map_kinematics.away(
        here, touch_on(prepared.map, int(skin.first[1]) + 10, 1.0), configuration
    ) == pytest.approx(apart)
