"""``run --sweep``: recordings and their index, gone on with, and what is refused."""

from __future__ import annotations

import csv
import json
import re

import pytest

from tactile_maps.cli.shared import recording_sweep
from tactile_widgets.__main__ import main

SCENE = """
robot = "arm"
[cover]
links = ["hand"]
taxels = 30
[[stimuli]]
kind = "poke"
patch = "hand"
at = [0.5, 0.3]
press = 0.1
"""
SWEEP = "seconds = 0.1\n[vary]\nseed = { from = 0, count = 2 }\nstimuli.0.force = [1.0, 2.0]\n"


@pytest.fixture
def line(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    return ["run", str(tmp_path / "scene.toml"), "--sweep", str(tmp_path / "sweep.toml"), "-o", str(tmp_path / "out")]


def index(tmp_path):
    with (tmp_path / "out" / "index.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_each_variation_is_recorded_once_and_indexed(line, tmp_path, capsys, monkeypatch):
    saved = []

    def stop(text, share):
        saved.append(text)
        if len(saved) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(recording_sweep, "progress_line", lambda: stop)
    assert main(line) == 130
    assert "3 of 4 recordings are complete; continue with the same command and --resume" in capsys.readouterr().err
    assert len(index(tmp_path)) == 3
    (tmp_path / "out" / "000001.mcap").unlink()
    assert main([*line, "--resume", "--json"]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (found["recordings"], found["known"], found["failed"]) == (4, 2, 0), "what is gone is recorded again"
    rows = index(tmp_path)
    assert [row["file"] for row in rows] == [f"{number:06}.mcap" for number in range(4)]
    assert [(row["seed"], row["stimuli.0.force"]) for row in rows] == [
        ("0", "1.0"),
        ("0", "2.0"),
        ("1", "1.0"),
        ("1", "2.0"),
    ]
    assert all((tmp_path / "out" / row["file"]).is_file() for row in rows)
    assert main(line) == 2
    assert "--overwrite replaces all" in capsys.readouterr().err


def test_invalid_setting_is_rejected_before_anything_is_recorded(line, tmp_path, capsys):
    (tmp_path / "sweep.toml").write_text('[vary]\ncontrol.controller = ["qp", "qpp"]\n')
    assert main(line) == 1
    assert "vary.control" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("scene", "vary", "said"),
    [
        ('patch = "nose"', "seed = [0, 1]", r"scene.toml, line 8, stimuli.patch: unknown patch.*nose.*hand"),
        ('patch = "hand"', 'stimuli.0.patch = ["hand", "nose"]', r"sweep.toml, vary.stimuli.0.patch: unknown patch"),
        ('patch = "hand"', "stimuli.0.at = [[9.0, 9.0, 9.0]]", r"sweep.toml, vary.stimuli.0.at: .*not on the skin"),
    ],
)
def test_invalid_stimulus_is_rejected_at_its_key(line, tmp_path, capsys, scene, vary, said):
    (tmp_path / "scene.toml").write_text(SCENE.replace('patch = "hand"', scene))
    (tmp_path / "sweep.toml").write_text(f"seconds = 0.1\n[vary]\n{vary}\n")
    assert main(line) == 1
    assert re.search(said, capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_unknown_patch_replaced_in_every_variation_is_accepted(line, tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE.replace('patch = "hand"', 'patch = "nose"'))
    (tmp_path / "sweep.toml").write_text('seconds = 0.05\n[vary]\nstimuli.0.patch = ["hand"]\n')
    assert main(line) == 0
    assert len(index(tmp_path)) == 1


@pytest.mark.parametrize(
    ("words", "saved"),
    [
        (["run", "poke", "--resume"], "a single recording is made in one process"),
        (["run", "poke", "--sweep", "pokes"], "Add -o DIR"),
        (["run", "poke", "--sweep", "pokes", "-o", "x", "--serve"], "Leave out --serve"),
    ],
)
def test_contradictory_options_are_rejected(words, saved, capsys):
    assert main(words) == 2
    assert saved in capsys.readouterr().err
