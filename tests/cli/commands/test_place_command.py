"""``place``: taxels move onto the mesh, or to where known touches put them, and the file is written again."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from matplotlib.image import imread
from scipy.spatial.transform import Rotation

from tactile_maps.cli.shared.residual_picture import _factor
from tactile_maps.core.assets import ASSETS
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.library import load_robot
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, write_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_widgets.__main__ import main
from tests.skin.fitting.test_alignment import PITCH, bowl, displacement, patch


@pytest.fixture
def robot(tmp_path):
    """A robot of one link, a bowl as STL."""
    mesh = bowl()
    corners = mesh.vertices[mesh.faces]
    facets = [
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in facet)
        + "endloop\nendfacet\n"
        for facet in corners.tolist()
    ]
    (tmp_path / "bowl.stl").write_text("solid bowl\n" + "".join(facets) + "endsolid bowl\n")
    path = tmp_path / "bowl.urdf"
    path.write_text(
        '<robot name="bowl"><link name="bowl"><visual><geometry><mesh filename="bowl.stl"/></geometry></visual>'
        '<collision><geometry><mesh filename="bowl.stl"/></geometry></collision></link></robot>'
    )
    return str(path)


POSE = displacement(4, 6, 2)
TRUE, NORMALS = patch()


@pytest.fixture
def stated(tmp_path):
    """A table of the taxels at wrong places."""
    path = tmp_path / "stated.csv"
    wrong = POSE.inverse
    taxels = TaxelSet(
        "pad",
        "bowl",
        np.arange(99),
        wrong.points(TRUE),
        normals=wrong.directions(NORMALS),
        ids=100 + np.arange(99),
        modules=np.arange(99) // 33,
    )
    write_taxels(taxels, path)
    return str(path)


def touch_readings(count):
    """Return places (count, 3) and readings (count, 99) of touches, in counts above 500."""
    random = np.random.default_rng(5)
    places = TRUE[random.integers(99, size=count)]
    away = ((TRUE[None] - places[:, None]) ** 2).sum(axis=2)
    return places, 500 + 80 * np.exp(-away / PITCH**2) + random.normal(0, 0.5, away.shape)


def error(path):
    """Return the largest error of a taxel in a file, in pitches."""
    (taxels,) = read_taxel_sets(path)
    return np.linalg.norm(taxels.positions - TRUE, axis=1).max() / PITCH


def test_taxels_are_placed_on_the_mesh_with_residuals(robot, stated, tmp_path, capsys):
    target, page = tmp_path / "placed.csv", tmp_path / "page.html"
    words = ["place", stated, "--robot", robot, "-o", str(target), "--report", str(page), "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["after_mm"] < 0.2 < 1 < found["before_mm"]
    (group,) = found["groups"]
    assert (group["group"], group["taxels"]) == ("bowl", 99)
    assert group["undetermined"] == 3, "so flat a bowl does not determine sliding"
    text = page.read_text()
    assert "Distance from the mesh, placed" in text
    assert "<svg" in text
    (picture,) = re.findall(r'<img alt="Residuals on bowl"[^>]* src="data:image/png;base64,([^"]+)">', text)
    pixels = imread(io.BytesIO(base64.b64decode(picture)))[..., :3]
    halves = [np.ptp(half, axis=2).max(axis=1) > 0.3 for half in np.split(pixels[:, : pixels.shape[1] * 4 // 5], 2)]
    assert all(half.sum() > 30 for half in halves), "coloured taxels and vectors, stated above and placed below"
    (taxels,) = read_taxel_sets(target)
    assert taxels.ids.tolist() == (100 + np.arange(99)).tolist()
    assert main(["place", str(target), "--robot", robot, "--by", "module", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert [group["group"] for group in again["groups"]] == [f"bowl, module {number}" for number in range(3)]


def test_vectors_are_drawn_with_at_most_6_percent_of_the_extent_of_the_taxels():
    positions = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    assert _factor(positions, np.array([0.1, 0.5])) == 10.0
    assert _factor(positions, np.array([20.0])) == 1.0


def test_touches_at_known_places_correct_the_file(stated, tmp_path, capsys):
    places, readings = touch_readings(40)
    log, target = tmp_path / "touches.csv", tmp_path / "placed.csv"
    lines = ["x_mm,y_mm,z_mm," + ",".join(str(100 + taxel) for taxel in range(99))]
    lines += [",,," + ",".join(map(str, 500 + row)) for row in np.random.default_rng(1).normal(0, 0.5, (10, 99))]
    lines += [",".join(map(str, (*1e3 * place, *row))) for place, row in zip(places, readings, strict=True)]
    log.write_text("\n".join(lines))
    assert error(stated) > 0.5
    assert main(["place", stated, "--touches", str(log), "-o", str(target)]) == 0
    text, warnings = capsys.readouterr()
    assert not warnings
    assert "40 touches" in text
    assert "largest standard error of a taxel" in text
    assert error(target) < 0.2
    (taxels,) = read_taxel_sets(target)
    assert (taxels.normals * NORMALS).sum(axis=1).min() > np.cos(np.radians(3))


def test_rows_on_other_links_are_reported(stated, tmp_path, capsys):
    places, readings = touch_readings(12)
    links = ["bowl"] * 10 + ["bowll", "cup"]
    log = tmp_path / "touches.csv"
    lines = [
        "link,x_mm,y_mm,z_mm," + ",".join(str(100 + taxel) for taxel in range(99)),
        "bowl,,,," + ",".join(99 * "0"),
    ]
    lines += [
        ",".join(map(str, (link, *1e3 * place, *row))) for link, place, row in zip(links, places, readings, strict=True)
    ]
    log.write_text("\n".join(lines))
    assert main(["place", stated, "--touches", str(log)]) == 0
    text, warnings = capsys.readouterr()
    assert "10 touches" in text
    assert f"touches.csv: rows on bowll, cup are left out: no taxels in {stated}" in warnings


def test_trajectory_and_readings_of_the_same_clock_correct_the_file(stated, tmp_path, capsys):
    places, readings = touch_readings(40)
    track, stream, target = (tmp_path / name for name in ("track.csv", "readings.csv", "placed.csv"))
    rows = [f"{10 + 0.1 * number},{x},{y},{z}" for number, (x, y, z) in enumerate(places.tolist())]
    track.write_text("\n".join(["time,x,y,z", *rows]))
    before = 500 + np.random.default_rng(1).normal(0, 0.5, (10, 99))
    every = [(9 + 0.1 * number, row) for number, row in enumerate([*before, *readings])]
    names = "time," + ",".join(str(100 + taxel) for taxel in range(99))
    stream.write_text("\n".join([names, *(",".join(map(str, (time, *row))) for time, row in every)]))
    words = ["place", stated, "--touches", str(track), "--readings", str(stream), "-o", str(target), "--json"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["groups"][0]["uncertainty_mm"] < 1e3 * PITCH / 5
    assert error(target) < 0.2


def write_self_touches(path, robot, places, readings):
    """Write touches at places (count, 3) of the right forearm, by the left arm at random postures.

    The points in the frames of the touching links are those of MuJoCo's own model of the robot.
    """
    random = np.random.default_rng(3)
    model = mujoco.MjModel.from_xml_string(robot.mjcf, dict(robot.assets))
    data = mujoco.MjData(model)
    names = [model.joint(number).name for number in range(model.njnt)]
    header = ["time", "touching_link", "x_mm", "y_mm", "z_mm", *(f"joint:{name}" for name in names)]
    rows = [[*header, *(str(100 + taxel) for taxel in range(99))]]
    free = 500 + random.normal(0, 0.5, (10, 99))
    rows += [[0.1 * number, *[""] * (len(header) - 1), *row] for number, row in enumerate(free)]
    for number, (place, row) in enumerate(zip(places, readings, strict=True)):
        touching = ("left_hand", "left_wrist")[number % 2]
        data.qpos[:] = random.uniform(*model.jnt_range.T)
        mujoco.mj_forward(model, data)
        world = data.body("right_forearm").xmat.reshape(3, 3) @ place + data.body("right_forearm").xpos
        point = data.body(touching).xmat.reshape(3, 3).T @ (world - data.body(touching).xpos)
        rows.append([1 + 0.1 * number, touching, *1e3 * point, *data.qpos, *row])
    path.write_text("\n".join(",".join(map(str, row)) for row in rows))


def test_touches_by_another_link_of_the_robot_correct_the_file(tmp_path, capsys):
    robot = load_robot("two_arms")
    side = Pose(Rotation.from_euler("y", 90, degrees=True).as_matrix(), np.array([0.03, 0.0, 0.15]))
    stated = side.points(displacement(10, 10, 2).inverse.points(TRUE))
    write_taxels(TaxelSet("pad", "right_forearm", np.arange(99), stated, ids=100 + np.arange(99)), tmp_path / "pad.csv")
    places, readings = touch_readings(40)
    write_self_touches(tmp_path / "touches.csv", robot, side.points(places), readings)
    words = ["place", str(tmp_path / "pad.csv"), "--touches", str(tmp_path / "touches.csv"), "--robot", "two_arms"]
    assert main([*words, "-o", str(tmp_path / "placed.csv"), "--json"]) == 0
    (group,) = json.loads(capsys.readouterr().out)["groups"]
    (placed,) = read_taxel_sets(tmp_path / "placed.csv")
    before, after = (np.linalg.norm(one - side.points(TRUE), axis=1).max() for one in (stated, placed.positions))
    assert before > PITCH
    assert after < PITCH / 5
    assert after < 4e-3 * group["uncertainty_mm"] < 4 * PITCH / 5


def test_guide_example_of_a_robot_that_touches_itself_prints_what_the_guide_states(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ASSETS / "guide" / "formats.md").read_text(encoding="utf8").split("**By another link of the robot.**")[1]
    pad, touches, output = re.findall(r"^```\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)[:3]
    (tmp_path / "pad.csv").write_text(pad)
    (tmp_path / "self_touches.csv").write_text(touches)
    words = ["place", "pad.csv", "--touches", "self_touches.csv", "--robot", "two_arms", "-o", "placed.csv"]
    assert main(words) == 0
    assert capsys.readouterr().out == output


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x,y,100\n0,0,1\n", "header: a column is missing: z .found: x, y, 100"),
        ("x,y,z,99\n0,0,0,1\n", "columns name unknown taxels .found: 99"),
        ("x,y,z\n0,0,0\n", "no column names a taxel"),
        ("x,y,z,100\n0,0,0,1\n", "no reading of the untouched skin"),
        ("x,y,z,100\n,,,0\n0,0,0,9\n", "bowl: too few touches to find a pose .found: 1"),
        ("x,y,z,100\n,,,0\n0,0,up,9\n", "line 3, z: expected a number"),
    ],
)
def test_invalid_touch_is_reported(stated, tmp_path, capsys, text, problem):
    log = tmp_path / "touches.csv"
    log.write_text(text)
    assert main(["place", stated, "--touches", str(log)]) == 1
    message = capsys.readouterr().err
    assert str(log) in message
    assert re.search(problem, message), message


def test_input_without_robot_or_modules_is_rejected(stated, robot, tmp_path, capsys):
    assert main(["place", stated]) == 2
    assert "no robot carries the taxels" in capsys.readouterr().err
    (taxels,) = read_taxel_sets(stated)
    write_taxels(replace(taxels, modules=None), tmp_path / "plain.csv")
    assert main(["place", str(tmp_path / "plain.csv"), "--robot", robot, "--by", "module"]) == 1
    assert "the file states no modules" in capsys.readouterr().err
    assert main(["place", robot]) == 2
    assert "this file has no stated positions of taxels" in capsys.readouterr().err
