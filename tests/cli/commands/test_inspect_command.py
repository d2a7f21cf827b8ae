"""``inspect SCENE``: what is on, why, what it costs, what is in it and what it lacks."""

from __future__ import annotations

import json

import pytest

from tactile_maps.cli.commands import inspect
from tactile_maps.cli.main import run_command
from tactile_maps.recording.encoding.annotations import (
    Annotations,
    LabelledEpisode,
    Mark,
    annotations_file,
    save_annotations,
)
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin import mesh_skin
from tactile_widgets.__main__ import main
from tests.support.command_line import call, result_of
from tests.support.generated_robots import arm
from tests.support.hollows import hollow
from tests.support.recordings import record, small_arm
from tests.support.scene_objects import thing

SCENE = """robot = "arm"
task = "slide"
[cover]
links = ["hand"]
taxels = 40
[[objects]]
name = "wall"
kind = "box"
size = [0.1, 0.1, 0.1]
at = [2, 0, 0]
[effects]
friction = "off"
noise = { sd = 50 }
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(SCENE)
    return path


@pytest.mark.long
def test_result_is_written_as_json_and_as_a_page(capsys, scene, tmp_path):
    status, out, _ = call(capsys, "inspect", scene, "--costs", "--json", "--report", tmp_path / "page.html")
    assert status == 0
    page = (tmp_path / "page.html").read_text(encoding="utf8")
    assert "<td>slide</td>" in page
    assert "<h2>Effects</h2>" in page
    result = json.loads(out.splitlines()[-1])
    assert result["kind"] == "scene"
    assert (result["task"], result["outputs"]) == ("slide", ["posture", "pressure", "force"])
    assert result["objects"] == [{"name": "wall", "kind": "box", "mass": 0.0, "at": [2.0, 0.0, 0.0]}]
    assert result["controllable"] == {"hand": 1.0}
    assert 1.0 < result["reach"] < 1.2
    assert 1 < result["inertia_ratio"] < 1000
    elbow = next(row for row in result["limits"] if row["joint"] == "elbow_pitch")
    assert (elbow["home"], elbow["upper"], elbow["max_speed"], elbow["max_effort"]) == (1.45, 2.35, None, None)
    assert "<h2>Limits of the joints</h2>" in page
    (row,) = result["collision"]
    assert (row["link"], row["shape"]) == ("hand", "hull")
    assert 0 <= row["usual_mm"] <= row["largest_mm"] < 1
    effects = {effect["name"]: effect for effect in result["effects"]}
    assert list(effects) == list(EFFECTS)
    assert effects["contact"]["value"] == "environment"
    assert "wall" in effects["contact"]["why"]
    assert effects["skin"]["ms"] > 0
    assert effects["noise"]["ms"] > 0
    assert effects["noise"]["overridden"]
    assert (effects["friction"]["on"], effects["friction"]["ms"]) == (False, None)
    problem, shape = result["problems"]
    assert (shape["kind"], shape["where"]) == ("collision-shape", "hand")
    assert "mm above the bare link next to its skin" in shape["remedy"]
    assert 2 < row["bare_mm"] < 4
    assert problem["kind"] == "scene-warning"
    assert problem["where"] == "effects.friction"
    assert "friction on" in problem["remedy"]


@pytest.mark.long
def test_result_is_printed_as_text(capsys, scene):
    status, out, _ = call(capsys, "inspect", scene)
    assert status == 0
    lines = out.splitlines()
    on = lines.index("On:")
    off = lines.index("Off:")
    (skin,) = [line for line in lines[on:off] if line.strip().startswith("Skin ")]
    assert "water-fill" in skin
    assert " ms " not in skin
    assert "--costs" in lines[-3]
    assert any(line.strip().startswith("Friction") and "set by the scene" in line for line in lines[off:])
    assert any("wall (box)" in line for line in lines[:on])
    assert any(line.startswith("Force control  100 % of hand at home") for line in lines[:on])
    assert any(line.split()[:4] == ["elbow_pitch", "1.450", "rad", "-2.35"] for line in lines)
    assert any("scene-warning" in line for line in lines[off:])


def test_invalid_file_gives_one_message_with_its_line_number(capsys, scene):
    scene.write_text(SCENE.replace("friction", "frction"))
    status, out, err = call(capsys, "inspect", scene)
    assert (status, out) == (1, "")
    assert len(err.strip().splitlines()) == 1
    assert "own.toml, line 12, effects.frction" in err
    assert "Did you mean friction" in err


@pytest.mark.parametrize("command", ["inspect", "run"])
def test_unknown_patch_of_a_stimulus_is_named_with_its_line(capsys, scene, command):
    scene.write_text(SCENE + "[[stimuli]]\nkind = 'poke'\npatch = 'nose'\n")
    status, _, err = call(capsys, command, scene)
    assert status == 1
    assert "own.toml, line 16, stimuli.patch: unknown patch (found: nose). Choose one of: hand" in err


def test_run_warns_of_missing_parts(capsys, scene):
    status, out, err = call(capsys, "run", scene, "--for", "0.02", "--json")
    assert status == 0
    assert "warning: effects.friction: The task is to slide" in err
    problems = json.loads(out.splitlines()[-1])["problems"]
    assert [problem["where"] for problem in problems if problem["kind"] == "scene-warning"] == ["effects.friction"]


def test_missing_plugins_are_reported(capsys):
    assert main(["inspect", "--plugins"]) == 0
    assert "No plug-ins" in capsys.readouterr().out


def test_misspelt_kind_of_a_package_is_reported(tmp_path, monkeypatch, capsys):
    info = tmp_path / "other-2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text("[tactile_maps.map_method]\nflat = other_module:METHOD\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert main(["inspect", "--plugins", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["plugins"]
    assert (row["package"], row["version"], row["state"]) == ("other", "2.0", "left out")
    assert "Did you mean map_methods?" in row["problem"]
    assert main(["inspect", "--plugins"]) == 0
    assert "map_method  flat  other 2.0  left out: there is no kind map_method" in capsys.readouterr().out


def test_inspect_with_no_or_two_arguments_is_a_usage_error(capsys):
    assert main(["inspect"]) == 2
    assert main(["inspect", "arm", "--plugins"]) == 2
    assert main(["inspect", "--plugins", "--report", "x.html"]) == 2
    assert "Give one file or name, or --plugins alone" in capsys.readouterr().err


@pytest.mark.long
def test_marks_and_labels_of_a_recording_are_listed(tmp_path, capsys):
    path = tmp_path / "demo.mcap"
    record(small_arm(), path, ticks=30)
    save_annotations(path, Annotations((Mark(10, "touch"),), (LabelledEpisode(5, 15, "press"),)))
    assert run_command(["inspect", str(path), "--json"], windows={}) == 0
    output = json.loads(capsys.readouterr().out)
    assert (output["marks"], output["episodes"]) == (["touch at 0.05 s"], ["press, 0.02 to 0.07 s"])
    annotations_file(path).write_text("{}")
    run_command(["inspect", str(path), "--json"], windows={})
    assert "demo.notes.json" in json.loads(capsys.readouterr().out)["problems"][0]["where"]


@pytest.mark.long
def test_collision_shapes_of_links_with_hollow_skin_are_listed(capsys):
    """Pieces are made only where something may touch."""
    robot, skin = hollow("groove")
    objects = (thing("sphere", at=(0.0, 0.0, 0.5), mass=0.1).spec,)
    for contact, shape, largest in (("environment", "pieces", 0.6), ("off", "hull", 30.0)):
        scene = Scene(name="groove", robot="groove", objects=objects, overrides={"contact": contact})
        prepared = PreparedScene(scene, robot, skin, None, ())
        (row,), findings = inspect._collision(prepared)
        assert (row["link"], row["shape"].split()[-1]) == ("block", shape)
        assert largest / 10 < row["largest_mm"] < largest
        assert [finding.kind for finding in findings] == ["collision-shape"] * (shape == "hull")
        inspect._print_collision([row])
        assert f"block                   {row['shape']}" in capsys.readouterr().out


def test_link_without_joints_has_no_reach(capsys, tmp_path):
    path = tmp_path / "block.xml"
    path.write_text('<mujoco><worldbody><body name="block"><geom size="0.1"/></body></worldbody></mujoco>')
    status, out, _ = call(capsys, "inspect", path)
    assert status == 0
    assert "block" in out
    assert "None" not in out


@pytest.mark.long
def test_limits_of_a_robot_are_listed(capsys, tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(arm(1.0, extra='<actuator><motor joint="joint2" gear="4" ctrlrange="-3 3"/></actuator>'))
    status, out, _ = call(capsys, "inspect", path)
    assert status == 0
    lines = out.splitlines()
    assert any(line.split()[0] == "joint1" and line.endswith("- N m") for line in lines if line.startswith("  "))
    assert any(line.split()[0] == "joint2" and line.endswith("12 N m") for line in lines if line.startswith("  "))
    assert any(line.startswith("Reach          1.1") for line in lines)
    assert any(line.startswith("Inertia ratio") for line in lines)
    assert any("home-chosen" in line for line in lines)


TETRAHEDRON = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def test_inspect_and_map_list_the_same_repairs_of_a_mesh(capsys, tmp_path):
    mesh = tmp_path / "pad.obj"
    mesh.write_text(TETRAHEDRON + "f 1 1 2\n")
    problems = result_of(capsys, "inspect", mesh)["problems"]
    assert [problem["kind"] for problem in problems] == ["units", "zero-area-face"]
    made = result_of(capsys, "map", mesh, "--taxels", 20)["findings"]
    assert [[p["kind"], p["where"], p["remedy"], p["count"]] for p in problems] == [
        [f["kind"], f["where"], f["action"], f["count"]] for f in made if f["kind"] != "seam-added"
    ]


def test_problems_of_a_mesh_are_listed_without_placing_taxels(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_skin, "place_taxels", lambda *_: pytest.fail("taxels were placed"))
    mesh = tmp_path / "pad.obj"
    mesh.write_text(TETRAHEDRON + "f 1 1 2\n")
    assert "zero-area-face" in [one["kind"] for one in result_of(capsys, "inspect", mesh)["problems"]]


def test_mesh_too_small_for_taxels_is_described_with_the_problem(capsys, tmp_path):
    mesh = tmp_path / "shreds.obj"
    corners = [f"v {number} 0 0\nv {number}.01 0 0\nv {number} 0.01 0\n" for number in range(3000)]
    mesh.write_text("".join(corners) + "".join(f"f {3 * n + 1} {3 * n + 2} {3 * n + 3}\n" for n in range(3000)))
    (problem,) = [one for one in result_of(capsys, "inspect", mesh)["problems"] if one["kind"] == "no-taxels"]
    assert problem["where"] == "no piece of the mesh is large enough for a taxel"
    assert "Place more taxels" in problem["remedy"]


def test_faces_with_fewer_than_three_corners_are_counted_with_the_first_line(capsys, tmp_path):
    mesh = tmp_path / "pad.obj"
    mesh.write_text(TETRAHEDRON + "f 1 2\nf 3\n")
    (problem,) = [one for one in result_of(capsys, "inspect", mesh)["problems"] if one["kind"] == "short-face"]
    assert problem["count"] == 2
    assert problem["remedy"] == "fewer than three corners, dropped; the first is in line 9"
    assert "short-face" in [one["kind"] for one in result_of(capsys, "map", mesh, "--taxels", 20)["findings"]]


@pytest.mark.parametrize("command", ["inspect", "map"])
def test_unknown_vertex_of_a_mesh_gives_one_line_in_both_commands(capsys, tmp_path, command):
    mesh = tmp_path / "pad.obj"
    mesh.write_text(TETRAHEDRON + "f 0 1 2\n")
    status, _, err = call(capsys, command, mesh)
    assert status == 1
    assert len(err.strip().splitlines()) == 1
    assert "pad.obj, line 9: a face names a vertex that is not among the 4 of the file (found: 0). Number" in err
