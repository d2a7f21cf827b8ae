"""Contact events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.events import (
    EVENT_KINDS,
    RECENT_EVENTS,
    STICKS,
    ContactEvent,
    ContactState,
    EventDetector,
    GraspPairs,
)
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.contacts.regions_by_hand import region

AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))


def event(kind, phase, *links):
    return ContactEvent(5, 0.1, kind, phase, (1,), links, AT, force=4.21, duration=0.82, travelled=0.0624)


@pytest.mark.parametrize(
    ("kind", "phase", "links", "words"),
    [
        ("touch", "began", ["forearm"], "touch on forearm"),
        ("tap", "ended", ["forearm"], "tap on forearm, 4.2 N, 0.8 s"),
        ("press", "began", ["forearm"], "press on forearm, 4.2 N"),
        ("press", "ended", ["right_forearm"], "press on right forearm, 4.2 N, 0.8 s"),
        ("stroke", "ended", ["forearm"], "stroke on forearm, 62 mm, 4.2 N, 0.8 s"),
        ("grasp", "ended", ["forearm"], "grasp of forearm, 4.2 N, 0.8 s"),
        ("release", "ended", ["forearm"], "release on forearm, 4.2 N, 0.8 s"),
        ("merge", "began", ["forearm"], "contacts merged on forearm"),
        ("split", "began", ["forearm"], "contact split on forearm"),
        ("self-touch", "began", ["left_hand", "right_forearm"], "left hand touches right forearm, 4.2 N"),
    ],
)
def test_text_of_each_kind_is_readable(kind, phase, links, words):
    assert kind in EVENT_KINDS
    assert event(kind, phase, *links).words.replace("\u202f", " ") == words


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", range(5))
def test_every_phase_starts_where_the_previous_one_ended(seed):
    random = np.random.default_rng(seed)
    at = np.zeros(3)
    contact = ContactState(0, 0.0, region(1))
    events = []
    for tick in range(1, 2000):
        if tick % 200 == 0:
            pace = random.normal(0, 3e-4, 3) * random.integers(2)
        at = at + (pace if tick >= 200 else 0)
        events += contact.advance(tick, 0.005 * tick, region(1, link_position=at, force=float(random.uniform(1, 5))))
    events += contact.end(2000, 10.0, released=True)
    phases = [event for event in events if event.kind in ("press", "stroke")]
    assert len(phases) > 4
    for began, ended in zip(phases[::2], phases[1::2], strict=True):
        assert (began.phase, ended.phase, began.kind) == ("began", "ended", ended.kind)
        assert began.time <= ended.time
        assert ended.force <= 5.0
    assert events[-1].kind == "release"
    assert events[-1].duration == 10.0


def slips(*states):
    """Return the events of slip in a contact with these usages of friction, for a time each [s], until it is lost."""
    contact = ContactState(0, 0.0, region(1))
    events = []
    tick = 0
    for usage, seconds in states:
        slip = Slip.SLIDING if usage >= 0.95 else Slip.INCIPIENT if usage >= 0.7 else Slip.STICKING
        shear = ContactShear((usage, 0.0, 0.0), 0.0, usage, 1 - usage, slip, 1.0, estimated=False)
        for _ in range(round(seconds / 0.005)):
            tick += 1
            events += contact.advance(tick, 0.005 * tick, replace(region(1), shear=shear))
    events += contact.end(tick + 1, 0.005 * (tick + 1), released=False)
    of_slip = [event for event in events if "slip" in event.kind]
    near = {"abs": 0.006}  # a tick, for times that are not exact
    return [
        (event.kind, event.phase, pytest.approx(event.time, **near), pytest.approx(event.duration, **near))
        for event in of_slip
    ]


def test_slip_ends_once_the_contact_has_stuck_for_a_while():
    flicker = [(1.0, 0.05), (0.8, 0.09), (1.0, 0.05), (0.2, 0.05)] * 3
    assert slips((0.5, 0.1), *flicker, (0.2, 0.5)) == [
        ("slip", "began", 0.105, 0.0),
        ("slip", "ended", 0.77 + STICKS, 0.665),
    ]


def test_slip_continues_while_friction_usage_is_only_slightly_lower():
    assert slips((1.0, 0.1), (0.9, 0.5)) == [("slip", "began", 0.005, 0.0), ("slip", "ended", 0.605, 0.6)]
    assert slips((1.0, 0.1), (0.8, 0.05)) == [("slip", "began", 0.005, 0.0), ("slip", "ended", 0.155, 0.095)]


def test_slip_at_the_border_begins_again_only_after_a_while():
    short = [(0.8, 0.05), (0.5, 0.05)] * 3
    assert slips(*short) == [("incipient-slip", "began", 0.005, 0.0)]
    assert [time for *_, time, _ in slips((0.8, 0.1), (0.5, 0.2), (0.8, 0.1))] == [0.005, 0.305]
    assert [kind for kind, *_ in slips((0.8, 0.1), (1.0, 0.005))] == ["incipient-slip", "slip", "slip"], "at once"


DOWN = np.array([0.0, 0.0, -1.0])


def test_grasp_continues_while_fingers_change():
    pairs = GraspPairs()
    one = region(1)
    other = region(2, link_normal=DOWN)
    third = region(3, link_normal=DOWN)
    assert [event.phase for event in pairs.read(0, 0.0, {1: one, 2: other})] == ["began"]
    assert pairs.read(1, 0.1, {1: one, 2: other, 3: third}) == []
    assert pairs.read(2, 0.2, {1: one, 3: third}) == []
    (end,) = pairs.read(3, 0.3, {1: one})
    assert (end.phase, end.contacts) == ("ended", (1, 3))
    assert end.duration == 0.3


def test_grasp_continues_during_the_brief_loss_of_a_finger():
    pairs = GraspPairs()
    one = region(1)
    other = region(2, link_normal=DOWN)
    pairs.read(0, 0.0, {1: one, 2: other})
    assert pairs.read(1, 0.1, {1: one}, awaited={2}) == []
    assert pairs.read(2, 0.2, {1: one, 2: other}) == []
    assert pairs.read(3, 0.3, {1: one}, awaited={2}) == []
    (end,) = pairs.read(4, 0.4, {1: one})
    assert (end.phase, end.time) == ("ended", 0.4)
    assert end.duration == 0.3, "until it was gone"


TICK = 0.01


def reported(frames, *, detector=None):
    """(phase, kind, contacts) of everything that regions frame by frame mean; the events too."""
    detector = detector or EventDetector()
    found = []
    for tick, regions in enumerate(frames):
        found += detector.read(tick, tick * TICK, regions)
    return [(event.phase, event.kind, event.contacts) for event in found], found


def held(count, **said):
    return [(region(1, **said),)] * count


def moving(count, step):
    return [(region(1, link_position=np.array([step * k, 0, 0])),) for k in range(count)]


def test_short_contact_is_a_tap():
    words, events = reported([*held(10, force=3.0), ()])
    assert words == [("began", "touch", (1,)), ("ended", "tap", (1,)), ("ended", "release", (1,))]
    assert events[1].duration == pytest.approx(0.1)
    assert events[1].force == 3.0


def test_lasting_contact_is_a_press_with_its_greatest_force():
    frames = [*held(10, force=3.0), *held(5, force=8.0), *held(50, force=2.0), ()]
    words, events = reported(frames)
    assert [word[:2] for word in words] == [
        ("began", "touch"),
        ("began", "press"),
        ("ended", "press"),
        ("ended", "release"),
    ]
    assert events[1].time == pytest.approx(0.25)
    assert events[2].duration == pytest.approx(0.65), "it began with the touch"
    assert events[2].force == 8.0
    assert events[3].force == 8.0


def test_moving_contact_is_a_stroke_from_its_start_to_its_position():
    words, events = reported([*moving(60, 0.001), ()])
    assert [word[:2] for word in words] == [
        ("began", "touch"),
        ("began", "stroke"),
        ("ended", "stroke"),
        ("ended", "release"),
    ]
    assert events[2].travelled == pytest.approx(0.059)
    assert events[2].duration == pytest.approx(0.58), "it counts from the last frame within 2.5 mm of its start"
    assert events[2].to is not None


def test_stroke_that_comes_to_rest_is_a_press_again():
    last = moving(60, 0.001)[-1]
    words, events = reported([*held(50), *moving(60, 0.001), *[last] * 100, ()])
    assert [word[:2] for word in words] == [
        ("began", "touch"),
        ("began", "press"),
        ("ended", "press"),
        ("began", "stroke"),
        ("ended", "stroke"),
        ("began", "press"),
        ("ended", "press"),
        ("ended", "release"),
    ]
    assert events[-1].duration == pytest.approx(2.1), "the release counts from the touch"


@pytest.mark.parametrize("speed", [0.006, 0.01, 0.1])
def test_slow_motion_is_one_stroke(speed):
    words, events = reported([*held(50), *moving(round(0.06 / (speed * TICK)), speed * TICK), ()])
    assert [word[:2] for word in words[1:-1]] == [
        ("began", "press"),
        ("ended", "press"),
        ("began", "stroke"),
        ("ended", "stroke"),
    ]
    assert events[-2].travelled == pytest.approx(0.06, abs=0.001)


def test_stroke_counts_from_the_time_at_which_it_left_its_start():
    _, events = reported([*held(200), *moving(60, 0.001), ()])
    (stroke,) = (event for event in events if (event.kind, event.phase) == ("stroke", "ended"))
    assert stroke.duration == pytest.approx(0.6, abs=0.03)


def test_trembling_centre_is_not_a_stroke():
    random = np.random.default_rng(0)
    frames = [(region(1, link_position=random.normal(0, 0.004, 3), place_error=0.02),) for _ in range(300)]
    assert not [word for word in reported(frames)[0] if word[1] == "stroke"]


def test_merge_of_two_contacts_is_an_event():
    both = (region(1), region(2))
    words, _ = reported([*[both] * 40, (region(1, merged=(2,)),), (region(1),), ()])
    assert ("began", "merge", (1, 2)) in words
    assert ("ended", "press", (2,)) in words
    assert [word for word in words if word[1] == "release"] == [("ended", "release", (1,))], "nothing let go of 2"


def test_jump_of_a_merging_centre_is_not_a_stroke():
    frames = [*held(40), (region(1, merged=(2,), link_position=np.array([0.05, 0, 0])),)]
    frames += [(region(1, link_position=np.array([0.05, 0, 0])),)] * 40
    assert not [word for word in reported(frames)[0] if word[1] == "stroke"]


def test_split_of_a_contact_is_an_event():
    words, _ = reported([*held(5), (region(1), region(2, split_from=1))])
    assert words[-1] == ("began", "split", (2, 1))


def test_link_held_from_two_sides_is_grasped():
    below = region(2, link_normal=np.array([0.0, 0.0, -1.0]), force=3.0)
    words, events = reported([*held(5), *[(region(1, force=5.0), below)] * 50, *held(5)])
    assert ("began", "grasp", (1, 2)) in words
    end = next(event for event in events if event.kind == "grasp" and event.phase == "ended")
    assert end.force == 3.0, "no hold is stronger than its weaker side"
    assert end.duration == pytest.approx(0.5)


def test_largest_forces_are_those_since_the_readings_changed_their_unit():
    detector = EventDetector()
    down = np.array([0.0, 0.0, -1.0])

    def read(tick, force):
        frame = (region(1, force=force), region(2, link_normal=down, force=force)) if force else ()
        return detector.read(tick, 0.01 * tick, frame)

    for tick in range(40):
        read(tick, 50.0)
    detector.forget_forces()
    read(40, 3.0)
    ended = read(41, 0.0)
    assert {event.kind for event in ended} == {"press", "release", "grasp"}
    assert {event.force for event in ended} == {3.0}


def test_strongest_opposing_contacts_of_a_link_are_the_grasp():
    down = np.array([0.0, 0.0, -1.0])
    frame = (region(1), region(2, link_normal=down, force=0.5), region(3, link_normal=down, force=4.0))
    assert reported([frame])[0][-1] == ("began", "grasp", (1, 3))


def test_self_touch_is_one_event_for_both_sides():
    frame = (region(1, partner=2), region(2, link="hand", partner=1))
    words, events = reported([frame, frame, ()])
    assert [word for word in words if word[1] == "self-touch"] == [
        ("began", "self-touch", (1, 2)),
        ("ended", "self-touch", (1, 2)),
    ]
    assert events[-1].links == ("forearm", "hand")


def test_recent_events_are_limited_and_newest_first():
    detector = EventDetector()
    _, events = reported([held(1)[0], ()] * 60, detector=detector)
    assert len(events) == 180
    assert detector.recent == tuple(events[::-1][:RECENT_EVENTS])
    before = detector.recent
    detector.read(1000, 10.0, ())
    assert detector.recent is before
    detector.reset()
    assert detector.recent == ()
