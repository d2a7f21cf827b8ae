"""Pairs of regions that are the two sides of one contact."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.self_touch import SelfTouchMatcher
from tactile_maps.geometry.surface.pose import Pose
from tests.contacts.regions_by_hand import region

DOWN = np.array([0.0, 0.0, -1.0])


def pose(link: str) -> Pose:
    """Return the pose of a link; the hand is at x = 1 m in the world."""
    return Pose(np.eye(3), np.array([1.0, 0, 0]) if link == "hand" else np.zeros(3))


def pair(**said):
    """A forearm's region and a hand's that meets it."""
    return region(1), region(
        2, **({"link": "hand", "link_position": np.array([-1.0, 0, 0]), "link_normal": DOWN} | said)
    )


def partners(regions, *, touch=None) -> list[int]:
    return [found.partner for found in (touch or SelfTouchMatcher()).link(regions, pose)]


def test_facing_regions_with_equal_force_are_linked():
    assert partners(pair()) == [2, 1]
    assert partners(pair()[::-1]) == [1, 2], "in the order they came"


@pytest.mark.parametrize(
    "said",
    [
        {"link_position": np.array([-0.99, 0, 0])},
        {"link_normal": -DOWN},
        {"force": 1.5},
        {"link": "forearm", "link_position": np.zeros(3)},
    ],
    ids=["apart", "facing alike", "of other force", "of one link"],
)
def test_other_pairs_are_not_linked(said):
    assert partners(pair(**said)) == [None, None]


def test_partners_with_uncertain_centres_may_be_farther_apart():
    assert partners(pair(link_position=np.array([-0.99, 0, 0]), place_error=0.01)) == [2, 1]


def test_uncertain_forces_may_differ():
    assert partners(pair(force=1.5, force_error=0.2)) == [2, 1]


def test_pair_is_kept_while_another_body_presses_one_side():
    touch = SelfTouchMatcher()
    assert partners(pair(), touch=touch) == [2, 1]
    assert partners(pair(force=1.5), touch=touch) == [2, 1]
    assert partners(pair(force=5.0), touch=touch) == [None, None]
    assert partners(pair(force=1.5), touch=touch) == [None, None], "a pair that separated must be matched again"


def test_separated_pair_is_forgotten():
    touch = SelfTouchMatcher()
    partners(pair(), touch=touch)
    assert partners(pair()[:1], touch=touch) == [None]
    assert partners(pair(force=1.5), touch=touch) == [None, None]
    partners(pair(), touch=touch)
    touch.reset()
    assert partners(pair(force=1.5), touch=touch) == [None, None]


def test_closest_of_two_partners_is_chosen():
    one, other = pair()
    third = region(3, link="hand", link_position=np.array([-1.0, 0.003, 0]), link_normal=DOWN)
    assert partners((one, other, third)) == [2, 1, None]
