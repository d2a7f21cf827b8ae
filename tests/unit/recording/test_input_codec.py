"""Messages hold inputs to the last bit, and refuse what is none."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.contacts.reading_settings import ReadingSettings
from app.control.command import ControlChanged, ControlSettings
from app.editing.arrange import move, rotate
from app.editing.document import MapDocument
from app.errors import RecordingError
from app.experiments.flat_map import flat_map
from app.geometry.surface_point import SurfacePoint
from app.recording.input_codec import decode_input, encode_input
from app.scene.effects import Effects
from app.session.inputs import EffectsChanged, MapEdited, ReadingChanged
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise

AT = SurfacePoint(1, 7, (0.1, 0.2, 0.7))


@pytest.mark.parametrize(
    "act",
    [
        PokePressed(3, AT, Finger(stiffness=1 / 3)),
        PokeMoved(2, AT),
        PokeReleased(9),
        ControlChanged(ControlSettings(law="hold_force", force_goal=0.1 + 0.2)),
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
