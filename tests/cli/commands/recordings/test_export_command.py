"""``export`` from the command line: what it says, and its exit codes."""

from __future__ import annotations

import json

import pytest

from tactile_maps.cli.main import run_command
from tests.support.recordings import record, small_arm


@pytest.mark.long
def test_size_is_reported_and_existing_file_is_not_overwritten(tmp_path, capsys):
    source = tmp_path / "demo.mcap"
    target = tmp_path / "out.npz"
    record(small_arm(), source, ticks=30)
    words = ["export", str(source), "--to", "npz", "-o", str(target)]
    assert run_command([*words, "--json"], windows={}) == 0
    output = json.loads(capsys.readouterr().out)
    assert (output["frames"], output["complete"], output["bytes"]) == (30, True, target.stat().st_size)
    assert run_command(words, windows={}) == 1
    assert "already exists" in capsys.readouterr().err
    assert run_command([*words, "--overwrite", "--from", "0.05", "--until", "0.1", "--json"], windows={}) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 11
    assert run_command([*words, "--overwrite", "--from", "0.1", "--until", "0.05"], windows={}) == 2


@pytest.mark.long
def test_damaged_recording_is_exported_with_a_warning(tmp_path, capsys):
    source = tmp_path / "demo.mcap"
    record(small_arm(), source, ticks=30)
    source.write_bytes(source.read_bytes()[:-3000])
    assert run_command(["export", str(source), "--to", "csv", "-o", str(tmp_path / "out")], windows={}) == 0
    output = capsys.readouterr()
    assert "warning: the file was cut off" in output.err
    assert "Complete    no" in output.out


def test_unknown_format_is_a_usage_error(tmp_path):
    assert run_command(["export", "x.mcap", "--to", "xls", "-o", str(tmp_path / "x")], windows={}) == 2
