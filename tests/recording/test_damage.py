"""A recording that lost something says what, where and how long; nothing is lost in silence."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.encoding.frame_codec import encode_frame, tick_of
from tactile_maps.recording.encoding.message_codecs import TOPICS
from tactile_maps.recording.encoding.viewer_messages import viewer_schemas
from tactile_maps.recording.file.damage import (
    DamageKind,
    Hole,
    RecordingDamage,
    damage_text,
    find_losses,
    lost_at_end,
    merge_damage,
)
from tactile_maps.recording.file.mcap_file import _Records, add_viewer_channels, begin_recording, read_recording
from tactile_maps.recording.machine import machine_facts
from tactile_maps.recording.overview.summary import summarise
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.recording.trim import trim
from tactile_maps.recording.verify import verify
from tactile_maps.session.bundle import unpack_scene
from tactile_maps.session.session import Session
from tactile_widgets.__main__ import main
from tests.files.small_bombs import broken_records

FIRST = 51
LAST = 250
"""Ticks of the fixture's frames."""


def chunk_spans(path):
    """Return the byte ranges of the compressed messages of all chunks, from the index."""
    with path.open("rb") as stream:
        indexes = make_reader(stream).get_summary().chunk_indexes
    return [
        (index.chunk_start_offset + index.chunk_length - index.compressed_size, index.compressed_size)
        for index in indexes
    ]


def ticks_in(path, chunk):
    """Ticks of the frames in one chunk."""
    contents = read_recording(path)
    return [tick_of(message.data) for topic, message in contents.messages(chunk) if topic == "/frame"]


def topics_in(path, chunk):
    """Topics of the messages in one chunk."""
    contents = read_recording(path)
    return {topic for topic, _ in contents.messages(chunk)}


def flipped(path, target, at, bit=0):
    """A copy with one bit flipped."""
    data = bytearray(path.read_bytes())
    data[at] ^= 1 << bit
    target.write_bytes(data)
    return target


def rewritten(path, target, change, **metadata):
    """A sound copy whose messages, (topic, message) in order, went through ``change``; ``metadata`` is replaced."""
    contents = read_recording(path)
    messages = [one for messages in contents.all_messages() for one in messages]
    with target.open("wb") as stream:
        writer = Writer(stream, chunk_size=20_000, compression=CompressionType.ZSTD)
        channels = begin_recording(writer, contents.metadata | metadata, contents.attachments)
        shown = viewer_schemas(unpack_scene(contents.attachments, file=str(path)))
        channels = {**channels, **add_viewer_channels(writer, shown)}
        for topic, message in change(messages):
            writer.add_message(channels[topic], message.log_time, message.data, 0, message.sequence)
        writer.finish()
    return target


def of_kind(damage, kind):
    """All of one kind."""
    return [one for one in damage if one.kind == kind]


def with_topics(path, topics):
    """Numbers of chunks that hold messages of all these topics and of no others."""
    return [number for number in range(len(chunk_spans(path))) if topics_in(path, number) == topics]


def without_inputs(path):
    """Numbers of chunks that hold only frames."""
    return with_topics(path, {"/frame"})


@pytest.mark.long
def test_flipped_bit_in_the_frames_is_reported_with_its_ticks(recording, tmp_path):
    number = without_inputs(recording)[5]
    ticks = ticks_in(recording, number)
    start, size = chunk_spans(recording)[number]
    player = RecordingPlayer(flipped(recording, tmp_path / "flipped.mcap", start + size // 2))
    assert not player.complete
    assert len(player) == LAST - FIRST + 1 - len(ticks)
    assert of_kind(player.damage, DamageKind.UNREADABLE_CHUNK) == [RecordingDamage(DamageKind.UNREADABLE_CHUNK, 1)]
    missing = RecordingDamage(DamageKind.FRAMES_MISSING, len(ticks), ticks[0], ticks[-1])
    assert of_kind(player.damage, DamageKind.FRAMES_MISSING) == [missing]
    assert not of_kind(player.damage, DamageKind.INPUTS_MISSING)
    outcome = verify(player)
    assert outcome.identical, "the frames that are left are the recorded ones"
    assert (outcome.frames, outcome.not_compared) == (len(player), 0)


class CountedBytes(io.BytesIO):
    """A stream that counts the bytes that are read."""

    count = 0

    def read(self, size=-1):
        data = super().read(size)
        self.count += len(data)
        return data


def test_index_is_read_once_however_many_records_are_damaged():
    stream = CountedBytes(broken_records(100))
    size = len(stream.getvalue())
    stream.seek(8)
    assert sum(record is None for record in _Records(stream, size)) >= 99
    assert stream.count < 3 * size


@pytest.mark.parametrize("topic", ["/input", "/event"])
def test_copies_list_each_loss_of_their_source_once(recording, tmp_path, topic):
    spans = chunk_spans(recording)
    number = [number for number in range(2, len(spans)) if topic in topics_in(recording, number)][-1]
    start, size = spans[number]
    source = flipped(recording, tmp_path / "source.mcap", start + size // 2)
    damage = RecordingPlayer(source).damage
    assert any(one.kind in (DamageKind.INPUTS_MISSING, DamageKind.EVENTS_MISSING) for one in damage)
    recover(source, tmp_path / "recovered.mcap")
    trim(source, tmp_path / "part.mcap")
    trim(tmp_path / "part.mcap", tmp_path / "again.mcap")
    for copy in ("recovered", "part", "again"):
        assert RecordingPlayer(tmp_path / f"{copy}.mcap").damage == damage


def test_new_losses_of_a_copy_replace_the_listed_ones():
    kind = DamageKind.EVENTS_MISSING
    stated = [RecordingDamage(kind, 1, 434, 441), RecordingDamage(kind, 2, 600, None), RecordingDamage(kind, 1, 10, 12)]
    same = [RecordingDamage(kind, 1, 0, 488), RecordingDamage(kind, 2, 590, 650)]
    assert sorted(merge_damage(same, stated), key=stated.index) == stated
    more = RecordingDamage(kind, 3, 0, 488)
    assert merge_damage([more], stated) == [stated[1], more]
    other = RecordingDamage(DamageKind.INPUTS_MISSING, 1, 434, 441)
    assert merge_damage([other], stated) == [*stated, other]


def test_frames_after_a_lost_input_are_not_compared(recording, tmp_path):
    spans = chunk_spans(recording)
    number = next(n for n in range(3, len(spans)) if {"/frame", "/input"} <= topics_in(recording, n))
    before = max(tick for n in range(number) for tick in ticks_in(recording, n))
    after = min(tick for n in range(number + 1, len(spans)) for tick in ticks_in(recording, n))
    start, size = spans[number]
    player = RecordingPlayer(flipped(recording, tmp_path / "flipped.mcap", start + size // 2))
    (lost,) = of_kind(player.damage, DamageKind.INPUTS_MISSING)
    assert before <= lost.first <= lost.last <= after
    outcome = verify(player)
    assert outcome.identical
    compared = [player.frame(k).tick for k in range(len(player)) if player.frame(k).tick <= lost.first]
    assert outcome.frames == len(compared)
    assert outcome.not_compared == len(player) - len(compared) > 0


def test_verification_without_comparable_frames_is_not_identical(recording, tmp_path, capsys):
    """The first input is missing, so no frame can be simulated again."""

    def without_first_input(messages):
        return [one for one in messages if (one[0], one[1].sequence) != ("/input", 0)]

    path = rewritten(recording, tmp_path / "headless.mcap", without_first_input)
    outcome = verify(RecordingPlayer(path))
    assert (outcome.frames, outcome.identical, outcome.not_compared) == (0, None, LAST - FIRST + 1)
    assert main(["replay", str(path), "--verify", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["identical"] is None
    assert main(["replay", str(path), "--verify"]) == 1
    said = capsys.readouterr().out
    assert "nothing to compare" in said
    assert "yes" not in said


@pytest.mark.parametrize(
    "machine", [{"cpu": "Abacus 1", "blas": "slowblas, kernel Beads"}, pytest.param({}, marks=pytest.mark.long)]
)
def test_difference_on_another_machine_names_both_and_its_size(recording, tmp_path, capsys, machine):
    """A pressure of the last frame differs by a millionth of a kPa, as rounding may cause."""
    player = RecordingPlayer(recording)
    last = player.frame(len(player) - 1)
    pressures = last.pressures.copy()
    pressures[3] += 1e-3
    data = encode_frame(replace(last, pressures=pressures))

    def with_rounding(messages):
        return [
            (
                topic,
                replace(message, data=data) if topic == "/frame" and tick_of(message.data) == last.tick else message,
            )
            for topic, message in messages
        ]

    path = rewritten(recording, tmp_path / "other.mcap", with_rounding, **machine)
    assert main(["replay", str(path), "--verify"]) == 1
    said = capsys.readouterr().out
    assert f"no: from tick {last.tick} on, by up to 1e-06 in pressures [kPa]" in said
    assert main(["replay", str(path), "--verify", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["differing"] == "pressures [kPa]"
    if not machine:
        assert "Likely reason" not in said
        assert found["other_machine"] == []
    else:
        now = ", ".join(machine_facts().values())
        assert found["other_machine"] == ["recorded on Abacus 1, slowblas, kernel Beads", f"now on {now}"]
        assert all(words in said for words in ("last digits depend on the machine", *found["other_machine"]))


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(60))
def test_every_flipped_bit_is_reported(recording, tmp_path, seed):
    """A bit anywhere in the file leads to a named error or a report; every frame is present or counted as lost."""
    size = recording.stat().st_size
    chance = np.random.default_rng(seed)
    # Half of them behind the attachments, which are most of the file.
    low = 8 if seed % 2 else chunk_spans(recording)[0][0] - 100
    at = int(chance.integers(low, size))
    path = flipped(recording, tmp_path / "flipped.mcap", at, int(chance.integers(8)))
    try:
        player = RecordingPlayer(path)
    except RecordingError:
        return
    assert player.damage, f"byte {at} of {size}"
    lost = sum(one.count for one in of_kind(player.damage, DamageKind.FRAMES_MISSING))
    if not of_kind(player.damage, DamageKind.CUT_OFF):
        assert len(player) + lost == LAST - FIRST + 1


@pytest.mark.long
def test_reading_continues_at_the_next_chunk_after_a_wrong_length(recording, tmp_path):
    number = without_inputs(recording)[3]
    with recording.open("rb") as stream:
        index = make_reader(stream).get_summary().chunk_indexes[number]
    path = flipped(recording, tmp_path / "length.mcap", index.chunk_start_offset + 7, 6)
    player = RecordingPlayer(path)
    ticks = ticks_in(recording, number)
    missing = RecordingDamage(DamageKind.FRAMES_MISSING, len(ticks), ticks[0], ticks[-1])
    assert of_kind(player.damage, DamageKind.FRAMES_MISSING) == [missing]
    assert of_kind(player.damage, DamageKind.UNREADABLE_CHUNK)


def test_missing_beginning_and_missing_end_are_counted(recording, tmp_path):
    spans = chunk_spans(recording)
    end = max(n for n in range(len(spans)) if ticks_in(recording, n))  # behind it there may be messages for viewers
    last = ticks_in(recording, end)
    start, size = spans[end]
    player = RecordingPlayer(flipped(recording, tmp_path / "end.mcap", start + size // 2))
    (missing,) = of_kind(player.damage, DamageKind.FRAMES_MISSING)
    assert (missing.count, missing.first, missing.last) == (len(last), last[0], LAST)
    number, first = next((n, ticks) for n in range(len(spans)) if (ticks := ticks_in(recording, n)))
    start, size = spans[number]
    player = RecordingPlayer(flipped(recording, tmp_path / "start.mcap", start + size // 2))
    (missing,) = of_kind(player.damage, DamageKind.FRAMES_MISSING)
    assert (missing.count, missing.first, missing.last) == (len(first), FIRST, first[-1])


def test_missing_repeated_or_misplaced_frame_is_reported(recording, tmp_path):
    def drop(messages):
        frames = [n for n, (topic, _) in enumerate(messages) if topic == "/frame"]
        return [one for n, one in enumerate(messages) if n not in frames[10:12]]

    player = RecordingPlayer(rewritten(recording, tmp_path / "dropped.mcap", drop))
    assert player.damage == (RecordingDamage(DamageKind.FRAMES_MISSING, 2, FIRST + 10, FIRST + 11),)

    def double(messages):
        frames = [one for one in messages if one[0] == "/frame"]
        return [*messages, frames[7]]

    player = RecordingPlayer(rewritten(recording, tmp_path / "doubled.mcap", double))
    assert player.damage == (RecordingDamage(DamageKind.FRAMES_REPEATED, 1, FIRST + 7, FIRST + 7),)
    assert len(player) == LAST - FIRST + 1

    def swap(messages):
        frames = [n for n, (topic, _) in enumerate(messages) if topic == "/frame"]
        a, b = frames[20:22]
        messages[a], messages[b] = messages[b], messages[a]
        return messages

    player = RecordingPlayer(rewritten(recording, tmp_path / "swapped.mcap", swap))
    assert player.damage == (RecordingDamage(DamageKind.FRAMES_OUT_OF_ORDER, 1, FIRST + 20, FIRST + 20),)
    assert [player.frame(n).tick for n in range(len(player))] == list(range(FIRST, LAST + 1))


def test_missing_input_is_reported_though_every_frame_is_present(recording, tmp_path):
    def drop(messages):
        inputs = [n for n, (topic, _) in enumerate(messages) if topic == "/input"]
        return [one for n, one in enumerate(messages) if n != inputs[-2]]

    player = RecordingPlayer(rewritten(recording, tmp_path / "dropped.mcap", drop))
    (lost,) = player.damage
    assert (lost.kind, lost.count) == (DamageKind.INPUTS_MISSING, 1)
    assert len(player) == LAST - FIRST + 1
    assert not player.complete


@pytest.mark.parametrize("topics", [pytest.param({"/frame"}, marks=pytest.mark.long), {"/frame", "/event"}])
def test_recovered_file_states_the_losses_of_its_source(recording, tmp_path, topics):
    number = with_topics(recording, topics)[-1]
    start, size = chunk_spans(recording)[number]
    damaged = flipped(recording, tmp_path / "damaged.mcap", start + size // 2)
    saved = recover(damaged, tmp_path / "saved.mcap")
    assert saved.lost_frames == len(ticks_in(recording, number))
    player = RecordingPlayer(tmp_path / "saved.mcap")
    assert player.damage == saved.damage == RecordingPlayer(damaged).damage
    assert not player.complete
    again = recover(tmp_path / "saved.mcap", tmp_path / "again.mcap")
    assert again.damage == saved.damage


def test_truncated_file_is_reported_as_missing_its_end(recording, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[: int(0.98 * recording.stat().st_size)])
    player = RecordingPlayer(cut)
    (damage,) = player.damage
    assert damage == RecordingDamage(DamageKind.CUT_OFF, None, player.frame(len(player) - 1).tick + 1)


def attachment_spans(path):
    """Offsets of the attachments in the file."""
    with path.open("rb") as stream:
        return [(index.offset, index.length) for index in make_reader(stream).get_summary().attachment_indexes]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("place", ["empty", "magic", "header", "attachment", "between", "first chunk"])
def test_file_truncated_before_its_first_frame_is_reported(recording, tmp_path, place):
    offset, length = attachment_spans(recording)[2]
    size = {
        "empty": 0,
        "magic": 5,
        "header": 40,
        "attachment": offset + length // 2,
        "between": offset + length,
        "first chunk": chunk_spans(recording)[0][0] + 50,
    }[place]
    cut = tmp_path / "cut.mcap"
    target = tmp_path / "new.mcap"
    cut.write_bytes(recording.read_bytes()[:size])
    uses = (RecordingPlayer, lambda path: recover(path, target), lambda path: trim(path, target, first=0))
    for use in uses:
        with pytest.raises(RecordingError, match=r"cut\.mcap: the recording was cut off before its first.*Nothing can"):
            use(cut)
    assert "cut off before its first" in summarise(cut).problem
    assert not target.exists()


def test_incomplete_file_of_another_program_is_not_reported_as_truncated(recording, tmp_path):
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(library="another program")
        writer.add_metadata("other", {})
        stream.flush()
        path.write_bytes(path.read_bytes())
    with pytest.raises(RecordingError, match="an attachment of the recording is missing"):
        RecordingPlayer(path)


def test_bytes_after_the_end_are_counted_and_not_reported_as_truncation(recording, tmp_path, capsys):
    path = tmp_path / "more.mcap"
    clean = tmp_path / "clean.mcap"
    path.write_bytes(recording.read_bytes() + b"x" * 37)
    player = RecordingPlayer(path)
    assert player.damage == (RecordingDamage(DamageKind.TRAILING, 37),)
    assert len(player) == LAST - FIRST + 1
    assert main(["inspect", str(path)]) == 0
    said = capsys.readouterr().out
    assert "37 bytes after its end" in said
    assert "cut off" not in said
    recover(path, clean)
    assert RecordingPlayer(clean).complete, "nothing is lost in the copy"


def test_file_being_recorded_is_not_reported_as_truncated(prepared, tmp_path, capsys):
    path = tmp_path / "now.mcap"
    session = Session(prepared)
    with Recorder(prepared, path) as recorder:
        for use in (RecordingPlayer, lambda path: recover(path, tmp_path / "none.mcap")):
            with pytest.raises(RecordingError, match="has just begun and contains no frame yet"):
                use(path)
        for _ in range(20):
            recorder.write(session.tick(), session.inputs)
        player = RecordingPlayer(path)
        assert [one.kind for one in player.damage] == [DamageKind.BEING_RECORDED]
        assert main(["inspect", str(path)]) == 0
        said = capsys.readouterr().out
        assert "being recorded" in said
        assert "Inspect it again" in said
        assert "recover" not in said
        assert summarise(path).problem == "It is being recorded"
        recover(path, tmp_path / "part.mcap")
        with pytest.raises(RecordingError, match="another program is writing"):
            Recorder(prepared, path, overwrite=True)
    assert RecordingPlayer(path).complete
    assert [one.kind for one in RecordingPlayer(tmp_path / "part.mcap").damage] == [DamageKind.CUT_OFF]


def test_description_of_damage_states_count_position_and_duration():
    gap = RecordingDamage(DamageKind.FRAMES_MISSING, 6, 96, 101)
    assert damage_text(gap, 0.005) == "frames missing: 6, ticks 96 to 101 (0.03 s from 0.48 s on)"
    assert damage_text(replace(gap, count=1, last=96), 0.005) == "frames missing: 1, at tick 96 (0.48 s)"
    cut = RecordingDamage(DamageKind.CUT_OFF, None, 20)
    assert damage_text(cut, 0.005) == "the file was cut off: what followed is lost, from tick 20 on (0.1 s)"
    assert "inputs missing: 2;" in damage_text(RecordingDamage(DamageKind.INPUTS_MISSING, 2, 3, None), 0.005)


@pytest.mark.parametrize("kind", list(DamageKind))
def test_every_kind_of_damage_has_a_description(kind):
    text = damage_text(RecordingDamage(kind, 3, 4, 5), 0.01)
    assert "{" not in text
    assert "ticks 4 to 5" in text


@pytest.mark.parametrize(
    ("numbers", "holes", "at_end", "found"),
    [
        ([(0, 3), (1, 5)], [], 0, []),
        ([(0, 3), (2, 9)], [], 0, [(1, 3, 9)]),
        ([(0, 3), (2, 90)], [Hole(40, 47)], 0, [(1, 40, 47)]),
        ([(0, 3), (2, 90)], [Hole(100, 107)], 0, [(1, 3, 90)]),
        ([(1, 90)], [Hole(None, 12)], 0, [(1, 0, 12)]),
        ([(0, 3)], [Hole(40, None)], 1, [(1, 40, None)]),
        ([], [], 2, [(2, 0, None)]),
    ],
)
def test_lost_messages_are_located_at_unreadable_bytes(numbers, holes, at_end, found):
    columns = np.array(numbers, dtype=np.int64).reshape(-1, 2).T
    losses = find_losses(*columns, holes, at_end, DamageKind.INPUTS_MISSING)
    assert [(one.count, one.first, one.last) for one in losses] == found


@pytest.mark.parametrize(
    ("numbers", "written", "count"),
    [([0, 1, 2], 3, 0), ([0, 1, 2], 5, 2), ([0, 2], 3, 0), ([0, 2], 5, 2), ([0, 1, 1], 3, 0), ([0, 1], None, 0)],
)
def test_loss_at_the_end_is_known_from_written_inputs(numbers, written, count):
    assert lost_at_end(np.array(numbers), written) == count


def test_topics_have_channels_even_if_their_declaration_is_lost(recording):
    """They are declared in the first chunk: a file that lost it and its end is still read."""
    stream = io.BytesIO()
    writer = Writer(stream)
    channels = begin_recording(writer, {}, {})
    assert list(channels) == list(TOPICS)
    assert list(channels.values()) == list(range(1, len(TOPICS) + 1))
