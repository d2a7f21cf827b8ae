"""What touches two patches at once is one contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.border_contact import WIDE, over_borders
from app.control.map_sight import MapSight
from app.robots.configuration import Configuration
from tests.touch import bar
from tests.unit.control.plates import two_plates
from tests.unit.control.touched import region

SIGHT = MapSight(two_plates(gap=0.002))


def touching(x, force, id_):
    at = SIGHT.map.to_body(np.array([x, 0.05]))
    return region(force, at, SIGHT.map.skin.position(at), np.array([x, 0.05]), id_=id_)


def together(posture, *regions):
    configuration = Configuration(bar())
    configuration.update(np.array([posture]))
    return over_borders(regions[0], regions, SIGHT, configuration, "smoothed")


@pytest.mark.parametrize("posture", [0.0, 0.7])
def test_its_force_is_that_of_both_and_its_place_between(posture):
    """At 96 mm on the one patch, and 2 + 106 mm from its beginning on the other, whatever way the link is turned."""
    left, right = touching(0.096, 2.0, 1), touching(0.126, 1.0, 2)
    one = together(posture, left, right)
    assert one.force == pytest.approx(3.0)
    assert one.point == pytest.approx([0.096 + 0.012 / 3, 0.05, 0.0])
    assert one.map_point == pytest.approx([0.1, 0.05], abs=1e-4), "as if the map went on over the border"
    assert (one.id, one.at) == (left.id, left.at)
    other = together(posture, right, left)
    assert other.point == pytest.approx(one.point)


def test_what_is_alone_stays_as_it_is():
    left = touching(0.096, 2.0, 1)
    assert together(0.0, left) is left


def test_what_is_far_and_what_is_on_the_same_patch_are_other_contacts():
    left = touching(0.096, 2.0, 1)
    assert together(0.0, left, touching(0.05, 1.0, 2)) is left
    assert WIDE * SIGHT.pitch < 0.05
    assert together(0.0, left, touching(0.19, 1.0, 2)) is left


def test_without_force_it_is_in_the_middle_of_nothing():
    left, right = (replace(touching(x, 1.0, k), force=0.0) for k, x in ((1, 0.096), (2, 0.126)))
    assert np.isfinite(together(0.0, left, right).map_point).all()
