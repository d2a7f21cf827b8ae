"""Messages hold frames and inputs to the last bit, and refuse what is neither."""

from __future__ import annotations

import json
import struct
from dataclasses import fields, replace

import numpy as np
import pytest

from app.control.command import ControlChanged, ControlSettings
from app.editing.arrange import move, rotate
from app.editing.document import MapDocument
from app.errors import RecordingError, SimulationError
from app.experiments.flat_map import flat_map
from app.geometry.surface_point import SurfacePoint
from app.recording.codec import (
    decode_failure,
    decode_frame,
    decode_input,
    encode_failure,
    encode_frame,
    encode_input,
)
from app.scene.effects import Effects
from app.session.inputs import EffectsChanged, MapEdited
from app.session.session import Session
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise

AT = SurfacePoint(1, 7, (0.1, 0.2, 0.7))


@pytest.fixture
def touched(prepared):
    """A frame with a finger and a region."""
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    assert session.frame.pokes
    return session.frame


def test_a_frame_reads_back_equal_to_the_last_bit(touched, prepared):
    again = decode_frame(encode_frame(touched), prepared.skin)
    assert (again.tick, again.time, again.why_limited) == (touched.tick, touched.time, touched.why_limited)
    assert again.timings == touched.timings
    for name in ("posture", "velocity", "pressures"):
        assert getattr(again, name).tobytes() == getattr(touched, name).tobytes()
    for name in ("posture", "stiffness", "damping", "torque"):
        assert getattr(again.command, name).tobytes() == getattr(touched.command, name).tobytes()
    for one, other in zip(again.regions, touched.regions, strict=True):
        assert (one.id, one.force, one.area, one.peak, one.at, one.link) == (
            other.id,
            other.force,
            other.area,
            other.peak,
            other.at,
            other.link,
        )
        assert np.array_equal(one.taxels, other.taxels)
        assert one.torn == other.torn
        assert np.array_equal(one.map_point, other.map_point)
    for one, other in zip(again.pokes, touched.pokes, strict=True):
        assert (one.id, one.at, one.force, one.radius) == (other.id, other.at, other.force, other.radius)


@pytest.mark.parametrize(
    "act",
    [
        PokePressed(3, AT, Finger(stiffness=1 / 3)),
        PokeMoved(2, AT),
        PokeReleased(9),
        ControlChanged(ControlSettings(law="hold_force", force_goal=0.1 + 0.2)),
        EffectsChanged(Effects(timestep=0.1 / 3, sensor=SensorEffects(noise=Noise(sd=1 / 3)))),
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
        b"\xff\xfe",
        b'{"tick": 1, "kind": "press", "id": 1, "at": {"patch": 0, "face": 0, "weights": [1]}, "finger": {}}',
    ],
)
def test_a_damaged_input_is_refused_by_name(data, prepared):
    with pytest.raises(RecordingError, match="input of the recording is damaged"):
        decode_input(data, prepared.map)


def test_a_damaged_frame_is_refused_by_name(touched, prepared):
    whole = encode_frame(touched)
    absurd = whole[:16] + (2**31 - 1).to_bytes(4, "little") + whole[20:]
    for data in (b"", whole[:10], whole[:-1], whole + b"x", absurd):
        with pytest.raises(RecordingError, match="frame of the recording is damaged"):
            decode_frame(data, prepared.skin)


def test_a_torn_region_stays_torn(touched, prepared):
    torn = replace(touched, regions=tuple(replace(region, torn=True) for region in touched.regions))
    assert all(region.torn for region in decode_frame(encode_frame(torn), prepared.skin).regions)


def test_all_that_is_known_of_a_region_reads_back(touched, prepared):
    region = replace(touched.regions[0], partner=7, split_from=3, merged=(4, 5), place_error=1 / 3)
    assert region.axes.any()
    assert region.mean > 0
    (again,) = decode_frame(encode_frame(replace(touched, regions=(region,))), prepared.skin).regions
    for field in fields(region):
        one, other = getattr(again, field.name), getattr(region, field.name)
        assert np.array_equal(one, other), field.name


def test_regions_of_earlier_formats_are_read(touched, prepared):
    """They end after the torn flag: 15 numbers less for each region."""
    data, count = encode_frame(touched), len(touched.regions)
    text = json.dumps({"why_limited": [], "notes": [], "ms": {}}).encode()
    words, members = (struct.unpack_from("<qd7i", data)[place] for place in (8, 7))
    end = len(data) - words - 4 * members
    rows = np.frombuffer(data[end - 8 * 34 * count : end]).reshape(count, 34)[:, :19]
    head = list(struct.unpack_from("<qd7i", data))
    head[8] = len(text)
    size = struct.calcsize("<qd7i")
    middle, taxels = data[size : end - 8 * 34 * count], data[end : end + 4 * members]
    old = decode_frame(struct.pack("<qd7i", *head) + middle + rows.tobytes() + taxels + text, prepared.skin)
    assert [region.force for region in old.regions] == [region.force for region in touched.regions]
    assert [region.place_error for region in old.regions] == [0.0] * count


def test_objects_and_notes_read_back(touched, prepared):
    poses = np.random.default_rng(0).normal(size=(3, 4, 4))
    frame = replace(touched, objects=poses, notes=("the hand has no skin there",))
    again = decode_frame(encode_frame(frame), prepared.skin)
    assert again.objects.tobytes() == poses.tobytes()
    assert again.notes == frame.notes
    assert [poke.force for poke in again.pokes] == [poke.force for poke in touched.pokes]
    assert [region.id for region in again.regions] == [region.id for region in touched.regions]


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
