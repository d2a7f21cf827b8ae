"""The command line keeps its promises: exit codes, JSON keys, one clear message."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tactile_maps.cli.parser import EXAMPLES, build_parser
from tests.support.command_line import call, result_of
from tests.support.recordings import record, small_arm

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "demo.mcap"
    record(small_arm(), path, ticks=100)
    return path


@pytest.fixture
def ball(tmp_path):
    """A bare mesh: a closed box of twelve triangles."""
    path = tmp_path / "box.obj"
    corners = [(x, y, z) for x in (0, 0.2) for y in (0, 0.1) for z in (0, 0.1)]
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads]
    path.write_text("\n".join(lines))
    return path


def test_help_and_version_are_printed(capsys):
    assert call(capsys, "--version")[1].startswith("tactile-maps 0.")
    status, output, _ = call(capsys, "--help")
    assert status == 0
    assert all(code in output for code in ("130", "143", "129", "131"))
    status, output, _ = call(capsys, "export", "--help")
    assert status == 0
    assert output.index("Recording for other programs") < output.index("options:") < output.index("example:")
    assert "it must not exist" not in output
    assert "a folder must not exist" in " ".join(output.split())


@pytest.mark.parametrize("command", EXAMPLES)
def test_example_of_each_command_can_be_parsed(command):
    assert build_parser().parse_args(EXAMPLES[command].split()).command == command


def test_maps_and_inspection_do_not_import_simulation_control_or_recording():
    """Each takes 0.1 s or more to import; in a fresh interpreter, since this one has them.

    ``scipy.optimize`` is imported when it is first needed, and before a loop sends motion, which must not wait for it.
    """
    code = (
        "import sys, tactile_maps.cli.commands.inspect, tactile_maps.cli.commands.map\n"
        "from tactile_maps.robots.files.mesh_files import placeholder; placeholder()\n"
        "named = ('trimesh', 'collada', 'mcap', 'tactile_maps.control', 'tactile_maps.contacts')\n"
        "named += ('tactile_maps.simulation', 'tactile_maps.learning')\n"
        "print([m for m in sys.modules for name in named if m == name or m.startswith(name + '.')])\n"
        "import tactile_maps.session.session, tactile_maps.recording.player\n"
        "print('scipy.optimize' in sys.modules)\n"
        "import tactile_maps.live.motion.command_loop\n"
        "print('scipy.optimize' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout.split()) == (0, ["[]", "False", "True"]), done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["fly"],
        ["map"],
        ["run", "--for", "-1"],
        ["run", "--for", "soon"],
        ["screenshot", "-o", "x.png", "--size", "big"],
        ["screenshot", "-o", "x.png", "--size", "\u00b2x900"],
        ["recover", "x.mcap"],
        ["map", "arm", "-o", "x.docx"],
        ["map", "arm", "--method", "magic"],
        ["run", "arm", "--scene", "ur5e"],
        ["map", "arm", "--seed", "-1"],
        ["run", "--serve", "--port", "65536"],
        ["map", "arm", "--exact-distances", "0"],
    ],
)
def test_bad_usage_exits_with_2(capsys, words):
    status, out, err = call(capsys, *words)
    assert status == 2
    assert err
    assert "Traceback" not in out + err


@pytest.mark.parametrize("number", [str(2**63), "9" * 20, "9" * 5000], ids=["64 bits", "20 digits", "5000 digits"])
@pytest.mark.parametrize(
    "words",
    [
        ["study", "map-cost", "--seed"],
        ["map", "arm", "--taxels"],
        ["run", "--port"],
        ["export", "x.mcap", "--to", "csv", "-o", "x", "--image-width"],
    ],
    ids=lambda words: " ".join(words),
)
def test_huge_integers_are_rejected_in_one_short_message(capsys, words, number):
    with pytest.raises(SystemExit, match="2"):
        build_parser().parse_args([*words, number])
    last = capsys.readouterr().err.splitlines()[-1]
    assert re.search(rf"argument .*{words[-1]}.*: must be .*: 9", last), last
    assert len(last) < 200


@pytest.mark.parametrize("words", [["--size", "9" * 5000 + "x900"], ["--grid", "9" * 5000 + "x2"]])
def test_huge_sizes_are_rejected_in_one_short_message(capsys, words):
    command = ["screenshot", "-o", "x.png"] if words[0] == "--size" else ["map", "arm"]
    status, _, err = call(capsys, *command, *words)
    assert status == 2
    last = err.splitlines()[-1]
    assert re.search("must be like [0-9]+x[0-9]+.*: 9", last), last
    assert len(last) < 200


@pytest.mark.parametrize("number", ["0", "9223372036854775807", "+3"])
def test_seeds_of_64_bits_are_accepted(number):
    assert build_parser().parse_args(["map", "arm", "--seed", number]).seed == int(number)


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "output"),
    [
        (["inspect", "armm"], "arm"),
        (["inspect", "nowhere.urdf"], "nowhere.urdf"),
        (["run", "--scene", "nowhere"], "arm"),
        (["replay", "nowhere.mcap"], "nowhere.mcap"),
        (["recover", "nowhere.mcap", "-o", "x.mcap"], "nowhere.mcap"),
        (["map", "arm", "--taxels", "0"], "0"),
        (["map", "arm", "--taxels", "-5"], "Choose 1 to 100,000"),
        (["map", "arm", "--cut", "101"], "Choose 0 to 100"),
        (["map", "arm", "--links", "wing"], "wing"),
        (["inspect", "nowhere.npz"], "nowhere.npz"),
    ],
)
def test_failure_exits_with_1_and_one_line(capsys, words, output):
    status, out, err = call(capsys, *words)
    assert status == 1
    assert output in err
    assert len(err.strip().splitlines()) == 1
    assert out == ""


def test_file_that_is_not_a_scene_is_named_with_the_command_for_it(capsys, monkeypatch, ball, recording, tmp_path):
    (tmp_path / "skin.csv").write_text("x,y,z\n")
    for file, text in (
        (ball, "this is a mesh, not a scene.*with --robot"),
        (recording, "this is a recording, not a scene.*to the command replay"),
        (tmp_path / "skin.csv", "this is a taxel file, not a scene.*with --skin"),
    ):
        status, _, err = call(capsys, "run", str(file), "--for", "0.1")
        assert status == 1
        assert re.search(text, err)
    monkeypatch.chdir(tmp_path)
    Path("letter.docx").touch()
    status, _, err = call(capsys, "inspect", "letter.docx")
    assert status == 1
    assert re.search(r"not a robot file \(found: .docx\).*\.urdf", err)
    status, _, err = call(capsys, str(ball))
    assert status == 2
    assert f"tactile-maps gui {ball}" in err
    assert "choose from" not in err


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("x.txt", r"the name of this file must end in \.mcap \(found: \.txt\)\. Choose the name x\.mcap"),
        ("x", r"must end in \.mcap \(found: no file extension\)"),
        (".", "folder of this name"),
    ],
)
def test_recording_that_could_not_be_reopened_is_not_started(capsys, ball, tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    status, _, err = call(capsys, "run", "--robot", str(ball), "--for", "0.1", "-o", name)
    assert status == 1
    assert re.search(message, err)
    assert list(tmp_path.iterdir()) == [ball]


def test_failure_is_printed_as_json(capsys):
    status, out, _ = call(capsys, "inspect", "nowhere.urdf", "--json")
    assert status == 1
    assert "nowhere.urdf" in json.loads(out.splitlines()[-1])["error"]["message"]


@pytest.mark.long
def test_map_prints_its_quality_as_json_and_writes_the_file(capsys, ball, tmp_path):
    target = tmp_path / "map.npz"
    result = result_of(capsys, "map", ball, "-o", target, "--taxels", 60)
    promised = {
        "patches",
        "taxels",
        "coverage",
        "faces",
        "flips",
        "bijective",
        "symmetric_dirichlet",
        "edge_error",
        "stress",
        "trustworthiness",
        "continuity",
        "round_trip_mm",
        "angle",
        "area",
        "seconds",
        "findings",
    }
    assert promised <= set(result)
    assert {"median", "p95", "max"} <= set(result["angle"])
    assert all({"kind", "count", "action"} <= set(finding) for finding in result["findings"])
    assert result["taxels"] == 60
    assert result["flips"] == 0
    assert result["bijective"] is True
    found = result_of(capsys, "inspect", target)
    assert (found["kind"], found["coverage"], found["quality"]["coverage"]) == ("map", 1.0, 1.0)
    assert "100.0 % of the requested surface" in call(capsys, "inspect", target)[1]
    assert call(capsys, "map", ball, "-o", tmp_path / "map.obj", "--taxels", 60)[0] == 0
    assert "vt " in (tmp_path / "map.obj").read_text()


@pytest.mark.long
def test_inspect_describes_a_scene(capsys):
    result = result_of(capsys, "inspect", "arm")
    assert {"kind", "name", "joints", "links", "bodies", "taxels", "patches", "effects", "problems"} <= set(result)
    assert len(result["joints"]) == 7
    assert all({"name", "on", "why", "ms"} <= set(effect) for effect in result["effects"])
    assert all({"kind", "where", "remedy"} <= set(problem) for problem in result["problems"])


def test_inspect_reports_the_problem_of_a_cut_recording(capsys, recording, tmp_path):
    assert result_of(capsys, "inspect", recording)["problems"] == []
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[:-3000])
    (problem,) = result_of(capsys, "inspect", cut)["problems"]
    assert "recover" in problem["remedy"]


@pytest.mark.long
def test_run_records_and_replay_verifies(capsys, ball, tmp_path):
    target = tmp_path / "run.mcap"
    result = result_of(capsys, "run", "--robot", ball, "--for", "0.5", "-o", target)
    promised = {"simulated_s", "wall_s", "real_time_factor", "frames", "taxels", "contacts", "max_force_N", "file"}
    assert promised <= set(result)
    assert result["frames"] == 100
    assert result["max_force_N"] > 0
    assert call(capsys, "run", "--robot", ball, "--for", "0.5", "-o", target)[0] == 1, "it exists already"
    verified = result_of(capsys, "replay", target, "--verify")
    assert verified["identical"] is True
    assert verified["max_difference"] == 0.0
    assert {"frames", "identical", "max_difference"} <= set(result_of(capsys, "replay", target))


def test_recover_reports_frames_and_lost_frames(capsys, recording, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[:-20_000])
    result = result_of(capsys, "recover", cut, "-o", tmp_path / "fixed.mcap")
    assert {"frames", "lost_frames", "file"} <= set(result)
    assert 0 < result["frames"] <= 100


def test_unexpected_problem_leaves_a_log_and_no_traceback(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr("tactile_maps.cli.commands.recordings.recover.execute", lambda _arguments: 1 // 0)
    status, out, err = call(capsys, "recover", "a.mcap", "-o", "b.mcap")
    assert status == 1
    assert "ZeroDivisionError" in err
    assert "Traceback" not in out + err
    (log,) = tmp_path.rglob("crash*.txt")
    assert "Traceback" in log.read_text()


def test_window_without_a_display_names_a_remedy():
    environment = {"PATH": "/usr/bin", "HOME": "/tmp"}
    done = subprocess.run(
        [sys.executable, "-m", "tactile_maps"], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 1
    assert "no display" in done.stderr
    assert "screenshot" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.long
def test_screenshot_of_a_scene_that_cannot_run_gives_one_message(ball, tmp_path):
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv .1 .1 0\nf 1 2 3\nf 2 4 3\n")
    scene = tmp_path / "flat.toml"
    thing = '[[objects]]\nname = "sheet"\nkind = "mesh"\nfile = "sheet.obj"\nat = [1.0, 0.0, 1.0]\nmass = 0.1\n'
    scene.write_text(f'robot = "{ball}"\n{thing}[effects]\ncontact = "environment"\n')
    words = ["screenshot", "--scene", scene, "-o", tmp_path / "x.png"]
    done = subprocess.run([sys.executable, "-m", "tactile_maps", *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "coplanar" in done.stderr
    assert "unexpected" not in done.stderr
    assert not (tmp_path / "x.png").exists()


@pytest.mark.long
def test_screenshot_shows_the_whole_window(capsys, ball, tmp_path):
    """Runs in a separate process, since it opens a window."""
    target = tmp_path / "window.png"
    words = ["screenshot", "--robot", ball, "--at", "0.1", "--size", "1280x800", "-o", target, "--json"]
    done = subprocess.run([sys.executable, "-m", "tactile_maps", *words], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout.splitlines()[-1])["width"] == 1280
    assert target.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_file_name_that_is_not_text_is_escaped_in_output(ball, tmp_path, capsys):
    named = ball.rename(tmp_path / "box\udce9.obj")
    status, _, output = call(capsys, "map", named, "--taxels", "20", "-o", tmp_path / "out.npz")
    assert status == 1
    assert "is not valid UTF-8" in output
    assert not (tmp_path / "out.npz").exists()
