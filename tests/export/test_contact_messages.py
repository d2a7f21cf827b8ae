"""Wrenches of contacts and links with covariance: force, arm, uncertainty of the place, shear; outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.pipeline import read_contacts
from tactile_maps.export.contact_messages import contact_wrench, link_wrench, outline
from tactile_maps.session.session import Session
from tactile_maps.tactile.press import press_skin
from tests.support.touch import bar_map, bar_skin, prepared_bar


@pytest.fixture(scope="module")
def region():
    """A touch of 3 N on the top of the bar, whose outward normal is z."""
    skin = bar_skin()
    (found,) = read_contacts(bar_map(), press_skin(skin, skin.taxel_point(30), force=3.0))
    return replace(found, force_error=0.2, place_error=0.003)


def test_force_points_against_the_normal_with_the_moment_about_the_link(region):
    one = contact_wrench(region)
    np.testing.assert_allclose(one.wrench, [0, 0, -region.force, 0, 0, 0], atol=1e-12)
    link = link_wrench([region, region])
    x, y, _ = region.link_position
    np.testing.assert_allclose(link.wrench[3:], 2 * region.force * np.array([-y, x, 0]), atol=1e-12)
    np.testing.assert_allclose(link.wrench[:3], 2 * one.wrench[:3])


def test_covariance_matches_that_of_random_forces_and_positions(region):
    random = np.random.default_rng(0)
    count = 200_000
    arm = 2 / 3 * np.sqrt(region.area / np.pi)
    force = random.normal(0, [region.force, region.force, 0.2], (count, 3)) - [0, 0, region.force]
    place = region.link_position + random.normal(0, 0.003 / np.sqrt(2), (count, 3)) * [1, 1, 0]
    mean = [0, 0, -region.force]
    torque = np.cross(region.link_position, force) + np.cross(place - region.link_position, mean)
    torque[:, 2] += random.normal(0, region.force * arm, count)
    found = link_wrench([region]).covariance
    expected = np.cov(np.hstack([force, torque]).T)
    scale = np.sqrt(np.outer(np.diag(found), np.diag(found)))
    np.testing.assert_allclose(found / scale, expected / scale, atol=0.02)
    assert np.linalg.eigvalsh(found).min() > -1e-12


def test_measured_shear_replaces_the_assumed_friction(region):
    shear = ContactShear((0.5, -0.2, 0.0), 0.01, 0.2, 1.0, Slip.STICKING, 0.8, False, 0.05, 0.002)
    one = contact_wrench(replace(region, shear=shear))
    np.testing.assert_allclose(one.wrench, [0.5, -0.2, -region.force, 0, 0, 0.01], atol=1e-12)
    assert np.allclose(np.diag(one.covariance)[[0, 1, 2, 5]], [0.05**2, 0.05**2, 0.2**2, 0.002**2])


def test_outline_is_counter_clockwise_around_the_touched_taxels(region):
    skin = bar_skin()
    frame = replace(Session(prepared_bar()).frame, pressures=press_skin(skin, skin.taxel_point(30), force=3.0))

    def turned_area(corners):
        x, y = corners[:, 0], corners[:, 1]
        return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))

    corners = outline(region, frame, skin)
    assert len(corners) >= 3
    assert turned_area(corners) > 0
    single = outline(replace(region, touched=1), frame, skin)
    assert np.isclose(turned_area(single), region.area)
    np.testing.assert_allclose(single.mean(axis=0), region.link_position, atol=1e-12)
