"""A contact that does not come is noticed, and why; one that slides is not taken for it."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.slip_watch import AGAIN, ALONG, BEYOND, LONGEST, SlipWatch
from app.geometry.surface_point import SurfacePoint

DT, ERROR, ASKED = 0.005, np.array([0.01, 0.0]), np.array([0.04, 0.0])
HERE, THERE = SurfacePoint(0, 0, (1.0, 0.0, 0.0)), SurfacePoint(0, 1, (1.0, 0.0, 0.0))


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])


def watched(share, *, asked=ASKED, tried=1.0, seconds=2.0, jump_at=-1, way=0.0):
    """A contact that moves by a share of what the arm tries, in a direction turned by ``way`` degrees."""
    watch, point = SlipWatch(0.005), np.zeros(2)
    for tick in range(round(seconds / DT)):
        step = turned(way) @ (share * tried * asked) * DT
        point = point + step + (np.array([-0.3, 0.2]) if tick == jump_at else 0.0)
        watch.look(1, point, ERROR, asked, tried * asked, DT, target=HERE)
    return watch


def look(watch, error=ERROR, *, contact=1, target=HERE):
    return watch.look(contact, np.zeros(2), error, ASKED, ASKED, DT, target=target)


def test_one_that_comes_along_is_stuck_and_one_that_slides_is_not():
    assert watched(0.0).reason == ALONG
    assert watched(-1.0).reason == ALONG
    assert watched(0.5).reason == ""
    assert watched(1.0, jump_at=40).reason == "", "over a seam the place jumps"


@pytest.mark.parametrize("way", [30, 60, 75, -90])
def test_one_that_comes_sideways_slides_on_a_map_that_is_wrong(way):
    assert watched(1.0, way=way).reason == ""


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_where_the_arm_cannot_even_try_the_target_is_out_of_reach(share):
    assert watched(share, tried=0.0).reason == BEYOND
    assert watched(share, tried=0.3).reason == ("" if share else ALONG)


def test_little_is_no_proof():
    assert watched(0.0, seconds=0.2).reason == ""
    assert watched(0.0, asked=0.02 * ASKED, seconds=3 * LONGEST).reason == ""


def test_it_is_tried_again_when_the_error_changed_or_another_contact_comes():
    watch = watched(0.0)
    assert look(watch) == ALONG
    assert look(watch, ERROR + [0, 1.1 * AGAIN]) == ""
    assert look(watched(0.0), contact=2) == ""
    watch = watched(0.0)
    watch.reset()
    assert look(watch) == ""


def test_what_is_out_of_reach_stays_so_until_the_target_changes_or_is_nearer():
    """A contact that is let go slides away, and comes and goes: that is no reason to try again."""
    watch = watched(0.0, tried=0.0)
    assert look(watch, ERROR + [0.01, 0]) == BEYOND
    assert look(watch, contact=2) == BEYOND
    assert look(watch, ERROR - [1.1 * AGAIN, 0]) == ""
    assert look(watched(0.0, tried=0.0), target=THERE) == ""
