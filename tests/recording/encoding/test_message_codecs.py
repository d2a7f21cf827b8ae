"""Inputs, effects, events and failures as messages: equal when read back, damage is named; the list of topics."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from typing import get_args, get_type_hints

import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from tactile_maps.contacts.events import EVENT_KINDS, ContactEvent
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import RecordingError, SimulationError
from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.recording.encoding.message_codecs import (
    TOPICS,
    decode_event,
    decode_failure,
    decode_input,
    encode_event,
    encode_failure,
    encode_input,
)
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import ControlChanged, EffectsChanged, MapEdited, ReadingChanged, RestChanged
from tactile_maps.session.session import Session
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.studies.testbeds.reference_bodies import flat_map
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS, Noise, SensorEffects

EVERY = {name: get_args(hint)[0]() for name, hint in get_type_hints(SensorEffects).items() if name in SENSOR_KEYS}
FULL = Effects(gravity="on", contact="all", friction=True, timestep=1 / 3000, sensor=SensorEffects(**EVERY))


@pytest.mark.parametrize("effects", [Effects(), FULL])
def test_effects_read_back_equal(effects, prepared):
    message = encode_input(1, EffectsChanged(effects), prepared.map)
    raw = json.loads(message)["input"]["effects"]
    assert set(raw) == {field.name for field in fields(Effects)}
    assert set(raw["sensor"]) == {field.name for field in fields(SensorEffects)}
    assert decode_input(message, prepared.map) == (1, EffectsChanged(effects))
    older = json.loads(message)
    del older["input"]["effects"]["sensor"]["plug_ins"]
    assert decode_input(json.dumps(older).encode(), prepared.map) == (1, EffectsChanged(effects)), "before plug-ins"


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"magic": 1}, "effects"),
        ({"gravity": "moon"}, "effects.gravity"),
        ({"gravity": ["on"]}, "effects.gravity"),
        ({"friction": 1}, "effects.friction"),
        ({"friction": "on"}, "effects.friction"),
        ({"timestep": "fast"}, "effects.timestep"),
        ({"timestep": True}, "effects.timestep"),
        ({"timestep": float("nan")}, "/input"),
        ({"sensor": None}, "effects.sensor"),
        ({"sensor": {}}, "effects.sensor"),
        ({"noise": 3}, "effects.sensor.noise"),
        ({"noise": {"sd": "loud"}}, "effects.sensor.noise.sd"),
        ({"noise": {"sd": 1.0, "colour": 2.0}}, "effects.sensor.noise"),
        ({"noise": {"sd": -1.0}}, "sensor.noise"),
    ],
)
def test_damaged_effects_are_rejected_with_their_place(changes, place, prepared):
    raw = json.loads(encode_input(1, EffectsChanged(FULL), prepared.map))
    effects = raw["input"]["effects"]
    (effects["sensor"] if "noise" in changes else effects).update(changes)
    with pytest.raises(RecordingError) as refused:
        decode_input(json.dumps(raw).encode(), prepared.map, file="x.mcap")
    assert refused.value.file == "x.mcap"
    assert place in refused.value.place
    assert refused.value.remedy


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
        ReadingChanged(ReadingSettings(pixel=1e-2 / 3, interpolation="nearest", back_projection="three-taxels")),
        RestChanged((0.1, -1 / 3, 0.0)),
    ],
)
def test_input_reads_back_equal(act, prepared):
    assert decode_input(encode_input(12, act, prepared.map), prepared.map) == (12, act)


def test_edit_of_the_map_reads_back_bit_for_bit(prepared):
    moved = rotate(move(MapDocument.of(prepared.map), [0], (0.1, 1 / 3)), [1], 0.3).map
    first, *others = moved.charts
    bent = replace(moved, charts=(replace(first, plane=1.01 * first.plane), *others))
    for edited, most in ((moved, 4_000), (bent, 2_000_000)):
        data = encode_input(3, MapEdited("Move", edited), prepared.map)
        assert len(data) < most, "what did not change is not kept again"
        tick, act = decode_input(data, prepared.map)
        assert (tick, act.name, act.map.layout) == (3, "Move", edited.layout)
        for got, chart in zip(act.map.charts, edited.charts, strict=True):
            assert (got.plane == chart.plane).all()


def test_edit_of_the_map_of_another_skin_is_rejected(prepared):
    other = flat_map(30)
    assert len(other.charts) < len(prepared.map.charts)
    changed = replace(prepared.map, charts=tuple(map(replace, prepared.map.charts)))
    for edited, problem in ((prepared.map, ""), (changed, "the edit is of another map")):
        data = encode_input(3, MapEdited("Move", edited), prepared.map)
        with pytest.raises(RecordingError, match=rf"/input: input\.map.*{problem}"):
            decode_input(data, other)


def test_map_of_a_displaced_skin_is_stored_and_that_of_another_skin_rejected(prepared):
    believed = build_map(with_calibration_error(prepared.skin, 0.002, seed=1))
    data = encode_input(3, MapEdited("Believed", believed), prepared.map)
    _, act = decode_input(data, prepared.map)
    for got, own in zip(act.map.skin.patches, believed.skin.patches, strict=True):
        assert (got.taxels.positions == own.taxels.positions).all()
        assert (got.surface.vertices == own.surface.vertices).all()
    with pytest.raises(RecordingError, match=r"input\.map, skin: the edit is of another skin's map"):
        decode_input(data, flat_map(30))
    turned = replace(
        believed.skin, patches=tuple(patch if n else mirrored(patch) for n, patch in enumerate(believed.skin.patches))
    )
    with pytest.raises(RecordingError, match="whose triangles are not the skin's"):
        encode_input(3, MapEdited("Other", replace(believed, skin=turned)), prepared.map)


def mirrored(patch):
    """The patch with its triangles turned over: the same taxels on another surface."""
    return replace(patch, surface=Mesh(patch.surface.vertices, patch.surface.faces[:, ::-1]))


def message(**fields) -> bytes:
    return json.dumps({"tick": 1, "input": fields}).encode()


PLACE = {"patch": 0, "face": 0, "weights": [1, 0, 0]}
FINGER = {"stiffness": 1e3, "radius": 0.008, "max_force": 20.0, "speed": 0.012}
READING = {"kind": "ReadingChanged", "settings": {"estimator": "tikhonov", "threshold": None, "wrench_noise": 0.0}}


def test_examples_are_valid_before_damage(prepared):
    pressed = decode_input(message(kind="PokePressed", id=1, at=PLACE, finger=FINGER), prepared.map)[1]
    assert pressed == PokePressed(1, SurfacePoint(0, 0, (1.0, 0.0, 0.0)), Finger())
    assert decode_input(message(**READING), prepared.map)[1] == ReadingChanged(ReadingSettings("tikhonov"))


@pytest.mark.parametrize(
    ("data", "place"),
    [
        (b"", "/input"),
        (b"\xff\xfe", "/input"),
        (b"{}", "/input"),
        (b"[1]", "/input"),
        (b"null", "/input"),
        (b"[" * 200_000, "/input"),
        (b'{"tick": 1, "input": ' + b"[" * 200_000 + b"]" * 200_000 + b"}", "/input"),
        (b'{"tick": 1, "input": {"kind": "PokeReleased", "id": NaN}}', "/input"),
        (b'{"tick": 1e999, "input": {"kind": "PokeReleased", "id": 1}}', "/input: tick"),
        (b'{"tick": 1.0, "input": {"kind": "PokeReleased", "id": 1}}', "/input: tick"),
        (b'{"tick": true, "input": {"kind": "PokeReleased", "id": 1}}', "/input: tick"),
        (b'{"tick": 9223372036854775808, "input": {"kind": "PokeReleased", "id": 1}}', "/input: tick"),
        (b'{"tick": 1, "input": {"kind": "PokeReleased", "id": 1}, "more": 1}', "/input"),
        (message(kind="FormatDisk"), "/input: input.kind"),
        (message(id=1), "/input: input"),
        (message(kind="PokeMoved", id=1), "/input: input"),
        (message(kind="PokeReleased", id="x"), "/input: input.id"),
        (message(kind="PokeReleased", id=1e999), "/input"),
        (message(kind="MapEdit", name="x"), "/input: input"),
        (message(kind="MapEdit", name="x", map="AAAA"), "/input: input.map"),
        (message(kind="MapEdit", name="x", map="no base64!"), "/input: input.map"),
        (message(kind="PokeMoved", id=1, at=PLACE | {"weights": [1]}), "/input: input.at.weights"),
        (message(kind="PokeMoved", id=1, at=PLACE | {"weights": [1, 0, "x"]}), "/input: input.at.weights[2]"),
        (message(kind="PokeMoved", id=1, at=PLACE | {"weights": [1, 1, 0]}), "/input: input.at"),
        (message(kind="PokeMoved", id=1, at=PLACE | {"patch": -1}), "/input: input.at"),
        (message(kind="PokeMoved", id=1, at=PLACE | {"face": 10**9}), "/input: input.at"),
        (message(kind="PokePressed", id=1, at=PLACE, finger={}), "/input: input.finger"),
        (message(kind="PokePressed", id=1, at=PLACE, finger=FINGER | {"stiffness": -1}), "/input: input.finger"),
        (message(kind="ReadingChanged", settings={"sum": 1}), "/input: input.settings"),
        (message(kind="ReadingChanged", settings=READING["settings"] | {"threshold": -1}), "/input: input.settings"),
        (
            message(kind="ReadingChanged", settings=READING["settings"] | {"estimator": "guess"}),
            "input.settings, contacts.estimator",
        ),
    ],
)
def test_damaged_input_is_rejected_with_its_place(data, place, prepared):
    with pytest.raises(RecordingError) as refused:
        decode_input(data, prepared.map, file="x.mcap")
    assert place in refused.value.place
    assert "x.mcap" in str(refused.value)
    assert refused.value.remedy


EVENT = ContactEvent(12, 0.1 + 0.2, "stroke", "ended", (3, 4), ("forearm", "hand"), AT, AT, 1 / 3, 0.7, 0.1)


@pytest.mark.parametrize("kind", EVENT_KINDS)
@pytest.mark.parametrize("to", [None, AT])
def test_event_reads_back_equal(kind, to, prepared):
    event = replace(EVENT, kind=kind, to=to)
    assert decode_event(encode_event(event), prepared.skin) == event


JSON_TOPICS = [topic for topic, said in TOPICS.items() if said.encoding == "json"]


@pytest.mark.parametrize("topic", JSON_TOPICS)
def test_every_schema_is_valid_with_plain_top_level_properties(topic):
    """Foxglove and Lichtblick refuse a topic whose schema has choices or tuples among its own properties."""
    schema = json.loads(TOPICS[topic].schema)
    Draft202012Validator.check_schema(schema)
    assert schema["type"] == "object"
    assert {part.get("type") for part in schema.get("properties", {}).values()} <= {"integer", "number", "string"}


def test_schema_accepts_its_message_and_rejects_another():
    check = Draft202012Validator(json.loads(TOPICS["/event"].schema))
    said = json.loads(encode_event(EVENT))
    assert check.is_valid(said)
    assert not check.is_valid(said | {"event": said["event"] | {"kind": "kick"}})


def test_message_contains_all_fields_of_its_schema():
    said = json.loads(encode_event(EVENT))
    schema = json.loads(TOPICS["/event"].schema)["allOf"][0]
    assert set(said) == set(schema["required"]) == set(schema["properties"])
    promised = schema["properties"]["event"]
    assert set(said["event"]) == set(promised["required"]) == set(promised["properties"])
    assert promised["properties"]["kind"] == {"enum": list(EVENT_KINDS)}
    assert said["words"] == EVENT.words
    assert said["event"]["at"] == {"patch": 1, "face": 7, "weights": [0.1, 0.2, 0.7]}


@pytest.mark.parametrize(
    "data",
    [b"", b"{}", b"[]", b"null", encode_event(EVENT)[:-1], encode_event(EVENT).replace(b'"stroke"', b'"kick"')]
    + [encode_event(EVENT).replace(b'"ended"', b'"paused"'), encode_event(EVENT).replace(b"0.7]", b"0.7,1]")]
    + [encode_event(EVENT).replace(b'"tick":12', tick) for tick in (b'"tick":1e999', b'"tick":null')]
    + [encode_event(EVENT).replace(b'"patch":1', patch) for patch in (b'"patch":-1', b'"patch":99')]
    + [encode_event(EVENT).replace(b"[3,4]", b"[" * 200_000 + b"]" * 200_000)],
)
def test_damaged_event_is_rejected_with_its_place(data, prepared):
    assert data != encode_event(EVENT)
    with pytest.raises(RecordingError, match="/event"):
        decode_event(data, prepared.skin)


@pytest.fixture
def frames(prepared, tmp_path):
    """Frames of a session with a press and a release, recorded from the 21st on."""
    session = Session(prepared, scripted=False)
    seen = []
    with Recorder(prepared, tmp_path / "events.mcap") as recorder:
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


def test_replayed_frame_contains_its_events(frames, tmp_path):
    player = RecordingPlayer(tmp_path / "events.mcap")
    assert player.events == list(frames[-1].recent[::-1]), "those before the recording began as well"
    for number in (0, 50, 150, len(player) - 1):
        assert player.frame(number).recent == frames[number].recent
        assert player.frame(number).events == frames[number].events


def test_other_programs_can_read_the_channel(frames, tmp_path):
    with (tmp_path / "events.mcap").open("rb") as stream:
        found = [
            (schema.name, channel.message_encoding, json.loads(message.data)["words"])
            for schema, channel, message in make_reader(stream).iter_messages(topics=["/event"])
        ]
    assert {item[:2] for item in found} == {("tactile_maps.ContactEvent", "json")}
    assert [item[2] for item in found] == [event.words for event in frames[-1].recent[::-1]]


@pytest.mark.parametrize(
    "error",
    [
        SimulationError("the simulation diverged", place="joint a at 0.1 s", value=float("nan"), remedy="Reset"),
        SimulationError("the simulation diverged"),
    ],
)
def test_failure_is_restored(error):
    tick, again = decode_failure(encode_failure(12, error))
    assert (tick, str(again)) == (12, str(error))


@pytest.mark.parametrize("data", [b"", b"{}", b"[]", b'{"tick": 1, "problem": "x"}', b'{"tick": "soon"}'])
def test_damaged_failure_is_rejected_by_name(data):
    with pytest.raises(RecordingError, match="/failure"):
        decode_failure(data)


def test_every_schema_is_json_with_the_name_stated_by_its_topic():
    assert set(TOPICS) == {"/frame", "/input", "/failure", "/event", "/mark"}
    assert {topic for topic in TOPICS if topic not in JSON_TOPICS} == {"/frame"}, "a field of bytes in Protobuf"
    for topic in JSON_TOPICS:
        assert TOPICS[topic].schema_encoding == "jsonschema"
        assert json.loads(TOPICS[topic].schema)["title"] == TOPICS[topic].name
