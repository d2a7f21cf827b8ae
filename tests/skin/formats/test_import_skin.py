"""Every format gives the same skin through the library, scene files and the command line."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.cli.commands.inspect import describe
from tactile_maps.cli.main import run_command
from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.errors import SceneError, SkinError, TactileMapsError, UsageError
from tactile_maps.live.channels.matching import TaxelMatcher
from tactile_maps.live.readings.readings import Reading
from tactile_maps.robots.load import load_robot_file
from tactile_maps.scene.scene_file import scene_for, scene_for_taxels, scene_from_toml, scene_to_toml
from tactile_maps.session.prepare import load_robot_and_skin, open_scene
from tactile_maps.skin.formats.import_skin import (
    NO_ROBOT,
    TaxelFile,
)
from tactile_maps.skin.formats.several_files import TaxelFiles
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_maps.skin.open import SkinOptions, open_skin
from tests.support.findings import only
from tests.support.taxel_formats import FORMATS, LINK, cylinder_taxels, write_formats


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_formats(tmp_path_factory.mktemp("formats"))


@pytest.fixture(scope="module")
def robot(files):
    return load_robot_file(files["robot.urdf"])


def by_scene(files, name):
    path = files[name].with_suffix(".toml")
    path.write_text(f"robot = 'robot.urdf'\ntaxel_file = '{name}'")
    return open_scene(str(path))


def by_command(files, name):
    words = ["run", "--robot", str(files["robot.urdf"]), "--skin", str(files[name])]
    return scene_from_arguments(build_parser().parse_args(words))


WAYS = {
    "scene": lambda files, name: load_robot_and_skin(by_scene(files, name))[1],
    "run": lambda files, name: load_robot_and_skin(by_command(files, name))[1],
    "map": lambda files, name: open_skin(files[name], SkinOptions(robot=str(files["robot.urdf"]))),
}


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_the_same_skin_everywhere(files, robot, name):
    expected = TaxelFile(files[name]).skin(robot)
    assert len(expected) == 30
    assert {patch.link for patch in expected.patches} == {LINK}
    np.testing.assert_array_equal(np.sort(expected.identity.ids), cylinder_taxels().ids)
    for way, opened in WAYS.items():
        skin = opened(files, name)
        np.testing.assert_array_equal(skin.areas, expected.areas, err_msg=way)
        np.testing.assert_array_equal(skin.identity.ids, expected.identity.ids, err_msg=way)


@pytest.mark.long
@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_inspected(files, name):
    found = describe(str(files[name]))
    taxels = found["taxels"]
    assert (taxels, found["identity"]["ids"]["different"]) == (30, 30)
    assert (found["kind"] == "robot with taxels") == (name == "robot_in_its_skin.urdf")


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", [name for name in FORMATS if not name.startswith(("icub", "robot"))])
def test_skin_without_robot_becomes_a_fixed_body(files, name):
    scene = scene_for_taxels(str(files[name]))
    assert (scene.robot, scene.name) == (NO_ROBOT, files[name].stem)
    robot, skin = load_robot_and_skin(scene)
    assert [link.name for link in robot.links if link.mesh is not None] == [LINK]
    assert (len(skin), robot.joints) == (30, ())


def test_taxels_stated_by_a_robot_are_used(files):
    path = str(files["robot_in_its_skin.urdf"])
    scene = scene_for(path)
    assert (scene.robot, scene.taxel_files) == (path, (path,))
    assert scene_for_taxels(path) == scene
    assert scene_for(str(files["robot.urdf"])).taxel_files == ()
    assert scene_for(str(files["sensors.urdf"])).robot == NO_ROBOT


@pytest.fixture
def unnamed(tmp_path):
    path = tmp_path / "unnamed.csv"
    write_taxels(cylinder_taxels(link=None), path)
    return path


def test_taxels_without_link_go_on_the_chosen_link(unnamed, files, robot, tmp_path):
    assert TaxelFile(unnamed).links == (None,)
    assert {patch.link for patch in TaxelFile(unnamed).skin(robot, links=(LINK,)).patches} == {LINK}
    assert {patch.link for patch in TaxelFile(unnamed).skin(links=("arm",)).patches} == {"arm"}
    with pytest.raises(SkinError, match=rf"unnamed\.csv.*does not name its link.*{LINK}"):
        TaxelFile(unnamed).skin(robot)
    scene = tmp_path / "own.toml"
    text = f"robot = '{files['robot.urdf']}'\n\ntaxel_file = 'unnamed.csv'\n"
    scene.write_text(text)
    with pytest.raises(SceneError, match=rf"own\.toml, line 3.*name its link.*cover\.links.*{LINK}"):
        open_scene(str(scene))
    scene.write_text(f"{text}[cover]\nlinks = ['{LINK}']")
    assert len(load_robot_and_skin(open_scene(str(scene)))[1]) == 30
    words = ["run", "--robot", str(files["robot.urdf"]), "--skin", str(unnamed), "--link", LINK]
    assert scene_from_arguments(build_parser().parse_args(words)).cover.links == (LINK,)


def test_missing_links_are_named(files, robot):
    with pytest.raises(SkinError, match=rf"no taxels of that link.*wing.*{LINK}"):
        TaxelFile(files["table.csv"]).skin(links=("wing",))
    with pytest.raises(TactileMapsError, match="wing"):
        TaxelFile(files["table.csv"]).check_links(robot, ("wing",))
    with pytest.raises(SkinError, match=r"no link of the skin's.*rod.*base"):
        TaxelFile(files["skin.npz"]).check_links(load_robot_file(files["table.csv"].parent / "other.urdf"))


@pytest.fixture(autouse=True)
def other_robot(files):
    other = files["robot.urdf"].read_text().replace(f'"{LINK}"', '"pole"')
    (files["robot.urdf"].parent / "other.urdf").write_text(other)


@pytest.mark.long
def test_several_links_need_a_robot_or_a_choice(tmp_path, robot):
    path = tmp_path / "two.csv"
    write_taxels([cylinder_taxels(), cylinder_taxels(link="base")], path)
    assert TaxelFile(path).links == (LINK, "base")
    scene = scene_for_taxels(str(path))
    with pytest.raises(SkinError, match="several links need a robot"):
        load_robot_and_skin(scene)
    assert {patch.link for patch in TaxelFile(path).skin(links=("base", LINK)).patches} == {"base", LINK}
    assert len(TaxelFile(path).skin(robot, links=(LINK,))) == 30


@pytest.mark.parametrize("links", [(), (LINK,)])
def test_stated_areas_are_compared_with_the_cells(tmp_path, robot, links):
    path = tmp_path / "pads.csv"
    write_taxels(replace(cylinder_taxels(), areas=np.full(30, 20e-6)), path)
    skin = TaxelFile(path).skin(robot if links else None)
    note = only(skin.findings, "stated-area")
    share = 30 * 20e-6 / skin.areas.sum()
    assert note.count == 30
    assert f"{100 * share:.0f} % of those" in note.action
    assert 0.15 < share < 0.35


def test_invalid_arguments_of_the_command_line_are_reported(capsys, files):
    with pytest.raises(UsageError, match="--link requires a skin file"):
        scene_from_arguments(build_parser().parse_args(["run", "--robot", "arm", "--link", "hand"]))
    assert run_command(["run", "--skin", "gone.csv", "--json"], windows={}) == 1
    assert "gone.csv" in json.loads(capsys.readouterr().out.splitlines()[-1])["error"]["message"]
    assert run_command(["run", "--robot", NO_ROBOT], windows={}) == 1
    assert "neither a robot nor a skin" in capsys.readouterr().err


@pytest.fixture
def halves(tmp_path):
    """Two tables: half of the taxels on the robot's link, and the others without a link."""
    first = tmp_path / "first.csv"
    second = tmp_path / "second.csv"
    taxels = cylinder_taxels()
    write_taxels(taxels.select(np.arange(30) < 15), first)
    write_taxels(replace(taxels.select(np.arange(30) >= 15), link=None), second)
    return first, second


@pytest.mark.long
def test_several_files_are_merged_in_library_scene_and_command(halves, files, robot, tmp_path):
    scene = tmp_path / "both.toml"
    scene.write_text(
        f"robot = '{files['robot.urdf']}'\ntaxel_file = ['first.csv', 'second.csv']\n[cover]\nlinks = ['{LINK}']\n"
    )
    opened = open_scene(str(scene))
    assert opened.taxel_files == tuple(map(str, halves))
    assert scene_from_toml(scene_to_toml(opened), name="both") == opened
    words = ["run", "--robot", str(files["robot.urdf"]), "--link", LINK]
    for path in halves:
        words += ["--skin", str(path)]
    given = scene_from_arguments(build_parser().parse_args(words))
    assert given.title == "robot.urdf with first.csv and second.csv"
    options = SkinOptions(robot=str(files["robot.urdf"]), links=(LINK,))
    skins = [load_robot_and_skin(opened)[1], load_robot_and_skin(given)[1], open_skin(halves, options)]
    for skin in skins:
        assert [(patch.link, len(patch.taxels)) for patch in skin.patches] == [(LINK, 15), (LINK, 15)]
        np.testing.assert_array_equal(np.sort(skin.identity.ids), np.sort(cylinder_taxels().ids))


def test_missing_and_unneeded_links_of_several_files_are_reported(halves, robot):
    with pytest.raises(SkinError, match=r"second\.csv.*does not name its link"):
        TaxelFiles(halves).skin(robot)
    with pytest.raises(SkinError, match="2 links for 1 file without one"):
        TaxelFiles(halves).check_links(robot, (LINK, "base"))


def test_same_id_in_two_files_names_both(halves, robot, tmp_path):
    other = tmp_path / "other.csv"
    write_taxels(cylinder_taxels().select(np.isin(np.arange(30), (14, 15))), other)
    found = int(cylinder_taxels().ids[14])
    with pytest.raises(SkinError, match=rf"same id.*first\.csv and other\.csv.*{LINK}:{found}.*Renumber"):
        TaxelFiles([halves[0], other]).check_links(robot)


def pad(path, first):
    """A layout of PaXini of four taxels, whose index begins at 0."""
    points = [{"index": n, "x_mm": first + 4 * (n % 2), "y_mm": 4 * (n // 2), "z_mm": 0} for n in range(4)]
    path.write_text(json.dumps({"points": points}))
    return path


def table(path, first):
    """A table as this program exports it: taxels are numbered from 0."""
    points = [f"{1e-3 * (first + 4 * (n % 2))},{4e-3 * (n // 2)},0,0,0,1,{n}" for n in range(4)]
    path.write_text("\n".join(["x_m,y_m,z_m,nx,ny,nz,taxel", *points]))
    return path


@pytest.mark.parametrize(("write", "suffix"), [(pad, "json"), (table, "csv")])
def test_ids_that_repeat_on_several_links_are_addressed_with_the_link(write, suffix, tmp_path):
    files = TaxelFiles([write(tmp_path / f"{name}.{suffix}", 0) for name in ("one", "other")])
    skin = files.skin(links=(LINK, "base"))
    assert [(patch.link, patch.taxels.identity.ids.tolist()) for patch in skin.patches] == [
        (LINK, [0, 1, 2, 3]),
        ("base", [0, 1, 2, 3]),
    ]
    finding = only(skin.findings, "repeated-id")
    assert (finding.count, f"{LINK}:0 or base:0" in finding.action) == (4, True)
    matcher = TaxelMatcher(skin)
    values = Reading(0.0, [5.0, 7.0], ids=[2, 2], links=(LINK, "base"))
    taxels, found = matcher.match(values)
    assert [(skin.patches[skin.patch_of[one]].link, value) for one, value in zip(taxels, found, strict=True)] == [
        (LINK, 5.0),
        ("base", 7.0),
    ]
    with pytest.raises(SkinError, match=rf"same id for one link, one\.{suffix} and other\.{suffix}.*{LINK}:0"):
        files.skin(links=(LINK,))
