"""``--home`` states the home posture wherever a command loads a robot."""

from __future__ import annotations

import argparse
import json

import pytest

from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.robot_options import home_of
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.session.prepare import load_robot_of
from tactile_widgets.__main__ import main

HOME = "elbow_pitch=1.25,wrist_pitch=-0.5"


def commands_with(option: str) -> set[str]:
    (action,) = [one for one in build_parser()._actions if isinstance(one, argparse._SubParsersAction)]
    return {
        command
        for command, parser in action.choices.items()
        if any(option in one.option_strings for one in parser._actions)
    }


def test_every_command_that_loads_a_robot_has_the_option():
    assert commands_with("--home") == commands_with("--package-root")


def test_stated_joints_replace_those_of_the_scene(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[home]\nelbow_pitch = 1.0\nshoulder_pitch = 0.5\n[cover]\nlinks = ['hand']")
    arguments = build_parser().parse_args(["run", str(path), "--home", HOME])
    assert home_of(arguments) == {"elbow_pitch": 1.25, "wrist_pitch": -0.5}
    robot = load_robot_of(scene_from_arguments(arguments))
    found = dict(zip((joint.name for joint in robot.joints), robot.home.tolist(), strict=True))
    assert (found["elbow_pitch"], found["wrist_pitch"], found["shoulder_pitch"]) == (1.25, -0.5, 0.5)


def test_home_of_a_scene_is_not_used_for_another_robot(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[home]\nelbow_pitch = 1.0")
    arguments = build_parser().parse_args(["run", str(path), "--robot", "two_arms"])
    assert scene_from_arguments(arguments).home == {}


def test_inspect_shows_the_stated_home(capsys, tmp_path):
    robot = tmp_path / "lever.urdf"
    robot.write_text(LEVER)
    assert main(["inspect", str(robot), "--home", "hinge=0.75", "--json"]) == 0
    (limits,) = json.loads(capsys.readouterr().out.splitlines()[-1])["limits"]
    assert limits["home"] == 0.75


@pytest.mark.parametrize(
    ("home", "output"),
    [
        ("hinje=1", "home.hinje: the robot has no such joint (found: hinje). Did you mean hinge"),
        ("hinge=9", "home.hinge: the home position of a joint is out of range (found: 9.0). Choose -2 to 2 rad"),
    ],
)
@pytest.mark.parametrize("words", [["inspect"], ["map"], ["run", "--robot"], ["weigh"]])
def test_unknown_joints_and_unreachable_positions_are_named(words, home, output, capsys, tmp_path):
    robot = tmp_path / "lever.urdf"
    robot.write_text(LEVER)
    assert main([*words, str(robot), "--home", home]) == 1
    assert output in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "hinge", "hinge=", "=1", "hinge=nan", "hinge=inf", "hinge=1,", "hinge=1 m"])
def test_invalid_posture_text_is_a_usage_error(text, capsys):
    assert main(["inspect", "arm", f"--home={text}"]) == 2
    assert "argument --home: must be like elbow=1.2,wrist=-0.3" in capsys.readouterr().err


LEVER = """<robot name="lever">
  <link name="base"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <link name="lever"><visual><geometry><box size="0.1 0.1 0.4"/></geometry></visual></link>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="lever"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="10" velocity="1"/></joint>
</robot>
"""
