"""A part of a recording is a recording: its frames, its inputs, simulated again bit for bit; the whole stays."""

from __future__ import annotations

import json

import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.encoding.annotations import (
    Annotations,
    LabelledEpisode,
    Mark,
    annotations_file,
    save_annotations,
)
from tactile_maps.recording.file.damage import DamageKind
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import versions
from tactile_maps.recording.recover import recover
from tactile_maps.recording.trim import episode_file_name, trim, trim_episodes
from tactile_maps.recording.verify import verify
from tactile_widgets.__main__ import main
from tests.support.recordings import with_checksum_damage


@pytest.fixture
def copy(recording, tmp_path):
    path = tmp_path / "whole.mcap"
    path.write_bytes(recording.read_bytes())
    return path


@pytest.mark.long
def test_trimmed_part_contains_its_frames_and_can_be_simulated_again(copy, tmp_path):
    before = copy.read_bytes()
    whole = RecordingPlayer(copy)
    save_annotations(copy, Annotations(marks=(Mark(90, "in"), Mark(240, "out")), label="try"))
    result = trim(copy, tmp_path / "part.mcap", first=80, last=150)
    part = RecordingPlayer(tmp_path / "part.mcap")
    assert (result.frames, result.seconds) == (71, pytest.approx(0.35))
    assert [frame.tick for frame in part] == list(range(80, 151))
    assert (
        part.frame(40).pressures.tobytes()
        == whole.frame(whole.number_at(part.times[40] - whole.times[0])).pressures.tobytes()
    )
    assert part.inputs == [item for item in whole.inputs if item[0] <= 150] or len(part.inputs) == sum(
        tick <= 150 for tick, _ in whole.inputs
    )
    assert part.complete, part.damage
    assert part.annotations() == Annotations(marks=(Mark(90, "in"),), label="try")
    assert copy.read_bytes() == before
    checked = verify(part)
    assert checked.identical, checked
    assert part.versions["numpy"] == versions()["numpy"]


def test_trimmed_copy_of_a_damaged_recording_still_reports_missing_parts(copy, tmp_path):
    data = bytearray(copy.read_bytes())
    player = RecordingPlayer(copy)
    chunk = player._contents.chunk(10)
    at = data.find(chunk.data[:64])
    data[at + 70] ^= 0xFF
    copy.write_bytes(bytes(data))
    damaged = RecordingPlayer(copy)
    missing = [one for one in damaged.damage if one.first is not None]
    assert missing
    inside = trim(copy, tmp_path / "inside.mcap", first=missing[0].first - 20, last=missing[0].last + 20)
    part = RecordingPlayer(inside.file)
    assert {(one.kind, one.first, one.last) for one in missing} <= {(x.kind, x.first, x.last) for x in part.damage}
    behind = trim(copy, tmp_path / "before.mcap", last=missing[0].first - 5)
    assert not [one for one in RecordingPlayer(behind.file).damage if one.first is not None]


def test_checksum_damage_is_still_reported_in_the_part(copy, tmp_path, capsys):
    copy.write_bytes(with_checksum_damage(copy.read_bytes()))
    (damage,) = RecordingPlayer(copy).damage
    assert damage.kind is DamageKind.CHECKSUM
    result = trim(copy, tmp_path / "part.mcap", first=80, last=150)
    assert RecordingPlayer(tmp_path / "part.mcap").damage == result.damage == (damage,)
    trim(tmp_path / "part.mcap", tmp_path / "again.mcap", first=90)
    assert RecordingPlayer(tmp_path / "again.mcap").damage == (damage,)
    recover(copy, tmp_path / "recovered.mcap")
    assert RecordingPlayer(tmp_path / "recovered.mcap").damage == (damage,)
    assert main(["trim", str(copy), "-o", str(tmp_path / "trimmed.mcap"), "--json"]) == 0
    output = capsys.readouterr()
    assert "trimmed.mcap: the file does not match its checksum" in output.err
    (row,) = json.loads(output.out)["files"]
    assert row["complete"] is False
    assert row["damage"][0]["kind"] == "checksum"


def test_each_episode_becomes_a_file(copy, tmp_path):
    folder = tmp_path / "new"
    with pytest.raises(RecordingError, match="no episode"):
        trim_episodes(RecordingPlayer(copy), folder)
    assert not folder.exists()
    episodes = (LabelledEpisode(60, 80, "a/b: press"), LabelledEpisode(81, 90, "..", "lift it"))
    save_annotations(copy, Annotations(episodes=episodes))
    written = trim_episodes(RecordingPlayer(copy), folder)
    assert [one.file for one in written] == [str(folder / "01 a b press.mcap"), str(folder / "02 episode.mcap")]
    assert [one.frames for one in written] == [21, 10]
    assert RecordingPlayer(written[1].file).annotations().episodes == episodes[1:]
    assert not annotations_file(written[1].file).exists(), "it is in the file"
    assert episode_file_name(3, LabelledEpisode(0, 1, "x" * 200)) == f"03 {'x' * 80}.mcap"


def test_invalid_range_is_rejected_and_leaves_no_file(copy, tmp_path):
    with pytest.raises(RecordingError, match="no frame in this range"):
        trim(copy, tmp_path / "none.mcap", first=9000)
    with pytest.raises(RecordingError, match="itself"):
        trim(copy, copy)
    (tmp_path / "there.mcap").write_bytes(b"")
    with pytest.raises(RecordingError, match="exists"):
        trim(copy, tmp_path / "there.mcap")
    assert not (tmp_path / "none.mcap").exists()
