"""Events from frames of regions: each symbol once, in order, with its place, force and duration."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.course import EventRule
from app.contacts.events import KEPT, EventReader
from tests.unit.contacts.regions_by_hand import region

TICK = 0.01


def told(frames, *, reader=None):
    """(phase, kind, contacts) of everything that regions frame by frame mean; the events too."""
    reader, found = reader or EventReader(), []
    for tick, regions in enumerate(frames):
        found += reader.read(tick, tick * TICK, regions)
    return [(event.phase, event.kind, event.contacts) for event in found], found


def held(count, **said):
    return [(region(1, **said),)] * count


def moving(count, step):
    return [(region(1, point=np.array([step * k, 0, 0])),) for k in range(count)]


def test_nothing_means_nothing():
    reader = EventReader()
    assert told([()] * 5, reader=reader)[0] == []
    assert reader.recent == ()


def test_a_short_contact_is_a_tap():
    words, events = told([*held(10, force=3.0), ()])
    assert words == [("began", "touch", (1,)), ("ended", "tap", (1,)), ("ended", "release", (1,))]
    assert events[1].duration == pytest.approx(0.1)
    assert events[1].force == 3.0


def test_a_lasting_contact_is_a_press_with_its_greatest_force():
    frames = [*held(10, force=3.0), *held(5, force=8.0), *held(50, force=2.0), ()]
    words, events = told(frames)
    assert [word[:2] for word in words] == [
        ("began", "touch"), ("began", "press"), ("ended", "press"), ("ended", "release"),
    ]  # fmt: skip
    assert events[1].time == pytest.approx(0.25)
    assert events[2].duration == pytest.approx(0.65), "it began with the touch"
    assert events[2].force == 8.0
    assert events[3].force == 8.0


def test_a_contact_that_travels_is_a_stroke_from_there_to_here():
    words, events = told([*moving(60, 0.001), ()])
    assert [word[:2] for word in words] == [
        ("began", "touch"), ("began", "stroke"), ("ended", "stroke"), ("ended", "release"),
    ]  # fmt: skip
    assert events[2].travelled == pytest.approx(0.059)
    assert events[2].duration == pytest.approx(0.60)
    assert events[2].to is not None


def test_there_and_back_again_is_a_way():
    """Farther than from where it began to where it ended, which is nothing."""
    out = [0.001 * k for k in range(50)]
    frames = [(region(1, point=np.array([x, 0, 0])),) for x in (*out, *out[::-1])]
    events = told([*frames, ()])[1]
    stroke = next(event for event in events if event.kind == "stroke" and event.phase == "ended")
    assert stroke.travelled > 0.08


def test_a_stroke_that_rests_is_a_press_again():
    last = moving(60, 0.001)[-1]
    words, events = told([*held(50), *moving(60, 0.001), *[last] * 100, ()])
    assert [word[:2] for word in words] == [
        ("began", "touch"), ("began", "press"), ("ended", "press"), ("began", "stroke"), ("ended", "stroke"),
        ("began", "press"), ("ended", "press"), ("ended", "release"),
    ]  # fmt: skip
    assert events[-1].duration == pytest.approx(2.1), "the release counts from the touch"


def test_a_centre_that_trembles_does_not_travel():
    random = np.random.default_rng(0)
    frames = [(region(1, point=random.normal(0, 0.004, 3), place_error=0.02),) for _ in range(300)]
    assert not [word for word in told(frames)[0] if word[1] == "stroke"]


def test_two_that_become_one_are_told_as_such():
    both = (region(1), region(2))
    words, _ = told([*[both] * 40, (region(1, merged=(2,)),), (region(1),), ()])
    assert ("began", "merge", (1, 2)) in words
    assert ("ended", "press", (2,)) in words
    assert [word for word in words if word[1] == "release"] == [("ended", "release", (1,))], "nothing let go of 2"


def test_a_tap_that_is_swallowed_was_none():
    words, _ = told([(region(1), region(2)), (region(1, merged=(2,)),)])
    assert [word[1] for word in words] == ["touch", "touch", "merge"]


def test_a_merging_centre_jumps_and_that_is_no_stroke():
    frames = [*held(40), (region(1, merged=(2,), point=np.array([0.05, 0, 0])),)]
    frames += [(region(1, point=np.array([0.05, 0, 0])),)] * 40
    assert not [word for word in told(frames)[0] if word[1] == "stroke"]


def test_one_that_becomes_two_is_told_as_such():
    words, _ = told([*held(5), (region(1), region(2, split_from=1))])
    assert words[-1] == ("began", "split", (2, 1))


def test_a_link_held_from_two_sides_is_grasped():
    below = region(2, normal=np.array([0.0, 0.0, -1.0]), force=3.0)
    words, events = told([*held(5), *[(region(1, force=5.0), below)] * 50, *held(5)])
    assert ("began", "grasp", (1, 2)) in words
    end = next(event for event in events if event.kind == "grasp" and event.phase == "ended")
    assert end.force == 3.0, "no hold is stronger than its weaker side"
    assert end.duration == pytest.approx(0.5)


def test_two_on_one_side_hold_nothing():
    assert not [word for word in told([(region(1), region(2))] * 50)[0] if word[1] == "grasp"]


def test_the_strongest_hold_of_a_link_is_the_grasp():
    down = np.array([0.0, 0.0, -1.0])
    frame = (region(1), region(2, normal=down, force=0.5), region(3, normal=down, force=4.0))
    assert told([frame])[0][-1] == ("began", "grasp", (1, 3))


def test_self_touch_is_told_once_for_both_sides():
    frame = (region(1, partner=2), region(2, link="hand", partner=1))
    words, events = told([frame, frame, ()])
    assert [word for word in words if word[1] == "self-touch"] == [
        ("began", "self-touch", (1, 2)), ("ended", "self-touch", (1, 2)),
    ]  # fmt: skip
    assert events[-1].links == ("forearm", "hand")


def test_a_partner_that_is_not_there_is_no_self_touch():
    assert not [word for word in told([(region(1, partner=9),)])[0] if word[1] == "self-touch"]


def test_recent_is_newest_first_and_bounded():
    reader = EventReader()
    _, events = told([held(1)[0], ()] * 60, reader=reader)
    assert len(events) == 180
    assert reader.recent == tuple(events[::-1][:KEPT])
    before = reader.recent
    reader.read(1000, 10.0, ())
    assert reader.recent is before
    reader.reset()
    assert reader.recent == ()


def test_the_rule_is_in_ones_hands():
    words, _ = told([*held(10), ()], reader=EventReader(rule=EventRule(tap=0.05)))
    assert [word[1] for word in words] == ["touch", "press", "press", "release"]
