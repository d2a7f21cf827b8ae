"""Inputs, effects, events and failures as messages: equal when read back, damage is named; the list of topics."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from typing import get_args, get_type_hints

import pytest
from mcap.reader import make_reader

from app.contacts.events import EVENT_KINDS, ContactEvent
from app.contacts.pipeline import ReadingSettings
from app.control.command import ControlChanged, ControlSettings
from app.core.errors import RecordingError, SimulationError
from app.editing.arrange import move, rotate
from app.editing.document import MapDocument
from app.geometry.mesh import SurfacePoint
from app.recording.message_codecs import (
    EVENT_SCHEMA,
    TOPICS,
    decode_event,
    decode_failure,
    decode_input,
    effects_from_json,
    effects_to_json,
    encode_event,
    encode_failure,
    encode_input,
)
from app.recording.player import RecordingPlayer
from app.recording.recorder import Recorder
from app.scene.effects import Effects
from app.session.inputs import EffectsChanged, MapEdited, ReadingChanged
from app.session.session import Session
from app.studies.testbeds.reference_bodies import flat_map
from app.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.tactile.sensor_effects import Noise, SensorEffects

EVERY = {name: get_args(hint)[0]() for name, hint in get_type_hints(SensorEffects).items()}
FULL = Effects(gravity="on", contact="all", friction=True, timestep=1 / 3000, sensor=SensorEffects(**EVERY))


def damaged(**changes) -> dict:
    return json.loads(json.dumps(effects_to_json(FULL))) | changes


@pytest.mark.parametrize("effects", [Effects(), FULL])
def test_they_read_back_equal(effects):
    assert effects_from_json(json.loads(json.dumps(effects_to_json(effects)))) == effects


def test_every_field_is_there():
    raw = effects_to_json(Effects())
    assert set(raw) == {field.name for field in fields(Effects)}
    assert set(raw["sensor"]) == {field.name for field in fields(SensorEffects)}


@pytest.mark.parametrize("raw", [
    None, [], {}, "effects", damaged(magic=1), damaged(gravity="moon"), damaged(gravity=["on"]), damaged(friction=1),
    damaged(friction="on"), damaged(timestep="fast"), damaged(timestep=float("nan")), damaged(timestep=True),
    damaged(sensor=None), damaged(sensor={}), damaged(sensor=damaged()["sensor"] | {"noise": 3}),
    damaged(sensor=damaged()["sensor"] | {"noise": {"sd": "loud"}}),
    damaged(sensor=damaged()["sensor"] | {"noise": {"sd": 1.0, "colour": 2.0}}),
])  # fmt: skip
def test_what_is_damaged_is_refused(raw):
    with pytest.raises(ValueError, match="effects"):
        effects_from_json(raw)


def test_an_option_out_of_range_is_refused():
    with pytest.raises(SimulationError, match="noise"):
        effects_from_json(damaged(sensor=damaged()["sensor"] | {"noise": {"sd": -1.0}}))


AT = SurfacePoint(1, 7, (0.1, 0.2, 0.7))


@pytest.mark.parametrize(
    "act",
    [
        PokePressed(3, AT, Finger(stiffness=1 / 3)),
        PokeMoved(2, AT),
        PokeReleased(9),
        ControlChanged(ControlSettings(controller="hold_force", force_goal=0.1 + 0.2)),
        EffectsChanged(Effects(timestep=0.1 / 3, sensor=SensorEffects(noise=Noise(sd=1 / 3)))),
        ReadingChanged(ReadingSettings("lumped", threshold=1e4 / 3, wrench_noise=1 / 3)),
        ReadingChanged(ReadingSettings()),
    ],
)
def test_an_input_reads_back_equal(act, prepared):
    assert decode_input(encode_input(12, act, prepared.map), prepared.map) == (12, act)


def test_an_edit_of_the_map_reads_back_bit_for_bit(prepared):
    moved = rotate(move(MapDocument.of(prepared.map), [0], (0.1, 1 / 3)), [1], 0.3).map
    bent = replace(moved, charts=(moved.charts[0], replace(moved.charts[1], plane=1.01 * moved.charts[1].plane)))
    for edited, most in ((moved, 4_000), (bent, 2_000_000)):
        data = encode_input(3, MapEdited("Move", edited), prepared.map)
        assert len(data) < most, "what did not change is not kept again"
        tick, act = decode_input(data, prepared.map)
        assert (tick, act.name, act.map.layout) == (3, "Move", edited.layout)
        for got, chart in zip(act.map.charts, edited.charts, strict=True):
            assert (got.plane == chart.plane).all()


def test_an_edit_of_another_skins_map_is_refused(prepared):
    data = encode_input(3, MapEdited("Move", prepared.map), prepared.map)
    other = flat_map(30)
    assert len(other.charts) != len(prepared.map.charts)
    with pytest.raises(RecordingError, match="input of the recording is damaged"):
        decode_input(data, other)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{}",
        b"[1]",
        b"null",
        b'{"tick": 1, "kind": "format disk"}',
        b'{"tick": 1, "kind": "move", "id": 1}',
        b'{"tick": "x", "kind": "release", "id": 1}',
        b'{"tick": 1, "kind": "edit", "name": "x"}',
        b'{"tick": 1, "kind": "effects"}',
        b'{"tick": 1, "kind": "effects", "effects": {"gravity": "off"}}',
        b'{"tick": 1, "kind": "press", "id": 1, "at": {"patch": 0, "face": 0, "weights": [1, 0, 0]}, '
        b'"finger": {"stiffness": -1}}',
        b'{"tick": 1, "kind": "edit", "name": "x", "map": "AAAA"}',
        b'{"tick": 1, "kind": "reading", "settings": {"estimator": "guess"}}',
        b'{"tick": 1, "kind": "reading", "settings": {"threshold": -1}}',
        b'{"tick": 1, "kind": "reading", "settings": {"sum": 1}}',
        b"\xff\xfe",
        b'{"tick": 1, "kind": "press", "id": 1, "at": {"patch": 0, "face": 0, "weights": [1]}, "finger": {}}',
    ],
)
def test_a_damaged_input_is_refused_by_name(data, prepared):
    with pytest.raises(RecordingError, match="input of the recording is damaged"):
        decode_input(data, prepared.map)


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
    player = RecordingPlayer(tmp_path / "events.mcap")
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


@pytest.mark.parametrize("error", [
    SimulationError("the simulation diverged", place="joint a at 0.1 s", value=float("nan"), remedy="Reset"),
    SimulationError("the simulation diverged"),
])  # fmt: skip
def test_a_failure_reads_as_it_did(error):
    tick, again = decode_failure(encode_failure(12, error))
    assert (tick, str(again)) == (12, str(error))


@pytest.mark.parametrize("data", [b"", b"{}", b"[]", b'{"tick": 1, "problem": "x"}', b'{"tick": "soon"}'])
def test_a_damaged_failure_is_refused_by_name(data):
    with pytest.raises(RecordingError, match="failure that ended the recording is damaged"):
        decode_failure(data)


def test_every_schema_is_json_and_named_as_its_topic_says():
    assert set(TOPICS) == {"/frame", "/input", "/failure", "/event"}
    for name, text, _encoding in TOPICS.values():
        assert json.loads(text)["title"] == name
