"""``run``: a run that diverges says so and can be seen again; scripts are played, and written by ``replay``."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.cli.commands import run as run_command
from tactile_maps.cli.main import run_command as run_line
from tactile_maps.cli.shared.findings import without_model_notes
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import findings_of
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.stimuli.stimulus_file import load_stimuli, save_stimuli
from tactile_maps.stimuli.stimulus_kinds import Poke
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_widgets.__main__ import main
from tests.support.recordings import record, small_arm

UNSTEADY = """
robot = "arm"
tick = 0.2
[cover]
links = ["hand"]
taxels = 30
[effects]
integrator = "euler"
timestep = 0.02
[control]
stiffness = 40.0
damping_ratio = 3.0
[[stimuli]]
kind = "poke"
patch = "hand"
"""


@pytest.fixture
def steady_scene(tmp_path):
    """A scene that is prepared in a quarter of the time of the shipped one."""
    path = tmp_path / "steady.toml"
    path.write_text('robot = "arm"\n[cover]\nlinks = ["hand"]\ntaxels = 30\n')
    return str(path)


@pytest.fixture
def unsteady_scene(tmp_path):
    path = tmp_path / "unsteady.toml"
    path.write_text(UNSTEADY)
    return str(path)


@pytest.mark.long
def test_recording_of_a_diverged_run_is_named_and_reproduces_the_failure(unsteady_scene, tmp_path, capsys):
    target = str(tmp_path / "run.mcap")
    assert main(["run", "--scene", unsteady_scene, "--for", "5", "-o", target]) == 1
    output = capsys.readouterr().err
    assert "the simulation diverged" in output
    assert "joint" in output
    assert f"replay {target} --verify" in output
    assert "Traceback" not in output
    assert main(["replay", target, "--verify", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["complete"]
    assert found["identical"]
    assert found["stopped_again"]
    assert found["stopped"].split(":")[1] in output
    assert main(["replay", target]) == 0
    assert "the simulation diverged" in capsys.readouterr().out


def test_failed_run_does_not_replace_a_recording_and_names_both(unsteady_scene, tmp_path, capsys):
    target = tmp_path / "run.mcap"
    new = tmp_path / "run.new.mcap"
    target.write_bytes(b"precious")
    assert main(["run", "--scene", unsteady_scene, "--for", "5", "-o", str(target), "--overwrite"]) == 1
    output = capsys.readouterr().err
    assert f"replay {new} --verify" in output
    assert f"{target} is unchanged; the new recording up to here is {new}" in output
    assert target.read_bytes() == b"precious"
    assert main(["replay", str(new), "--verify", "--json"]) == 0


def interrupt_after(monkeypatch, ticks: int) -> None:
    """Press Ctrl-C in the tick of this number."""

    class Interrupted(Session):
        def tick(self):
            frame = super().tick()
            if frame.tick == ticks:
                os.kill(os.getpid(), signal.SIGINT)
            return frame

    monkeypatch.setattr(run_command, "Session", Interrupted)


@pytest.mark.parametrize("json_words", [[], pytest.param(["--json"], marks=pytest.mark.long)])
def test_interrupted_run_does_not_replace_a_recording_and_names_both(
    monkeypatch, steady_scene, tmp_path, capsys, json_words
):
    target = tmp_path / "run.mcap"
    new = tmp_path / "run.new.mcap"
    target.write_bytes(b"precious")
    interrupt_after(monkeypatch, 10)
    assert main(["run", "--scene", steady_scene, "--for", "5", "-o", str(target), "--overwrite", *json_words]) == 130
    output = capsys.readouterr()
    text = f"interrupted; {target} is unchanged; the new recording up to here is {new}"
    assert text in output.err
    assert not json_words or json.loads(output.out)["error"] == {"kind": "Interrupted", "message": text}
    assert target.read_bytes() == b"precious"
    player = RecordingPlayer(new)
    assert player.complete
    assert 0 < len(player) <= 10


def test_duration_below_one_tick_simulates_one_tick(steady_scene, tmp_path):
    target = tmp_path / "short.mcap"
    assert main(["run", "--scene", steady_scene, "--for", "1e-9", "-o", str(target)]) == 0
    assert len(RecordingPlayer(target)) == 1


def test_run_without_a_recording_names_the_option(unsteady_scene, capsys):
    assert main(["run", "--scene", unsteady_scene, "--for", "5"]) == 1
    assert "--output" in capsys.readouterr().err


SCENE = """robot = "arm"
[cover]
links = ["forearm"]
taxels = 150
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return str(path)


def strongest(capsys, *words) -> float:
    assert main(["run", *words, "--for", "0.6", "--json"]) == 0
    return json.loads(capsys.readouterr().out.splitlines()[-1])["max_force_N"]


@pytest.mark.long
def test_given_script_replaces_that_of_the_scene(capsys, scene, tmp_path):
    script = tmp_path / "script.toml"
    save_stimuli([Poke(force=1.5, press=0.1)], script)
    assert strongest(capsys, scene) == 0
    assert strongest(capsys, scene, "--stimuli", str(script)) == pytest.approx(1.5, rel=0.01)


@pytest.mark.long
def test_invalid_script_is_named(capsys, scene, tmp_path):
    script = tmp_path / "script.toml"
    script.write_text('[[stimuli]]\nkind = "pok"\n')
    assert main(["run", scene, "--stimuli", str(script)]) == 1
    assert "line 2, stimuli.kind" in capsys.readouterr().err


@pytest.mark.long
def test_pokes_of_the_user_are_written_as_a_script(capsys, tmp_path):
    recording = tmp_path / "demo.mcap"
    script = tmp_path / "script.toml"
    record(small_arm(), recording, ticks=160)
    assert main(["replay", str(recording), "--stimuli", str(script)]) == 0
    assert "1, written to" in capsys.readouterr().out
    (touch,) = load_stimuli(script)
    assert touch.kind == "path"
    assert touch.points[-1][0] == pytest.approx(0.65, abs=0.005), "from tick 20 to tick 150"
    assert main(["replay", str(recording), "--stimuli", str(script)]) == 1, "nothing is overwritten"
    assert "already" in capsys.readouterr().err


def test_recording_without_pokes_is_rejected(capsys, tmp_path):
    recording = tmp_path / "still.mcap"
    record(small_arm(), recording, ticks=10)
    assert main(["replay", str(recording), "--stimuli", str(tmp_path / "script.toml")]) == 1
    assert "contains no pokes" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.parametrize("script", ["", '[[stimuli]]\nkind = "poke"\npatch = "hand"\nat = [0.5, 0.5]\n'])
def test_fingers_are_simulated_only_for_a_script(monkeypatch, capsys, tmp_path, script):
    path = tmp_path / "scene.toml"
    seen = []
    path.write_text(f'robot = "arm"\n[cover]\nlinks = ["hand"]\ntaxels = 30\n{script}')

    def session(prepared, **output):
        seen.append(Session(prepared, **output))
        return seen[0]

    monkeypatch.setattr(run_command, "Session", session)
    target = str(tmp_path / "run.mcap")
    assert main(["run", "--scene", str(path), "--for", "0.1", "-o", target]) == 0
    assert seen[0].effects.fingers == bool(script)
    assert main(["replay", target, "--verify"]) == 0
    assert "bit for bit" in capsys.readouterr().out


PRESSED_IN = """
robot = "arm"
task = "slide"
[cover]
links = ["hand"]
taxels = 30
[layer]
stiffness = 100
[[objects]]
name = "block"
kind = "box"
size = [0.2, 0.2, 0.2]
at = [0.55, 0.0, 0.7]
"""


def test_deviations_of_contacts_are_noted_once(tmp_path, capsys):
    path = tmp_path / "pressed.toml"
    path.write_text(PRESSED_IN)
    assert main(["run", "--scene", str(path), "--for", "0.1", "--json"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)["notes"]
    assert [note["kind"] for note in found if "block" in note["bodies"]].count("deep") >= 1
    assert len({json.dumps(note) for note in found}) == len(found)
    assert "block is deep in" in printed.err


def test_note_states_the_ratio_that_deviates_most(monkeypatch, tmp_path, capsys):
    path = tmp_path / "pressed.toml"
    path.write_text(PRESSED_IN)
    ratios = iter([1.05, 1.3, 0.9])
    tick = Session.tick

    def bent(session):
        return replace(tick(session), notes=(ContactNote(ContactNoteKind.BENT_SKIN, ("hand",), ratio=next(ratios)),))

    monkeypatch.setattr(Session, "tick", bent)
    assert main(["run", "--scene", str(path), "--for", "0.015", "--json"]) == 0
    (note,) = json.loads(capsys.readouterr().out)["notes"]
    assert note["ratio"] == 1.3


def test_every_finding_of_the_prepared_scene_is_printed_once(tmp_path, capsys):
    path = tmp_path / "pressed.toml"
    path.write_text(PRESSED_IN)
    findings = findings_of(prepare_cached(load_scene(str(path))))
    assert {"starts-inside", "collision-shape"} <= {finding.kind for finding in findings}
    assert main(["run", "--scene", str(path), "--for", "0.01", "--json"]) == 0
    printed = capsys.readouterr()
    for finding in without_model_notes(findings):
        line = f"{finding.kind.replace('-', ' ')}, {finding.where}: {finding.action}"
        assert printed.err.count(line) == 1
    problems = json.loads(printed.out)["problems"]
    assert [(problem["kind"], problem["where"]) for problem in problems] == [(f.kind, f.where) for f in findings]


BENT = """
robot = "arm"
[cover]
links = ["hand"]
taxels = 100
[effects]
skin = "foundation"
gravity = "off"
timestep = 0.0005
[[objects]]
name = "ball"
kind = "sphere"
size = [0.03]
at = [0.4906, 0.2104, 0.598]
"""


@pytest.mark.long
def test_extreme_ratio_of_readings_to_force_on_curved_skin_is_stated(tmp_path, capsys):
    path = tmp_path / "bent.toml"
    path.write_text(BENT)
    assert main(["run", "--scene", str(path), "--for", "0.2", "--json"]) == 0
    printed = capsys.readouterr()
    (note,) = (note for note in json.loads(printed.out)["notes"] if note["kind"] == "bent-skin")
    session = Session(prepare_cached(load_scene(str(path))))
    frames = [session.tick() for _ in range(40)]
    ratios = [each.ratio for frame in frames for each in frame.notes if each.kind is ContactNoteKind.BENT_SKIN]
    assert np.ptp(ratios) > 1e-3
    assert note == {"kind": "bent-skin", "bodies": ["ball", "hand"], "ratio": min(ratios)}
    assert f"the readings sum to {min(ratios):.3f} of the force" in printed.err


@pytest.mark.long
@pytest.mark.parametrize("exists", [True, False])
def test_run_that_cannot_start_leaves_no_recording(capsys, tmp_path, exists):
    path = tmp_path / "x.mcap"
    if exists:
        path.write_bytes(b"precious")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        words = ["run", "arm", "--for", "0.1", "--serve", "--port", str(taken.getsockname()[1])]
        assert run_line([*words, "-o", str(path), "--overwrite"], windows={}) == 1
    assert "port" in capsys.readouterr().err
    assert [(one.name, one.read_bytes()) for one in tmp_path.iterdir()] == ([("x.mcap", b"precious")] if exists else [])


@pytest.mark.long
def test_served_run_prints_its_address_and_follows_real_time(capsys):
    words = ["run", "--scene", "arm", "--for", "0.1", "--serve", "--port", "0"]
    assert run_line([*words, "--json"], windows={}) == 0
    captured = capsys.readouterr()
    assert "at ws://127.0.0.1:" in captured.err
    assert "network" not in captured.err
    assert json.loads(captured.out)["real_time_factor"] <= 1.01
    assert run_line([*words, "--host", "0.0.0.0"], windows={}) == 0
    assert "on the network can watch" in capsys.readouterr().err


@pytest.mark.long
def test_covered_links_are_listed(tmp_path, capsys):
    scene = tmp_path / "arm.toml"
    scene.write_text('robot = "arm"\n[cover]\nlinks = ["hand", "forearm"]\ntaxels = 200\n')
    assert main(["run", "--scene", str(scene), "--for", "0.01"]) == 0
    output = capsys.readouterr().out
    assert re.search(r"Taxels +200 on forearm \(\d+\), hand \(\d+\)", output)
    assert main(["run", "--scene", str(scene), "--for", "0.01", "--json"]) == 0
    links = json.loads(capsys.readouterr().out)["links"]
    assert set(links) == {"forearm", "hand"}
    assert sum(links.values()) == 200
