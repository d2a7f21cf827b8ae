"""Ids of contacts through motion, merging, splitting and short absence."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.detection.regions import TaxelGraph, TaxelGroup
from tactile_maps.contacts.detection.tracking import (
    DWELL,
    GAP,
    PARTED,
    SPEED,
    ContactMotions,
    Measured,
    RegionTracker,
    TrackId,
    TrackMemory,
)
from tests.support.sensors import row
from tests.support.touch import arm, bar_skin

SKIN = bar_skin(400)
BODY = SKIN.positions
MEMORY_GRAPH = TaxelGraph(SKIN)
PITCH = float(np.sqrt(np.median(SKIN.areas)))


def around(x: float, radius: float) -> TaxelGroup:
    """The taxels within ``radius`` of a place on the middle line, or the nearest, with their ring."""
    away = np.hypot(BODY[:, 0] - x, BODY[:, 1])
    (group,) = MEMORY_GRAPH.groups(np.flatnonzero(away <= max(radius, away.min())).tolist())
    return group


WIDE = around(0.2, 1.5 * PITCH)
LONE = around(0.2, 0.0)


def lost(group: TaxelGroup, *, period: float = 0.0, gaps: bool = True) -> TrackMemory:
    """Contact 7 was lost at the time 1."""
    made = TrackMemory(SKIN, BODY)
    made.waits = True
    made.period = period
    made.gaps = gaps
    made.lose(7, group, 1.0)
    return made


def test_lost_contacts_are_dropped_immediately_by_default():
    unasked = TrackMemory(SKIN, BODY)
    unasked.lose(7, WIDE, 1.0)
    assert not unasked.may_return(1.0)
    assert unasked.find(WIDE, 1.0) is None


def test_lost_wide_contact_is_kept_briefly():
    assert len(WIDE.core) > 2
    assert lost(WIDE).may_return(1.0 + 0.99 * DWELL) == {7: "bar"}
    assert not lost(WIDE).may_return(1.0 + DWELL)
    assert lost(WIDE).find(WIDE, 1.0 + 0.99 * DWELL) == 7
    assert lost(WIDE).find(WIDE, 1.0 + DWELL) is None


def test_narrow_one_may_cross_a_gap():
    nearby = around(0.2 + 2 * PITCH, 0.0)
    assert not LONE.core & nearby.core
    assert lost(LONE).find(nearby, 1.0 + 0.9 * GAP) == 7
    assert lost(LONE).find(nearby, 1.0 + GAP) is None
    assert lost(LONE).may_return(1.0 + 0.9 * GAP)
    assert not lost(LONE, gaps=False).may_return(1.0 + DWELL), "the skin has no gap"


def test_new_contact_at_the_same_place_is_another_tap():
    assert lost(LONE).find(LONE, 1.0 + 0.9 * DWELL) == 7, "no finger taps so fast"
    again = lost(LONE)
    assert again.find(LONE, 1.0 + 1.1 * DWELL) is None
    assert not again.may_return(1.0 + 1.1 * DWELL), "the first was let go"


def test_contact_of_a_slow_skin_is_kept_for_one_missed_sample():
    period = 0.2
    assert lost(WIDE, period=period).find(WIDE, 1.0 + 1.4 * period) == 7
    assert lost(WIDE, period=period).find(WIDE, 1.0 + 1.6 * period) is None


@pytest.mark.parametrize("waited", [0.02, 0.2])
def test_contact_is_recovered_only_within_the_reach_of_a_finger(waited):
    reached = max(BODY[sorted(LONE.core | LONE.ring), 0]) + SPEED * waited
    near = around(reached - 0.5 * PITCH, 0.0)
    far = around(reached + 1.5 * PITCH, 0.0)
    assert lost(LONE).find(near, 1.0 + waited) == 7
    assert lost(LONE).find(far, 1.0 + waited) is None


def test_nearest_lost_contact_returns_and_only_once():
    both = lost(LONE)
    both.lose(8, around(0.2 + 4 * PITCH, 0.0), 1.0)
    back = around(0.2 + 5 * PITCH, 0.0)
    assert both.find(back, 1.2) == 8
    assert both.find(back, 1.2) == 7
    assert both.find(back, 1.2) is None


def test_contact_on_another_link_is_new():
    skin = arm().skin
    graph = TaxelGraph(skin)
    body = skin.positions
    first, other = (graph.groups([int(skin.first[patch])])[0] for patch in (0, 1))
    assert skin.patches[0].link != skin.patches[1].link
    made = TrackMemory(skin, np.zeros_like(body))  # all in one place, each in its own link's frame
    made.waits = True
    made.lose(3, first, 0.0)
    assert made.find(other, 0.01) is None
    assert made.find(first, 0.01) == 3


GRAPH = TaxelGraph(row(40))


@pytest.mark.parametrize(
    ("frames", "expected"),
    [
        ([{3, 4}, {3, 4}, {4, 5}], [TrackId(1)]),
        ([{3, 4, 20}, {20, 3}], [TrackId(1), TrackId(2)]),
        ([{3}, {4}, {5}, {6}], [TrackId(1)]),  # moves by its own size
        ([{3}, {5}, {7}], [TrackId(1)]),  # skips a taxel
        ([{3}, {6}], [TrackId(2)]),  # jumps farther
        (
            [{3}, {3, 8, 9, 10, 11}, set(range(3, 12))],
            [TrackId(1, merged=(2,))],
        ),  # the older keeps its id, however small
        ([{3}, {3, 8, 9, 10, 11}, set(range(3, 12)), set(range(3, 12))], [TrackId(1)]),  # merged once
        ([{3, 4, 5, 6, 7}, {3, 5, 6, 7}], [TrackId(2, split_from=1), TrackId(1)]),  # the larger part keeps the id
        ([{3, 4, 5, 6, 7}, {3, 5, 6, 7}, {3, 5, 6, 7}], [TrackId(2), TrackId(1)]),  # split once
        ([{3, 4, 5}, {3, 5}], [TrackId(1), TrackId(2, split_from=1)]),  # of equal parts the first
        ([{3}, {3, 5}], [TrackId(1), TrackId(2)]),  # a new contact in the ring of another
        ([{10, 30}, {8, 10}], [TrackId(3), TrackId(1)]),  # also while a third one ends
        ([{3}, set(), {3}], [TrackId(2)]),  # ids are never used twice
        (
            [{3, 4, 5, 6, 12, 13}, {5, 6, 7, 8, 9, 10, 11, 12, 13, 3}],
            [TrackId(3, split_from=1), TrackId(1, merged=(2,))],
        ),
    ],
)
def test_ids_follow_the_touched_taxels(frames, expected):
    tracker = RegionTracker()
    for frame in frames:
        found = tracker.assign(GRAPH.groups(sorted(frame)))
    assert found == expected
    tracker.reset()
    assert tracker.assign(GRAPH.groups([30])) == [TrackId(1)]


def place(x: float, force: float = 1.0) -> Measured:
    return Measured(np.array([x, 0.0, 0.0]), force)


class Walk:
    """Contacts on a row of taxels a millimetre apart; the time of each frame is a hundredth of a second."""

    def __init__(self) -> None:
        self.tracker = RegionTracker()
        self.now = 0.0

    def frame(self, *touched: set[int], forces: tuple[float, ...] = ()) -> list[TrackId]:
        """Names of the groups ``touched``, which press with ``forces``, 1 N each by default."""
        forces = forces or (1.0,) * len(touched)
        own = {min(group): force for group, force in zip(touched, forces, strict=True)}

        def measure(groups):
            return [place(1e-3 * float(np.mean(sorted(g.core))), own[min(g.core)]) for g in groups]

        self.now += 0.01
        groups = GRAPH.groups(sorted(set().union(*touched)))
        found = self.tracker.assign(groups, now=self.now, measure=measure)
        self.tracker.motions.observe(self.now, [(n.id, m) for n, m in zip(found, measure(groups), strict=True)])
        return found

    def meeting(self, *, forces: tuple[float, ...] = ()) -> None:
        """Contact 1 comes from the left and 2 from the right, a taxel a frame; then they are one."""
        for step in range(5):
            self.frame({5 + step, 6 + step}, {20 - step, 21 - step}, forces=forces)
        assert self.frame(set(range(11, 16)), forces=(sum(forces or (2.0,)),)) == [TrackId(1, merged=(2,))]


def test_contacts_that_cross_swap_their_places():
    walk = Walk()
    walk.meeting()
    for _ in range(4):
        assert walk.frame(set(range(11, 16))) == [TrackId(1)]
    assert walk.frame({10, 11}, {15, 16}) == [TrackId(2, split_from=1), TrackId(1)]
    assert walk.frame({9, 10}, {16, 17}) == [TrackId(2), TrackId(1)]


@pytest.mark.parametrize("forces", [(1.0, 1.3), (1.3, 1.0)])
def test_contacts_of_different_force_that_turn_back_keep_their_places(forces):
    walk = Walk()
    walk.meeting(forces=forces)
    for _ in range(10):
        walk.frame(set(range(11, 16)), forces=(2.3,))
    assert [name.id for name in walk.frame({10, 11}, {15, 16}, forces=forces)] == [1, 2]


def test_contacts_that_separate_quickly_keep_their_sides():
    walk = Walk()
    walk.meeting()
    assert [name.id for name in walk.frame({10, 11}, {15, 16})] == [1, 2]


def test_contacts_that_merge_again_immediately_are_predicted_from_the_first_merge():
    walk = Walk()
    walk.meeting()
    assert [name.id for name in walk.frame({10, 11}, {15, 16})] == [1, 2]
    for _ in range(5):
        walk.frame(set(range(11, 16)))
    assert [name.id for name in walk.frame({10, 11}, {15, 16})] == [2, 1], "meanwhile they crossed"


def test_contacts_that_separate_late_are_not_identified():
    walk = Walk()
    walk.meeting()
    walk.now += PARTED
    assert walk.frame({10, 11}, {14, 15, 16}) == [TrackId(3, split_from=1), TrackId(1)]


def test_third_part_split_from_two_contacts_is_new():
    walk = Walk()
    walk.meeting()
    assert [name.id for name in walk.frame({10, 11}, {13}, {15, 16})] == [1, 3, 2]


def test_three_contacts_of_which_one_separates_first_keep_their_ids():
    motions = ContactMotions()
    for step in range(5):
        now = 0.01 * step
        motions.observe(now, [(1, place(0.01 + 0.001 * step)), (2, place(0.02)), (3, place(0.03, 2.0))])
    motions.keep({1: frozenset((1, 2, 3))})
    assert motions.inside(1, 0.1) == {1, 2, 3}
    assert motions.inside(7, 0.1) == {7}
    assert motions.assigned(1, [place(0.03, 2.0), place(0.017, 2.0)], 0.05) == [{3}, {1, 2}]
    motions.reset()
    assert motions.inside(1, 0.1) == {1}


def test_too_many_contacts_are_not_compared():
    motions = ContactMotions()
    motions.observe(0.0, [(number, place(0.01 * number)) for number in range(1, 12)])
    motions.keep({1: frozenset(range(1, 12))})
    assert motions.assigned(1, [place(0.0), place(0.1)], 0.1) is None
