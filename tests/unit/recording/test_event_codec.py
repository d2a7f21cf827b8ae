"""Contact events in recordings: exact, readable by other programs, and there when a frame is replayed."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from mcap.reader import make_reader

from app.contacts.event import EVENT_KINDS, ContactEvent
from app.errors import RecordingError
from app.geometry.surface_point import SurfacePoint
from app.recording.event_codec import EVENT_SCHEMA, decode_event, encode_event
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.session.session import Session
from app.touch.poke import PokePressed, PokeReleased

AT = SurfacePoint(1, 7, (0.1, 0.2, 0.7))
EVENT = ContactEvent(12, 0.1 + 0.2, "stroke", "ended", (3, 4), ("forearm", "hand"), AT, AT, 1 / 3, 0.7, 0.1)


@pytest.mark.parametrize("kind", EVENT_KINDS)
@pytest.mark.parametrize("to", [None, AT])
def test_an_event_reads_back_equal(kind, to):
    event = replace(EVENT, kind=kind, to=to)
    assert decode_event(encode_event(event)) == event


def test_a_message_has_all_that_the_schema_promises():
    said, schema = json.loads(encode_event(EVENT)), json.loads(EVENT_SCHEMA)
    assert set(said) == set(schema["required"]) == set(schema["properties"])
    assert said["words"] == EVENT.words
    assert said["at"] == {"patch": 1, "face": 7, "weights": [0.1, 0.2, 0.7]}


@pytest.mark.parametrize(
    "data",
    [b"", b"{}", b"[]", b"null", encode_event(EVENT)[:-1], encode_event(EVENT).replace(b"stroke", b"kick")]
    + [encode_event(EVENT).replace(b'"ended"', b'"paused"'), encode_event(EVENT).replace(b"0.7]", b"0.7, 1]")],
)
def test_a_damaged_event_is_refused_by_name(data):
    with pytest.raises(RecordingError, match="contact event of the recording is damaged"):
        decode_event(data)


@pytest.fixture
def frames(prepared, tmp_path):
    """Frames of a session with a press and a release, recorded from the 21st on."""
    session = Session(prepared, scripted=False)
    seen = []
    with Recorder(tmp_path / "events.mcap", prepared) as recorder:
        session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
        for tick in range(300):
            if tick == 150:
                session.submit(PokeReleased(1))
            frame = session.tick()
            if frame.tick > 20:
                recorder.write(frame, session.inputs)
                seen.append(frame)
    assert {event.kind for event in seen[-1].recent} >= {"touch", "press", "release"}
    return seen


def test_a_replayed_frame_knows_its_events(frames, tmp_path):
    player = Player(tmp_path / "events.mcap")
    assert player.events == list(frames[-1].recent[::-1]), "those before the recording began as well"
    for number in (0, 50, 150, len(player) - 1):
        assert player.frame(number).recent == frames[number].recent
        assert player.frame(number).events == frames[number].events


def test_other_programs_read_the_channel(frames, tmp_path):
    with (tmp_path / "events.mcap").open("rb") as stream:
        found = [
            (schema.name, channel.message_encoding, json.loads(message.data)["words"])
            for schema, channel, message in make_reader(stream).iter_messages(topics=["/event"])
        ]
    assert {item[:2] for item in found} == {("tactile_maps.ContactEvent", "json")}
    assert [item[2] for item in found] == [event.words for event in frames[-1].recent[::-1]]
