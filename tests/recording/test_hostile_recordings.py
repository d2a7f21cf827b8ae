"""Hostile recordings: whatever is changed in a file, it is read or refused by name, with the file and a remedy."""

from __future__ import annotations

import io
import json
import re
import struct
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import RecordingError, SimulationError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.recording.encoding.frame_codec import HEADER
from tactile_maps.recording.encoding.frame_schema import PREFIX_BYTES, prefix
from tactile_maps.recording.encoding.message_codecs import TOPICS
from tactile_maps.recording.file import mcap_file
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.session.frame import Failure
from tactile_maps.session.inputs import BehavioursChanged, ControlChanged, EffectsChanged, MapEdited, ReadingChanged
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tests.support.examples import examples
from tests.support.touch import prepared_bar

pytestmark = pytest.mark.long

NUMBERS = (
    "1e999",
    "-1",
    "1e300",
    "NaN",
    "-Infinity",
    "9223372036854775808",
    "1.5",
    "true",
    "null",
    '"inf"',
    "[]",
    "{}",
    "0",
    "[" * 3000,
    '{"kind":' * 3000,
    "1" * 5000,
)
"""Replacements of a number or another value."""
_VALUE = re.compile(rb'-?\d[\d.eE+-]*|true|false|null|"[^"]*"(?!:)|\[|\]|\{|\}')
_HEADER_NUMBER = re.compile(rb"\d+(?=[,)])|<f8|<i8|\|u1|False|True")


@cache
def whole() -> bytes:
    """A short recording with every kind of message in it."""
    prepared = prepared_bar(hinged=False)
    session = Session(prepared, scripted=False)
    at = prepared.skin.taxel_point(30)
    there = prepared.skin.taxel_point(31)
    acts = {
        0: [PokePressed(1, at), ReadingChanged(ReadingSettings("tikhonov"))],
        20: [PokeMoved(1, there), MapEdited("Move", move(MapDocument.of(prepared.map), [0], (0.2, 0.1)).map)],
        22: [ControlChanged(ControlSettings(controller="hold_force", force_goal=2.0))],
        24: [EffectsChanged(replace(prepared.scene.effects, friction=True))],
        26: [BehavioursChanged((Behaviour("tap", then={"task": "retreat"}),)), PokeReleased(1)],
    }
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / "whole.mcap"
        with Recorder(prepared, path) as recorder:
            for tick in range(30):
                for act in acts.get(tick, []):
                    session.submit(act)
                frame = session.tick()
                if tick % 4 == 1:
                    recorder.write(frame, session.inputs)
            error = SimulationError("the simulation diverged", place="joint a", value=1.5, remedy="Reset")
            recorder.fail(Failure(frame.tick + 1, error, tuple(session.inputs), frame))
        return path.read_bytes()


@cache
def parts() -> tuple[dict[str, str], dict[str, bytes], list[tuple[str, bytes, int]]]:
    """Its metadata, attachments and messages with their topics and ticks."""
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / "whole.mcap"
        path.write_bytes(whole())
        contents = mcap_file.read_recording(path)
        messages = [
            (topic, message.data, message.sequence)
            for messages in contents.all_messages()
            for topic, message in messages
            if topic in TOPICS  # of others nothing is ever read
        ]
        player = RecordingPlayer(path)
        kinds = {type(act).__name__ for _, act in player.inputs}
        assert len(kinds) == 8
        assert player.failure
        assert player.events
        assert any(player.frame(number).estimates for number in range(len(player)))
    return contents.metadata, contents.attachments, messages


HEADER_BYTES = struct.calcsize("<" + "".join(HEADER.values()))


def assembled(attachments: dict[str, bytes], messages: list[tuple[str, bytes, int]]) -> bytes:
    """A recording of these parts, whole and with sound checksums."""
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE)
    channels = mcap_file.begin_recording(writer, parts()[0], attachments)
    for topic, data, tick in messages:
        writer.add_message(channels[topic], tick * 5_000_000, data, tick * 5_000_000, tick)
    writer.finish()
    return stream.getvalue()


def read_or_refused(data: bytes) -> None:
    """Open the recording, look at all of it and recover it; every error must be the named one."""
    with tempfile.TemporaryDirectory(prefix="tactile-maps-test-") as folder:
        path = Path(folder) / "hostile.mcap"
        path.write_bytes(data)
        for use in (lambda: recover(path, Path(folder) / "saved.mcap"), lambda: _look_at(RecordingPlayer(path))):
            refused = _refusal(use)
            assert refused is None or (refused.file and refused.remedy and len(str(refused)) < 2000), refused


def _refusal(use: Callable[[], object]) -> RecordingError | None:
    try:
        use()
    except RecordingError as error:
        return error
    return None


def _look_at(player: RecordingPlayer) -> None:
    player.edits()
    player.poke_spans()
    player.runtime_settings_at(10**6)
    for number in range(len(player)):
        frame = player.frame(number)
        json.dumps([region.id for region in frame.regions])


@examples(500)
@given(data=st.data())
def test_file_with_changed_bytes_is_read_or_rejected(data):
    """Changes records, lengths, checksums and compressed chunks."""
    read_or_refused(bytes(changed_bytes(data, whole())))


def changed_bytes(data, original: bytes) -> bytearray:
    """Some bytes overwritten, taken out or put in, or the end cut off."""
    changed = bytearray(original)
    for _ in range(data.draw(st.integers(1, 3), label="changes")):
        at = data.draw(st.integers(0, max(len(changed) - 1, 0)), label="at")
        new = data.draw(st.binary(min_size=1, max_size=12) | st.sampled_from([b"\xff" * 8, b"\x00" * 8]), label="new")
        way = data.draw(st.sampled_from(["overwrite", "insert", "delete", "cut"]), label="way")
        if way == "cut":
            del changed[at:]
        elif way == "delete":
            del changed[at : at + len(new)]
        else:
            changed[at : at + len(new) * (way == "overwrite")] = new
    return changed


def changed_token(data, pattern: re.Pattern[bytes], text: bytes, new) -> bytes:
    """Replace one of the tokens."""
    found = list(pattern.finditer(text))
    token = found[data.draw(st.integers(0, len(found) - 1), label="token")]
    return text[: token.start()] + data.draw(st.sampled_from(new), label="new").encode() + text[token.end() :]


def with_text_changed(data, frame: bytes) -> bytes:
    """A frame with another token in its JSON, and lengths that fit: of the text in the header, of all before it."""
    body = frame[PREFIX_BYTES:]
    # of the header: the number of bytes of text
    at = body.index(b'{"why_limited"')
    last = HEADER_BYTES - 4
    text = changed_token(data, _VALUE, body[at:], NUMBERS)
    body = body[:last] + len(text).to_bytes(4, "little") + body[HEADER_BYTES:at] + text
    return prefix(len(body)) + body


@examples(500)
@given(data=st.data())
def test_recording_with_a_changed_message_is_read_or_rejected(data):
    """Tokens of JSON, and bytes of frames: binary numbers and text alike."""
    _, attachments, messages = parts()
    number = data.draw(st.integers(0, len(messages) - 1), label="message")
    topic, message, tick = messages[number]
    if topic == "/frame" and data.draw(st.booleans(), label="binary"):
        message = bytes(changed_bytes(data, message))
    else:
        message = (
            with_text_changed(data, message) if topic == "/frame" else changed_token(data, _VALUE, message, NUMBERS)
        )
    read_or_refused(assembled(attachments, [*messages[:number], (topic, message, tick), *messages[number + 1 :]]))


@pytest.mark.long
@examples(500)
@given(data=st.data())
def test_recording_with_a_changed_attachment_is_read_or_rejected(data):
    """The scene's text, the members of archives, the headers of arrays."""
    _, attachments, messages = parts()
    name = data.draw(st.sampled_from(sorted(attachments)), label="attachment")
    original = attachments[name]
    if name.endswith(".toml"):
        changed = changed_token(data, re.compile(rb"(?<== )[^\n,]+"), original, [*NUMBERS, "nan", "inf", "'x'"])
    elif data.draw(st.booleans(), label="raw"):
        changed = bytes(changed_bytes(data, original))
    else:
        changed = changed_archive(data, original)
    read_or_refused(assembled({**attachments, name: changed}, messages))


def changed_archive(data, original: bytes) -> bytes:
    """An archive with one member changed, whole and with sound checksums."""
    source = zipfile.ZipFile(io.BytesIO(original))
    chosen = data.draw(st.sampled_from(source.namelist()), label="member")
    member = source.read(chosen)
    if chosen.endswith(".npy") and data.draw(st.booleans(), label="header"):
        new = ["10000000000000", "-1", "0", "(" * 300, "-" * 300 + "1", "<c16", "O", "1e9", "True"]
        member = changed_token(data, _HEADER_NUMBER, member[:128], new).ljust(128)[:128] + member[128:]
    elif chosen.endswith(".json"):
        member = changed_token(data, _VALUE, member, NUMBERS)
    else:
        member = bytes(changed_bytes(data, member))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in source.namelist():
            archive.writestr(name, member if name == chosen else source.read(name))
    return buffer.getvalue()
