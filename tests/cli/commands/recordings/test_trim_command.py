"""``trim`` from the command line: a part, episodes, and what cannot be."""

from __future__ import annotations

import json
import shutil

import pytest

from tactile_maps.cli.main import run_command
from tactile_maps.recording.encoding.annotations import Annotations, LabelledEpisode, save_annotations
from tactile_maps.recording.player import RecordingPlayer
from tests.support.recordings import record, small_arm


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    path = tmp_path_factory.mktemp("trim") / "demo.mcap"
    record(small_arm(), path, ticks=40)
    save_annotations(path, Annotations(episodes=(LabelledEpisode(5, 14, "one"), LabelledEpisode(20, 24, "two"))))
    return str(path)


@pytest.mark.long
def test_range_in_seconds_is_written_as_a_part(source, tmp_path, capsys):
    target = tmp_path / "part.mcap"
    words = ["trim", source, "-o", str(target), "--from", "0.05", "--to", "0.1", "--json"]
    assert run_command(words, windows={}) == 0
    (output,) = json.loads(capsys.readouterr().out)["files"]
    assert (output["file"], output["frames"]) == (str(target), 11)
    assert len(RecordingPlayer(target)) == 11
    assert run_command(words, windows={}) == 1
    assert "already exists" in capsys.readouterr().err


@pytest.mark.long
def test_each_episode_is_written_as_a_part(source, tmp_path, capsys):
    assert run_command(["trim", source, "--episodes", "-o", str(tmp_path / "new")], windows={}) == 0
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["01 one.mcap", "02 two.mcap"]
    assert "5 frames" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "status"),
    [(["--episodes", "--to", "1"], 2), (["--from", "2", "--to", "1"], 2)],
)
def test_invalid_options_are_rejected(source, tmp_path, words, status, capsys):
    assert run_command(["trim", source, "-o", str(tmp_path / "x.mcap"), *words], windows={}) == status
    assert capsys.readouterr().err
    assert not (tmp_path / "x.mcap").exists()


def test_part_after_the_end_is_rejected_with_the_possible_range(source, tmp_path, capsys):
    assert run_command(["trim", source, "-o", str(tmp_path / "x.mcap"), "--from", "90"], windows={}) == 1
    duration = RecordingPlayer(source).duration
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "90 s" in line]
    assert f"which is {duration} s long (found: 90 s). Give --from a time from 0 to {duration}." in line
    assert not (tmp_path / "x.mcap").exists()


def test_part_beyond_the_end_ends_with_the_recording_and_a_warning(source, tmp_path, capsys):
    words = ["trim", source, "-o", str(tmp_path / "x.mcap"), "--from", "0.1", "--to"]
    player = RecordingPlayer(source)
    assert run_command([*words, "90"], windows={}) == 0
    assert f"at which the part ends: {player.duration} s" in capsys.readouterr().err
    assert RecordingPlayer(tmp_path / "x.mcap").frame(-1).tick == player.frame(-1).tick
    assert run_command([*words, str(player.duration), "--overwrite"], windows={}) == 0
    assert not capsys.readouterr().err


def test_recording_without_episodes_leaves_no_folder(source, tmp_path, capsys):
    copy = tmp_path / "plain.mcap"
    shutil.copy(source, copy)
    assert run_command(["trim", str(copy), "--episodes", "-o", str(tmp_path / "new")], windows={}) == 1
    assert "no episode of the recording is labelled" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [copy]
