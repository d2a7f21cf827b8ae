"""Scene of a command, and folders of its robot's files: ``--package-root`` of every command."""

from __future__ import annotations

import argparse
import json

import pytest
import trimesh

from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.core.errors import UsageError
from tactile_widgets.__main__ import main


@pytest.fixture
def elsewhere(tmp_path):
    """A robot whose mesh is outside its folder, and a scene with it."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "shared").mkdir()
    trimesh.creation.icosphere(2, radius=0.05).export(tmp_path / "shared" / "ball.stl")
    (tmp_path / "robot" / "ball.xml").write_text(
        '<mujoco><asset><mesh name="ball" file="../shared/ball.stl"/></asset><worldbody><body name="tip"><joint/>'
        '<geom type="mesh" mesh="ball"/></body></worldbody></mujoco>'
    )
    (tmp_path / "own.toml").write_text('robot = "robot/ball.xml"\n[cover]\ntaxels = 20\n')
    return tmp_path


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("words", "robot"),
    [
        (["inspect"], "robot/ball.xml"),
        (["inspect"], "own.toml"),
        (["map", "--taxels", "20"], "robot/ball.xml"),
        (["run", "--for", "0.01", "--robot"], "robot/ball.xml"),
        (["run", "--for", "0.01"], "own.toml"),
        (["weigh"], "robot/ball.xml"),
    ],
)
def test_every_command_finds_files_under_a_package_root(elsewhere, capsys, words, robot):
    call = [*words, str(elsewhere / robot)]
    assert main(call) == 1
    assert f"give {elsewhere} as a package root (--package-root DIR)" in capsys.readouterr().err
    status = main([*call, "--json", "--package-root", str(elsewhere)])
    shown = capsys.readouterr()
    assert status == 0, shown.err
    assert json.loads(shown.out.splitlines()[-1])


@pytest.mark.long
def test_scene_may_state_package_roots_relative_to_itself(elsewhere, capsys):
    scene = elsewhere / "own.toml"
    scene.write_text('package_roots = ["."]\n' + scene.read_text())
    assert main(["inspect", str(scene)]) == 0


def test_root_that_is_not_a_folder_is_a_usage_error(elsewhere, capsys):
    assert main(["inspect", "arm", "--package-root", str(elsewhere / "nowhere")]) == 2
    assert "the folder does not exist" in capsys.readouterr().err


def test_repeated_package_roots_are_listed_once_as_absolute_paths(elsewhere, monkeypatch):
    monkeypatch.chdir(elsewhere)
    arguments = build_parser().parse_args(["run", "--package-root", ".", "--package-root", str(elsewhere)])
    assert scene_from_arguments(arguments).package_roots == (str(elsewhere),)


def test_folder_of_positions_files_is_opened_as_a_scene_of_its_robot(tmp_path):
    with pytest.raises(UsageError, match=r"folder is not a scene.*positions files"):
        scene_from_arguments(argparse.Namespace(scene_file=str(tmp_path)))
    (tmp_path / "left_forearm.txt").write_text("")
    scene = scene_from_arguments(argparse.Namespace(scene_file=str(tmp_path)))
    assert (scene.robot, scene.taxel_files) == ("icub_whole", (str(tmp_path),))
