"""Who is gone may come back: soon, and near."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.graph import Group, SkinGraph
from app.contacts.lost import DWELL, GAP, SPEED, Lost
from app.contacts.place import body_of
from tests.touch import arm, bar_skin

SKIN = bar_skin(400)
BODY, GRAPH = body_of(SKIN), SkinGraph(SKIN)
PITCH = float(np.sqrt(np.median(SKIN.areas)))


def around(x: float, radius: float) -> Group:
    """The taxels within ``radius`` of a place on the middle line, or the nearest, with their ring."""
    away = np.hypot(BODY[:, 0] - x, BODY[:, 1])
    (group,) = GRAPH.groups(np.flatnonzero(away <= max(radius, away.min())).tolist())
    return group


WIDE, LONE = around(0.2, 1.5 * PITCH), around(0.2, 0.0)


def lost(group: Group, *, period: float = 0.0, gaps: bool = True) -> Lost:
    """Contact 7 was lost at the time 1."""
    made = Lost(SKIN, BODY)
    made.waits, made.period, made.gaps = True, period, gaps
    made.lose(7, group, 1.0)
    return made


def test_nobody_waits_unless_asked_to():
    unasked = Lost(SKIN, BODY)
    unasked.lose(7, WIDE, 1.0)
    assert not unasked.may_return(1.0)
    assert unasked.find(WIDE, 1.0) == 0


def test_a_wide_contact_is_awaited_briefly():
    assert len(WIDE.core) > 2
    assert lost(WIDE).may_return(1.0 + 0.99 * DWELL) == {7: "bar"}
    assert not lost(WIDE).may_return(1.0 + DWELL)
    assert lost(WIDE).find(WIDE, 1.0 + 0.99 * DWELL) == 7
    assert lost(WIDE).find(WIDE, 1.0 + DWELL) == 0


def test_a_narrow_one_may_cross_a_gap():
    beside = around(0.2 + 2 * PITCH, 0.0)
    assert not LONE.core & beside.core
    assert lost(LONE).find(beside, 1.0 + 0.9 * GAP) == 7
    assert lost(LONE).find(beside, 1.0 + GAP) == 0
    assert lost(LONE).may_return(1.0 + 0.9 * GAP)
    assert not lost(LONE, gaps=False).may_return(1.0 + DWELL), "there is none to cross"


def test_in_the_same_place_it_is_another_tap():
    assert lost(LONE).find(LONE, 1.0 + 0.9 * DWELL) == 7, "no finger taps so fast"
    again = lost(LONE)
    assert again.find(LONE, 1.0 + 1.1 * DWELL) == 0
    assert not again.may_return(1.0 + 1.1 * DWELL), "the first was let go"


def test_a_slow_skin_may_miss_one_sample():
    period = 0.2
    assert lost(WIDE, period=period).find(WIDE, 1.0 + 1.4 * period) == 7
    assert lost(WIDE, period=period).find(WIDE, 1.0 + 1.6 * period) == 0


@pytest.mark.parametrize("waited", [0.02, 0.2])
def test_nobody_comes_back_from_farther_than_a_hand_moves(waited):
    reached = max(BODY[sorted(LONE.core | LONE.ring), 0]) + SPEED * waited
    near, far = around(reached - 0.5 * PITCH, 0.0), around(reached + 1.5 * PITCH, 0.0)
    assert lost(LONE).find(near, 1.0 + waited) == 7
    assert lost(LONE).find(far, 1.0 + waited) == 0


def test_the_nearest_comes_back_and_only_once():
    both = lost(LONE)
    both.lose(8, around(0.2 + 4 * PITCH, 0.0), 1.0)
    back = around(0.2 + 5 * PITCH, 0.0)
    assert both.find(back, 1.2) == 8
    assert both.find(back, 1.2) == 7
    assert both.find(back, 1.2) == 0


def test_on_another_link_it_is_another():
    skin = arm().skin
    graph, body = SkinGraph(skin), body_of(skin)
    first, other = (graph.groups([int(skin.first[patch])])[0] for patch in (0, 1))
    assert skin.patches[0].link != skin.patches[1].link
    made = Lost(skin, np.zeros_like(body))  # all in one place, each in its own link's frame
    made.waits = True
    made.lose(3, first, 0.0)
    assert made.find(other, 0.01) == 0
    assert made.find(first, 0.01) == 3


def test_a_reset_forgets():
    made = lost(WIDE)
    made.reset()
    assert not made.may_return(1.0)
