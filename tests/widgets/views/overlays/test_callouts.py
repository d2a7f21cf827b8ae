"""Callouts are placed near their contacts without overlaps, and have a leader line if they are far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QLineF, QPointF, QRectF, QSizeF
from PySide6.QtGui import QPolygonF

from tactile_widgets.views.overlays.callouts import Spot, place_callouts

ROOM = QRectF(0, 0, 500, 400)
WORDS = QSizeF(52, 22)


@pytest.mark.parametrize("seed", range(4))
def test_callouts_cover_no_place_and_no_other_callout(seed):
    rng = np.random.default_rng(seed)
    spots = [Spot(QPointF(*at), 16.0, WORDS) for at in rng.uniform((60, 60), (440, 340), (7, 2)).tolist()]
    boxes = [callout.box for callout in place_callouts(spots, ROOM)]
    assert all(ROOM.contains(box) for box in boxes)
    assert not any(box.intersects(spot.box) for box in boxes for spot in spots)
    assert not any(one.intersects(other) for k, one in enumerate(boxes) for other in boxes[:k])


def test_distant_callout_has_a_leader_line():
    crowd = [Spot(QPointF(250 + 34 * dx, 200 + 34 * dy), 16.0, WORDS) for dx in (0, -1, 1) for dy in (0, -1, 1)]
    middle = place_callouts(crowd, ROOM)[0]
    assert middle.leader is not None
    start, end = middle.leader
    assert np.hypot(start.x() - 250, start.y() - 200) == pytest.approx(16.0), "from its rim"
    assert middle.box.adjusted(-0.1, -0.1, 0.1, 0.1).contains(end)


def test_adjacent_caption_has_no_leader():
    (alone,) = place_callouts([Spot(QPointF(250, 200), 10.0, WORDS)], ROOM)
    assert alone.leader is None


def test_preferred_position_is_used_unless_it_hides_a_place():
    preferred = QRectF(300, 180, 52, 22)
    spot = Spot(QPointF(250, 200), 10.0, WORDS, preferred)
    assert place_callouts([spot], ROOM)[0].box == preferred
    other = Spot(QPointF(320, 190), 10.0, WORDS)
    assert not place_callouts([spot, other], ROOM)[0].box.intersects(other.box)


def test_caption_is_placed_next_to_a_small_patch_not_on_it():
    spot = Spot(QPointF(250, 200), 10.0, WORDS)
    patch = QRectF(200, 150, 100, 90)
    assert place_callouts([spot], ROOM)[0].box.intersects(patch)
    (callout,) = place_callouts([spot], ROOM, kept=[patch])
    assert not callout.box.intersects(patch)
    assert callout.leader is not None
    (crowded,) = place_callouts([spot], ROOM, kept=[ROOM])
    assert ROOM.contains(crowded.box)


@pytest.mark.parametrize("seed", range(4))
def test_leader_lines_cross_no_caption_and_no_contact_if_there_is_room(seed):
    rng = np.random.default_rng(seed)
    patch = QRectF(210, 170, 90, 60)
    names = [QRectF(215, 150, 80, 17), QRectF(*rng.uniform((10, 10), (90, 330)).tolist(), 70, 17)]
    spots = [Spot(QPointF(*at), 9.0, WORDS) for at in rng.uniform((225, 180), (285, 195), (2, 2)).tolist()]
    callouts = place_callouts(spots, ROOM, others=names, kept=[patch])
    lines = [callout.leader for callout in callouts if callout.leader is not None]
    assert lines, "the captions are next to the small patch"
    for number, callout in enumerate(callouts):
        if callout.leader is None:
            continue
        along = [callout.leader[0] + k / 200 * (callout.leader[1] - callout.leader[0]) for k in range(201)]
        others = [spot.box for k, spot in enumerate(spots) if k != number]
        boxes = [one.box for k, one in enumerate(callouts) if k != number]
        assert not any(box.contains(point) for box in (*names, *others, *boxes) for point in along)


@pytest.mark.parametrize("seed", [3, 30, 42])
def test_leader_lines_do_not_cross_each_other_where_there_is_room(seed):
    rng = np.random.default_rng(seed)
    spots = [Spot(QPointF(*at), 9.0, WORDS) for at in rng.uniform((200, 150), (300, 250), (3, 2)).tolist()]
    callouts = place_callouts(spots, ROOM, kept=[QRectF(180, 130, 140, 140)])
    lines = [QLineF(*callout.leader) for callout in callouts if callout.leader is not None]
    assert len(lines) > 1
    for number, line in enumerate(lines):
        for other in lines[:number]:
            assert line.intersects(other)[0] != QLineF.IntersectionType.BoundedIntersection


def test_caption_is_over_no_foreign_box_if_there_is_room():
    spot = Spot(QPointF(250, 200), 10.0, WORDS)
    other = QRectF(275, 100, 100, 200)
    assert place_callouts([spot], ROOM)[0].box.intersects(other)
    (callout,) = place_callouts([replace(spot, foreign=(QPolygonF(other),))], ROOM)
    assert not callout.box.intersects(other)
    (crowded,) = place_callouts([replace(spot, foreign=(QPolygonF(ROOM),))], ROOM)
    assert ROOM.contains(crowded.box)
