"""Contacts with a force goal, and those reported because the joints do not relieve them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.joint_impedance import MAX_POINT_SPEED
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.task_control.contact_selection import (
    KEPT_SHARE,
    PATIENCE,
    ContactSelection,
    ControlledContact,
    ReliefMonitor,
)
from tests.control.contacts import TICK, touch

GOAL = 3.0


def others(selection, *forces, first=1):
    """The ids selected besides ``first`` of contacts 1, 2, ... with these forces."""
    regions = [touch(force, id_=number)[0] for number, force in enumerate(forces, start=1)]
    return [region.id for region in selection.others(regions[first - 1], regions, GOAL)]


def test_contacts_above_the_goal_are_selected_in_addition_to_the_first():
    assert others(ContactSelection(), 1.0, 3.1, 2.9, 8.0) == [2, 4]
    assert others(ContactSelection(), 5.0, 4.0, first=2) == [1]


def test_selected_contact_stays_down_to_a_share_of_the_goal():
    selection = ContactSelection()
    assert others(selection, 3.0, 3.1) == [2]
    assert others(selection, 3.0, 1.01 * KEPT_SHARE * GOAL) == [2]
    assert others(selection, 3.0, 0.99 * KEPT_SHARE * GOAL) == []
    assert others(selection, 3.0, 2.9) == [], "it is another contact now"


def test_only_contacts_above_the_goal_are_selected_after_a_reset():
    selection = ContactSelection()
    others(selection, 3.0, 3.1)
    selection.reset()
    assert others(selection, 3.0, 2.0) == []


def test_other_side_of_a_self_contact_is_not_selected():
    (first,), (other,), (third,) = touch(5.0), touch(5.0, id_=2), touch(5.0, id_=3)
    regions = [replace(first, partner=2), replace(other, partner=1), third]
    assert [region.id for region in ContactSelection().others(regions[0], regions, GOAL)] == [3]


UP = np.array([1.0])
DOWN = np.array([-1.0])
GAIN = 0.005


def controlled(number, force, outward, *, left_out=False):
    [region] = touch(force, id_=number)
    return ControlledContact(replace(region, link=f"link {number}"), GOAL, outward, left_out)


def reported(*contacts, speed, seconds=2 * PATIENCE, monitor=None):
    """The limits after a while; each contact is (force, outward row)."""
    monitor = monitor or ReliefMonitor()
    limits = ActiveLimits()
    for _ in range(round(seconds / TICK)):
        limits = ActiveLimits()
        rows = [controlled(k, force, row) for k, (force, row) in enumerate(contacts, start=1)]
        monitor.look(rows, np.array([speed]), np.ones(1), GAIN, TICK, limits)
    return limits.found


def test_opposed_contacts_are_reported_with_the_largest_force():
    monitor = ReliefMonitor()
    found = reported((8.0, UP), (12.0, DOWN), speed=0.0, monitor=monitor)
    assert found == (Limit(LimitKind.CONTACTS_OPPOSED, ("link 2", "link 1"), value=12.0, bound=GOAL),)
    assert monitor.unrelieved == {1, 2}


def test_only_the_unrelieved_contact_is_reported():
    speed = GAIN * (12.0 - GOAL)
    assert reported((8.0, UP), (12.0, DOWN), speed=speed) == (
        Limit(LimitKind.CONTACTS_OPPOSED, ("link 1",), value=8.0, bound=GOAL),
    )


@pytest.mark.parametrize("force", [GOAL - 1, GOAL, 1.05 * GOAL])
def test_contact_near_its_goal_or_below_is_not_reported(force):
    assert reported((force, UP), (force, DOWN), speed=0.0) == ()


def test_short_delay_is_not_reported():
    assert reported((8.0, UP), (12.0, DOWN), speed=0.0, seconds=0.9 * PATIENCE) == ()
    monitor = ReliefMonitor()
    reported((8.0, UP), (12.0, DOWN), speed=0.0, seconds=0.9 * PATIENCE, monitor=monitor)
    reported((GOAL, UP), (GOAL, DOWN), speed=0.0, seconds=TICK, monitor=monitor)
    assert reported((8.0, UP), (12.0, DOWN), speed=0.0, seconds=0.9 * PATIENCE, monitor=monitor) == ()


def test_unselected_contact_is_reported_until_it_is_near_its_goal():
    monitor = ReliefMonitor()
    reported((GOAL, UP), (12.0, DOWN), speed=0.0, monitor=monitor)
    for force, kinds in ((12.0, 1), (4.0, 1), (1.05 * GOAL, 0), (12.0, 0)):
        limits = ActiveLimits()
        monitor.look([controlled(2, force, DOWN, left_out=True)], np.zeros(1), np.ones(1), GAIN, TICK, limits)
        assert len(limits.found) == kinds


def test_single_contact_is_not_reported_as_opposed():
    assert reported((8.0, UP), speed=0.0) == ()


def test_single_contact_that_joints_move_too_slowly_is_reported():
    limit = Limit(LimitKind.CONTACT_IMMOBILE, ("link 1",), value=8.0, bound=GOAL)
    assert reported((8.0, 0 * UP), speed=0.0) == (limit,)
    assert reported((8.0, 0 * UP), (GOAL, UP), speed=0.0) == (limit,)


def test_at_most_the_largest_speed_is_expected():
    assert reported((1000.0, UP), (GOAL, DOWN), speed=-0.6 * MAX_POINT_SPEED) == ()
    assert reported((1000.0, UP), (GOAL, DOWN), speed=-0.4 * MAX_POINT_SPEED) != ()
