"""Names of regions through motion, merging and splitting, on a row of taxels."""

from __future__ import annotations

from app.contacts.follow import Follower, Name
from app.contacts.graph import SkinGraph
from tests.sensors import row

GRAPH = SkinGraph(row(40))


def names(*frames):
    """What a new follower calls the groups of each frame's touched taxels."""
    follower = Follower()
    return [follower.name(GRAPH.groups(sorted(frame))) for frame in frames]


def test_what_stays_keeps_its_name():
    assert names({3, 4}, {3, 4}, {4, 5})[-1] == [Name(1)]


def test_two_are_told_apart_and_keep_their_names_in_any_order():
    first, second = names({3, 4, 20}, {20, 3})
    assert [name.id for name in first] == [1, 2]
    assert [name.id for name in second] == [1, 2]


def test_a_contact_that_moves_by_its_own_size_keeps_its_name():
    assert names({3}, {4}, {5}, {6})[-1] == [Name(1)]


def test_one_that_skips_a_taxel_keeps_its_name():
    assert names({3}, {5}, {7})[-1] == [Name(1)]


def test_one_that_jumps_farther_is_new():
    assert names({3}, {6})[-1] == [Name(2)]


def test_when_two_merge_the_older_keeps_its_name_however_small():
    frames = names({3}, {3, 8, 9, 10, 11}, {3, 4, 5, 6, 7, 8, 9, 10, 11}, {3, 4, 5, 6, 7, 8, 9, 10, 11})
    assert frames[2] == [Name(1, merged=(2,))]
    assert frames[3] == [Name(1)], "told once"


def test_when_one_splits_the_larger_part_keeps_its_name():
    frames = names({3, 4, 5, 6, 7}, {3, 5, 6, 7}, {3, 5, 6, 7})
    assert frames[1] == [Name(2, split_from=1), Name(1)]
    assert frames[2] == [Name(2), Name(1)]


def test_equal_parts_go_by_the_smaller_taxel():
    assert names({3, 4, 5}, {3, 5})[1] == [Name(1), Name(2, split_from=1)]


def test_a_touch_beside_a_contact_is_new_and_takes_nothing():
    """It stands in the other's ring, which stays where it is."""
    assert names({3}, {3, 5})[-1] == [Name(1), Name(2)]
    assert names({3}, {3, 5, 6, 7})[-1] == [Name(1), Name(2)]


def test_not_even_while_another_goes():
    assert names({10, 30}, {8, 10})[-1] == [Name(3), Name(1)]


def test_a_name_is_never_given_twice():
    assert names({3}, set(), {3})[-1] == [Name(2)]


def test_reset_begins_at_one():
    follower = Follower()
    follower.name(GRAPH.groups([3]))
    follower.reset()
    assert follower.name(GRAPH.groups([30])) == [Name(1)]


def test_one_that_merges_while_another_splits_off():
    merged, split = names({3, 4, 5, 6, 12, 13}, {5, 6, 7, 8, 9, 10, 11, 12, 13, 3})[-1][::-1]
    assert merged == Name(1, merged=(2,))
    assert split == Name(3, split_from=1)
