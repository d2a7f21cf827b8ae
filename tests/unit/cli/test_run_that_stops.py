"""A run that diverges says so, and leaves a recording that stops again."""

from __future__ import annotations

import json

import pytest

from app.__main__ import main

UNSTEADY = """
robot = "arm"
tick = 0.01
[cover]
links = ["hand"]
taxels = 30
[effects]
integrator = "euler"
timestep = 0.01
gravity = "on"
[control]
stiffness = 40.0
damping_ratio = 3.0
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "unsteady.toml"
    path.write_text(UNSTEADY)
    return str(path)


def test_the_recording_is_named_and_stops_again(scene, tmp_path, capsys):
    target = str(tmp_path / "run.mcap")
    assert main(["run", "--scene", scene, "--for", "5", "-o", target]) == 1
    said = capsys.readouterr().err
    assert "the simulation diverged" in said
    assert "joint" in said
    assert f"replay {target} --verify" in said
    assert "Traceback" not in said
    assert main(["replay", target, "--verify", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["complete"]
    assert found["identical"]
    assert found["stopped_again"]
    assert found["stopped"].split(":")[1] in said
    assert main(["replay", target]) == 0
    assert "the simulation diverged" in capsys.readouterr().out


def test_without_a_recording_it_says_how_to_keep_one(scene, capsys):
    assert main(["run", "--scene", scene, "--for", "5"]) == 1
    assert "--output" in capsys.readouterr().err
