"""``tactile-maps budget``: bad usage, and a proposal that a scene's file takes."""

from __future__ import annotations

import json

import pytest

from tactile_maps.cli.commands.budget import scene_lines
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.studies.budget.proposal import Cost, Option, Proposal
from tactile_maps.studies.study.work_precision import Setting, Trial
from tactile_widgets.__main__ import main

SCENE = """robot = "arm"
[cover]
links = ["forearm"]
taxels = 150
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize(
    ("words", "output"),
    [([], "--milliseconds, or --millimetres"), (["--milliseconds", "-1"], "above 0"), (["--newtons", "x"], "newtons")],
)
def test_invalid_arguments_are_usage_errors(capsys, scene, words, output):
    assert main(["budget", str(scene), *words]) == 2
    assert output in capsys.readouterr().err


def test_printed_lines_apply_effects_controller_and_task(scene):
    """Same as *Apply* in the window: a controller that is fast along a path does not suit another task."""
    step = Option(Trial(Setting("simulation", "discrete", {"timestep_ms": 0.5}), "", 1.0, {}), Cost(1.0))
    touch = Option(Trial(Setting("touch", "half-space"), "", 1.0, {}), Cost(1.0))
    found = Proposal({"simulation": step, "touch": touch}, Cost(2.0), Cost(2.0))
    path = Trial(Setting("control", "qp", {"path_speed_mm_s": 40.0}), "", 1e3, {})
    scene.write_text(SCENE + "\n".join(scene_lines(found, path)) + "\n")
    taken = load_scene(scene)
    assert (taken.effects.integrator, taken.effects.timestep, taken.effects.skin) == ("discrete", 0.0005, "half-space")
    assert taken.control == {"controller": "qp", "task": "follow_path", "path_speed": 0.04}
    scene.write_text(SCENE + "\n".join(scene_lines(found, None)) + "\n")
    assert not load_scene(scene).control, "a limit of time leaves the controller alone"


@pytest.mark.long
def test_printed_lines_are_valid_in_a_scene(capsys, scene):
    assert main(["budget", str(scene), "--milliseconds", "2"]) == 0
    out = capsys.readouterr().out
    assert "ms a tick; off by" in out
    assert "ms predicted" in out
    assert "in the current scene." in out
    lines = out[out.index("[effects]") : out.index("The image")]
    scene.write_text(SCENE + lines)
    taken = load_scene(scene)
    assert taken.effects.integrator
    assert main(["budget", str(scene), "--milliseconds", "2", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert printed["cost"]["milliseconds"] <= 2
    assert set(printed["settings"]) == {"simulation", "touch", "image"}
    assert min(printed["measured_ms"], printed["now_ms"]) > 0


@pytest.mark.long
def test_budget_out_of_reach_names_the_nearest(capsys, scene):
    assert main(["budget", str(scene), "--milliseconds", "0.0001"]) == 1
    assert "The nearest settings need" in capsys.readouterr().err
