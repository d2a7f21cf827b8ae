"""Bonds of contacts begin and end once."""

from __future__ import annotations

import numpy as np

from app.contacts.pairs import Pairs
from tests.unit.contacts.regions_by_hand import region

DOWN = np.array([0.0, 0.0, -1.0])


def test_a_grasp_goes_on_while_fingers_change():
    pairs = Pairs(-0.5)
    one, other, third = region(1), region(2, normal=DOWN), region(3, normal=DOWN)
    assert [event.phase for event in pairs.read(0, 0.0, {1: one, 2: other})] == ["began"]
    assert pairs.read(1, 0.1, {1: one, 2: other, 3: third}) == []
    assert pairs.read(2, 0.2, {1: one, 3: third}) == []
    (end,) = pairs.read(3, 0.3, {1: one})
    assert (end.phase, end.contacts) == ("ended", (1, 3))
    assert end.duration == 0.3


def test_a_grasp_waits_for_a_finger_that_may_come_back():
    pairs = Pairs(-0.5)
    one, other = region(1), region(2, normal=DOWN)
    pairs.read(0, 0.0, {1: one, 2: other})
    assert pairs.read(1, 0.1, {1: one}, awaited={2}) == []
    assert pairs.read(2, 0.2, {1: one, 2: other}) == []
    assert pairs.read(3, 0.3, {1: one}, awaited={2}) == []
    (end,) = pairs.read(4, 0.4, {1: one})
    assert (end.phase, end.time) == ("ended", 0.4)
    assert end.duration == 0.3, "until it was gone"


def test_links_are_held_on_their_own():
    pairs = Pairs(-0.5)
    regions = [region(1), region(2, normal=DOWN), region(3, link="hand"), region(4, link="hand", normal=DOWN)]
    events = pairs.read(0, 0.0, {found.id: found for found in regions})
    assert [event.links for event in events] == [("forearm",), ("hand",)]


def test_without_two_there_is_nothing_to_tell():
    assert Pairs(-0.5).read(0, 0.0, {1: region(1)}) == []
