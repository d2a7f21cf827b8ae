"""Contact events as words."""

from __future__ import annotations

import pytest

from app.contacts.event import EVENT_KINDS, ContactEvent
from app.geometry.surface_point import SurfacePoint

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
        ("merge", "began", ["forearm"], "two contacts become one on forearm"),
        ("split", "began", ["forearm"], "one contact becomes two on forearm"),
        ("self-touch", "began", ["left_hand", "right_forearm"], "left hand touches right forearm, 4.2 N"),
    ],
)
def test_each_kind_reads_well(kind, phase, links, words):
    assert kind in EVENT_KINDS
    assert event(kind, phase, *links).words.replace("\u2009", " ") == words
