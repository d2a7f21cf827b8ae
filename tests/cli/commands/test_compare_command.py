"""``tactile-maps compare``: exit codes, words, keys and the file."""

from __future__ import annotations

import csv
import json
from functools import cache

import pytest

from tactile_maps.cli.commands.compare import _cell, _controller_names
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SimulationError, UsageError
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.__main__ import main
from tests.support.recordings import small_arm

SCENE = """robot = "arm"
[cover]
links = ["forearm"]
taxels = 120
[control]
force_goal = 2.0
[[stimuli]]
kind = "poke"
patch = "forearm"
"""
UNSTEADY = SCENE.replace("force_goal = 2.0", "stiffness = 40.0\ndamping_ratio = 3.0").replace(
    "[cover]", 'tick = 0.2\n[effects]\nintegrator = "euler"\ntimestep = 0.02\n[cover]'
)
"""Explicit damping of that strength swings up within a control tick."""
SHORT = ["--for", "0.4"]


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return str(path)


@cache
def arm():
    return small_arm()


@pytest.fixture
def recording(tmp_path):
    """Impedance is touched; the goal becomes 5 N after the finger has met the arm of other controllers (tick 56)."""
    session = Session(arm(), scripted=False)
    path = tmp_path / "touched.mcap"
    with Recorder(session.prepared, path) as recorder:
        session.submit(PokePressed(1, arm().skin.taxel_point(60)))
        for tick in range(100):
            if tick == 80:
                session.submit(ControlChanged(ControlSettings(force_goal=5.0)))
            recorder.write(session.tick(), session.inputs)
    return str(path)


def result_of(capsys):
    return json.loads(capsys.readouterr().out.splitlines()[-1])


@pytest.mark.long
def test_script_of_a_scene_gives_a_figure_for_each_controller(capsys, scene):
    assert main(["compare", scene, "--controllers", "hybrid,qp", "--task", "hold_point", "--json", *SHORT]) == 0
    result = result_of(capsys)
    assert list(result["controllers"]) == ["hybrid", "qp"]
    assert result["seconds"] == 0.4
    assert (result["stopped"], result["file"]) == ({}, None)
    for figures in result["controllers"].values():
        assert figures["seconds"] == pytest.approx(0.4)
        assert figures["force_max_N"] > 0
        assert figures["map_rms_mm"] is not None


@pytest.mark.long
def test_equal_controllers_of_two_runs_give_equal_figures(capsys, scene):
    found = []
    for controllers in ("hybrid,qp", "qp,hybrid"):
        assert main(["compare", scene, "--controllers", controllers, "--json", *SHORT]) == 0
        figures = result_of(capsys)["controllers"]["hybrid"]
        found.append({name: value for name, value in figures.items() if not name.startswith("control")})
    assert found[0] == found[1]


@pytest.mark.long
def test_recording_is_run_for_its_duration_with_its_task(capsys, recording, tmp_path):
    folder = tmp_path / "out" / "here"
    assert main(["compare", recording, "--controllers", "hybrid, parallel", "-o", str(folder)]) == 0
    output = capsys.readouterr().out
    assert "ask, path and force goal of the recording were kept; its controller and gains were replaced" in output
    assert str(folder / "controllers.csv") in output
    page = (folder / "controllers.html").read_text(encoding="utf8")
    assert "<td>parallel</td>" in page
    assert "<h2>Force</h2><svg" in page
    with (folder / "controllers.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [
        sum(row["controller"] == controller for row in rows) for controller in ("hybrid", "parallel", "impedance")
    ] == [100, 100, 0]
    goals = [float(row["force_goal_N"]) for row in rows if row["controller"] == "hybrid" and row["force_goal_N"]]
    assert {goals[0], goals[-1]} == {3.0, 5.0}


@pytest.mark.long
def test_printed_table_has_a_row_for_each_controller(capsys, scene):
    assert main(["compare", scene, "--controllers", "impedance,hold_force", "--for", "0.04"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert all(title in head for title in ("map mm", "force N", "lost", "max N", "main limit"))
    assert [row.split()[0] for row in rows] == ["impedance", "hold_force"]
    assert rows[0].split()[1] == "-", "it has no place to be off from"
    assert all("0.0 %" in row for row in rows), "no limit keeps it from its goal"


@pytest.mark.parametrize(("column", "text"), [("limited", "25.0 %"), ("lost", "25.0 %"), ("energy_J", "0.25")])
def test_shares_of_the_time_are_printed_in_percent(column, text):
    assert _cell(column, 0.25) == text


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "output"),
    [
        (["--controllers", "hybri"], "hybrid"),
        (["--controllers", "qp,qp"], "each once"),
        (["--controllers", ","], "each once"),
        (["--controllers", "qp", "--task", "dance"], "unknown task"),
        ([], "--controllers"),
        (["--controllers", "qp", "--for", "-1"], "above 0"),
    ],
)
def test_usage_error_lists_the_choices(capsys, words, output):
    assert main(["compare", "slide", *words]) == 2
    assert output in capsys.readouterr().err


def test_controllers_may_be_separated_by_spaces_and_end_in_a_comma():
    assert _controller_names("hybrid, qp, ") == ["hybrid", "qp"]
    with pytest.raises(UsageError, match="each once"):
        _controller_names(" , ")


def test_unusable_files_end_with_1(capsys, scene, tmp_path):
    assert main(["compare", "nowhere", "--controllers", "qp"]) == 1
    assert "nowhere" in capsys.readouterr().err
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(b"nothing")
    assert main(["compare", str(torn), "--controllers", "qp"]) == 1
    assert "torn.mcap" in capsys.readouterr().err
    assert main(["compare", scene, "--controllers", "qp", *SHORT, "-o", str(torn / "below")]) == 1
    assert "cannot be created" in capsys.readouterr().err


@pytest.mark.long
def test_failed_controller_is_named_and_sets_the_exit_code(capsys, tmp_path):
    path = tmp_path / "unsteady.toml"
    path.write_text(UNSTEADY)
    assert main(["compare", str(path), "--controllers", "impedance,hold_force", "--for", "2", "--json"]) == 1
    assert "diverged" in result_of(capsys)["stopped"]["impedance"]
    assert main(["compare", str(path), "--controllers", "impedance", "--for", "2"]) == 1
    assert "impedance stopped in its first tick: joint " in capsys.readouterr().out


def test_time_at_which_a_controller_stopped_is_printed(capsys, scene, monkeypatch):
    tick = Session.tick

    def fail(session):
        if session.frame.tick == 3:
            raise SimulationError("the simulation diverged")
        return tick(session)

    monkeypatch.setattr(Session, "tick", fail)
    assert main(["compare", scene, "--controllers", "impedance", *SHORT]) == 1
    assert "impedance stopped after 0.015 s: the simulation diverged" in capsys.readouterr().out


def test_stimulus_on_an_unknown_patch_is_located_in_the_scene(scene, capsys):
    with open(scene, "w", encoding="utf8") as file:
        file.write(SCENE.replace('patch = "forearm"', 'patch = "nose"'))
    assert main(["compare", scene, "--controllers", "impedance,hybrid", *SHORT]) == 1
    message = capsys.readouterr().err
    assert "small.toml, line 9, stimuli.patch: unknown patch (found: nose). Choose one of: forearm" in message
