"""Scene files: what they say is what one gets, and a mistake is named."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.errors import SceneError
from app.simulation.effects import Effects
from app.simulation.scene import Scene
from app.simulation.scene_file import load_scene, scene_for, scene_from_toml, scene_names, scene_to_toml
from app.simulation.stimuli import Stroke
from app.skin.cover_spec import CoverSpec


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_load_and_survive_writing(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.title
    assert scene.strokes
    assert scene_from_toml(scene_to_toml(scene), name="other") == scene


def test_the_three_robots_have_scenes():
    assert scene_names() == ("arm", "icub", "ur5e")


def test_every_field_survives_writing():
    scene = Scene(name='a "quoted"\tname \\ \x7f µ', robot="C:\\robots\\x.urdf", title="Ünï\n", tick=0.01, seed=7,
                  cover=CoverSpec(links=("a", "b"), taxels=50, thickness=0.002, seed=3), taxel_file="t.txt",
                  effects=Effects("off", "self", False, 0.0005),
                  control={"law": "hold_force", "integral_time": float("inf"), "odd key": 1.0},
                  strokes=(Stroke(), Stroke(patch="x", start=(0.0, 1.0), force=1.5)))  # fmt: skip
    assert scene_from_toml(scene_to_toml(scene), name="n") == scene


@pytest.mark.parametrize(("text", "words"), [
    ("robot = ", "not valid TOML"),
    ("", "missing.*robot"),
    ("robot = 5", "scene.robot.*must be a str"),
    ("robt = 'arm'", "robt.*robot"),
    ("robot = 'arm'\n[effects]\ngravty = 'on'", "gravty.*Did you mean gravity"),
    ("robot = 'arm'\n[effects]\nzzz = 'on'", "zzz.*Known keys"),
    ("robot = 'arm'\n[effects]\ngravity = 'sideways'", "sideways.*off, on, compensated"),
    ("robot = 'arm'\n[effects]\njoint_limits = 1", "joint_limits.*bool"),
    ("robot = 'arm'\n[effects]\ntimestep = true", "timestep.*float"),
    ("robot = 'arm'\neffects = 3", "must be a table"),
    ("robot = 'arm'\n[cover]\ntaxels = 10000000", "10000000"),
    ("robot = 'arm'\n[cover]\ntaxels = 1.5", "taxels.*int"),
    ("robot = 'arm'\n[cover]\nlinks = [1]", "links.*str"),
    ("robot = 'arm'\n[control]\nlaw = [1]", "control.law"),
    ("robot = 'arm'\nstrokes = 5", "strokes must be tables"),
    ("robot = 'arm'\n[[strokes]]\nstart = [0.5]", "2 numbers"),
    ("robot = 'arm'\n[[strokes]]\nspeed = 0", "strokes.speed"),
    ("robot = 'arm'\ntick = 0.0011", "whole number"),
])  # fmt: skip
def test_a_mistake_is_named(text, words):
    with pytest.raises(SceneError, match=rf"(?s)my file.*{words}") as caught:
        scene_from_toml(text, name="s", file="my file")
    assert "\n" not in str(caught.value)


def test_names_in_a_file_are_meant_from_its_folder(tmp_path):
    (tmp_path / "own.urdf").write_text("x")
    path = tmp_path / "own.toml"
    path.write_text("robot = 'own.urdf'\n")
    assert load_scene(str(path)).robot == str(tmp_path / "own.urdf")
    path.write_text("robot = 'arm'\n")
    assert load_scene(str(path)) == replace(Scene(name="own", robot="arm"))


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"#" * 1_000_001])
def test_a_file_that_is_none(tmp_path, content):
    path = tmp_path / "bad.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError, match="bad.toml"):
        load_scene(str(path))


def test_any_robot_has_a_scene():
    assert scene_for("arm") == load_scene("arm")
    scene = scene_for("/somewhere/my_robot.urdf")
    assert (scene.name, scene.title, scene.robot) == ("my_robot", "my_robot.urdf", "/somewhere/my_robot.urdf")
    assert scene.cover.links == ()
    assert len(scene.strokes) == 1
