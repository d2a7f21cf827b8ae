"""``map`` from every kind of input to every kind of output, compared and learned."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tactile_maps.cli.commands.inspect import describe
from tactile_maps.cli.commands.map import print_quality
from tactile_maps.cli.main import run_command
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.distortion import DistortionSummary
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.formats.export import ENDINGS
from tactile_maps.skin.formats.icub.layout import IcubLayout, LayoutModule
from tests.support.command_line import call, result_of
from tests.support.example_taxels import write_icub_layout
from tests.support.surfaces import sheet, skin_of

FEW = ("--taxels", "60")
GRID = ("--grid", "4x6", "--from=-30,-20,90", "--to=30,20,90")


@pytest.fixture(scope="module")
def cap(tmp_path_factory) -> Path:
    """A shallow bowl, in millimetres as mesh files often are."""
    path = tmp_path_factory.mktemp("mesh") / "cap.obj"
    ball = trimesh.creation.icosphere(subdivisions=2, radius=100.0)
    ball.update_faces(ball.triangles_center[:, 2] > 40.0)
    ball.export(path)
    return path


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("ending", ENDINGS)
def test_every_output_format_is_written(capsys, cap, tmp_path, ending):
    target = tmp_path / f"map{ending}"
    assert result_of(capsys, "map", cap, *FEW, "-o", target)["file"] == str(target)
    assert target.stat().st_size > 500
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.long
def test_units_of_millimetres_are_detected(capsys, cap):
    result = result_of(capsys, "map", cap, *FEW)
    assert "units" in {finding["kind"] for finding in result["findings"]}


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "words",
    [
        ("--pitch", 20),
        ("--pitch", 20, "--pattern", "hexagonal"),
        ("--pitch", 20, "--density", "curvature"),
        ("--pitch", 20, "--keep-border", 20),
        ("--surface", "cover", *FEW),
        ("--method", "lscm", *FEW),
        ("--lengths", 0.2, *FEW),
        ("--cut", 1, *FEW),
    ],
)
def test_options_take_effect(capsys, cap, words):
    result = result_of(capsys, "map", cap, *words)
    assert result["bijective"]
    assert result["taxels"] > 10


@pytest.mark.long
def test_unwrapped_obj_is_read_as_a_map(capsys, cap, tmp_path):
    skin = tmp_path / "map.npz"
    obj = tmp_path / "map.obj"
    first = result_of(capsys, "map", cap, *FEW, "-o", skin)
    result_of(capsys, "map", skin, "-o", obj)
    again = result_of(capsys, "map", skin, "--uv", obj)
    assert again["bijective"]
    assert again["symmetric_dirichlet"] == pytest.approx(first["symmetric_dirichlet"], rel=1e-6)


@pytest.mark.long
def test_two_maps_are_compared(capsys, cap, tmp_path):
    other = tmp_path / "tutte.npz"
    skin = tmp_path / "skin.npz"
    result_of(capsys, "map", cap, *FEW, "-o", skin)
    result_of(capsys, "map", skin, "--method", "tutte", "-o", other)
    result = result_of(capsys, "map", skin, "--compare", other)
    rows = {row["name"]: row for row in result["comparison"]["measures"]}
    assert rows["symmetric_dirichlet"]["better"] == "first"
    status, out, _ = call(capsys, "map", skin, "--compare", other)
    assert status == 0
    assert "this is better" in out


@pytest.mark.long
def test_misplaced_modules_are_corrected_only_on_request(capsys, tmp_path):
    positions = tmp_path / "left_plate.txt"
    layout = tmp_path / "left_plate.ini"
    _plate_of_modules(positions, layout)
    words = (positions, "--robot", "none", "--compare", layout)
    reported = result_of(capsys, "map", *words)["comparison"]
    corrected = result_of(capsys, "map", *words, "--fix-modules")["comparison"]
    torn = [{row["name"]: row["second"] for row in result["measures"]}["torn"] for result in (reported, corrected)]
    assert [finding["kind"] for finding in reported["findings"]] == ["modules-misplaced"]
    assert torn[0] > torn[1] == 0


def _plate_of_modules(positions: Path, layout: Path) -> None:
    """Four modules in a row on a plate; the drawing has the second one turned by 120 degrees."""
    places = [LayoutModule(k, 0.0148 * k, 0.0085 * (k % 2), np.pi * (k % 2)) for k in range(4)]
    rows = [f"{x:.6f} {y:.6f} 0 0 0 1" for module in places for x, y in module.points.tolist()]
    positions.write_text("name plate\n[calibration]\n" + "\n".join(rows) + "\n")
    turned = replace(places[1], angle=places[1].angle + 2 * np.pi / 3)
    write_icub_layout(IcubLayout("left_plate", (places[0], turned, *places[2:])), layout)


@pytest.mark.long
def test_taxel_files_and_layouts_are_described(capsys, cap, tmp_path):
    positions = tmp_path / "left_plate.txt"
    layout = tmp_path / "left_plate.ini"
    table = tmp_path / "taxels.csv"
    _plate_of_modules(positions, layout)
    result_of(capsys, "map", cap, *FEW, "-o", table)
    found = []
    for path in (positions, layout, table):
        assert run_command(["inspect", str(path), "--json"], windows={}) == 0
        found.append(json.loads(capsys.readouterr().out.splitlines()[-1]))
    assert [(one["kind"], one["taxels"]) for one in found] == [("taxel file", 40), ("layout", 48), ("taxel file", 60)]
    assert found[2]["mapped"] == 60
    assert found[0]["links"] == ["plate"]
    rows = {"different": 40, "first": 0, "last": 47, "repeated": 0}
    assert (found[0]["identity"]["ids"], found[0]["identity"]["modules"]["different"]) == (rows, 4)
    assert (list(found[2]["identity"]), found[2]["identity"]["ids"]["last"]) == (["ids"], 59)
    assert run_command(["inspect", str(positions)], windows={}) == 0
    assert "ids 0 to 47 (40), modules 0 to 3 (4), channels 0 to 11 (10)" in capsys.readouterr().out
    made = result_of(capsys, "map", positions, "--robot", "none", "-o", tmp_path / "map.npz")
    assert made["identity"] == found[0]["identity"]
    assert describe(str(tmp_path / "map.npz"))["identity"] == found[0]["identity"]
    assert "thermal-pad" in {problem["kind"] for problem in found[0]["problems"]}


def test_map_is_learned_from_babbling(capsys, cap):
    result = result_of(capsys, "map", cap, *FEW, "--learn", "information-distance", "--touches", 400)
    assert result["bijective"]
    assert result["trustworthiness"] > 0.9


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    ("words", "output", "status"),
    [
        (("--learn", "magic"), "magic", 2),
        (("--method", "magic"), "magic", 2),
        (("-o", "map.docx"), "docx", 2),
        (("--pattern", "spiral"), "spiral", 2),
        (("--lengths", "7"), "0 to 1", 1),
        (("--cut", "-1"), "0 to 100", 1),
        (("--compare", "nowhere.npz"), "nowhere.npz", 1),
        (("--uv", "nowhere.obj"), "nowhere.obj", 1),
        (("--pitch", 0), "pitch", 1),
        (("--from", "-1,2"), "must be three numbers", 2),
        (("--exact-distances", 0), "exact-distances", 2),
        (("--grid", "4by6"), "4by6", 2),
        (GRID[:3], "two opposite corners", 2),
        ((*GRID, "--links", "a", "b"), "a single link", 2),
        (GRID[2:], "without a grid", 2),
        (("--no-mirrored",), "--mirrored without a grid", 2),
    ],
)
def test_bad_options_are_named(capsys, cap, words, output, status):
    found, out, err = call(capsys, "map", cap, *words)
    assert (found, out) == (status, "")
    assert output in err
    assert "Traceback" not in err


@pytest.mark.long
def test_stretch_of_a_degenerate_face_is_infinite(capsys):
    quality = measure(build_map(skin_of(sheet(), taxels=5)), sources=3)
    spoiled = replace(quality, symmetric_dirichlet=math.inf, angle=DistortionSummary(1.0, math.inf, math.inf))
    print_quality({**spoiled.to_json(), "file": None}, source="cap.stl")
    out = capsys.readouterr().out
    assert "infinite: a face has no area" in out
    assert "1.000 median, infinite p95, infinite max" in out


def test_grid_is_placed_between_two_corners(capsys, cap):
    result = result_of(capsys, "map", cap, *GRID)
    assert (result["taxels"], result["identity"]["ids"]["last"]) == (24, 23)
    assert "grid-pitch" in {finding["kind"] for finding in result["findings"]}


@pytest.mark.long
@pytest.mark.parametrize("first", ["-30,-20,90", "-.3e2,-20,9e1"])
def test_option_value_may_start_with_a_minus_sign(capsys, cap, first):
    joined = result_of(capsys, "map", cap, "--grid", "2x3", f"--from={first}", "--to=-10,-5.5,90")
    apart = result_of(capsys, "map", cap, "--grid", "2x3", "--from", first, "--to", "-10,-5.5,90")
    assert apart["stress"] == joined["stress"]


@pytest.mark.long
def test_stated_grid_is_used(capsys, cap):
    variants = ((), ("--no-mirrored",), ("--mirrored",))
    chosen, first, second = (result_of(capsys, "map", cap, *GRID, *more) for more in variants)
    assert chosen["stress"] == first["stress"] != second["stress"]


@pytest.mark.long
def test_generated_taxels_have_the_requested_axes(capsys, cap):
    for words in ((cap, *FEW), ("arm", "--links", "hand", *GRID)):
        made = result_of(capsys, "map", *words, "--axes", 3)
        assert made["axes"] == {"three_axis": made["taxels"], "stated_tangents": 0}


def test_axes_of_a_table_are_listed_for_file_and_map(capsys, tmp_path):
    lines = [f"{10 * (k % 4)},{10 * (k // 4)},0,{3 if k < 9 else 1},{'0,1,0' if k < 5 else ',,'}" for k in range(12)]
    table = tmp_path / "pad.csv"
    table.write_text("\n".join(["x_mm,y_mm,z_mm,axes,t1x,t1y,t1z", *lines]))
    assert describe(str(table))["axes"] == {"three_axis": 9, "stated_tangents": 5}
    assert run_command(["inspect", str(table)], windows={}) == 0
    assert "3 for 9 taxels, t1 stated for 5, else from the map" in capsys.readouterr().out
    made = result_of(capsys, "map", table, "--robot", "none", "-o", tmp_path / "map.npz")
    assert made["axes"] == describe(str(tmp_path / "map.npz"))["axes"] == {"three_axis": 9, "stated_tangents": 5}


URDF = """<robot name="two"><link name="base"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
<link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link><joint name="j" type="revolute">
<parent link="base"/><child link="arm"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.long
def test_notes_about_the_model_are_one_line_and_inspect_shows_the_same_table(capsys, tmp_path):
    path = tmp_path / "two.urdf"
    path.write_text(URDF)
    found, out, _ = call(capsys, "map", str(path), "--links", "arm", "--taxels", "30", "-o", str(tmp_path / "two.npz"))
    assert found == 0
    assert f"notes about the model: tactile-maps inspect {path}" in out
    assert "armature" not in out
    found, shown, _ = call(capsys, "inspect", str(tmp_path / "two.npz"))
    table = [line for line in out.splitlines() if line.startswith(("One-to-one", "Distortion", "Trustworthiness"))]
    assert len(table) == 3
    assert all(line in shown for line in table)
    assert "symmetric_dirichlet" not in shown
    assert "armature" in shown
