"""Scenes by name or file: the shipped ones, a person's own, and one for any robot."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from app.errors import SceneError
from app.scene.effect_table import EFFECTS
from app.scene.motion import Waypoint
from app.scene.needs import OUTPUTS, TASKS
from app.scene.objects import OBJECT_KINDS, ObjectSpec
from app.scene.scene import Scene
from app.scene.scene_file import load_scene, scene_for, scene_names
from app.scene.scene_text import scene_from_toml, scene_to_toml
from app.skin.cover_spec import CoverSpec
from app.stimuli.stimulus_file import KINDS
from app.touch.layer import Layer
from assets import asset


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_load_and_survive_writing(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.title
    assert scene.stimuli or scene.motion or "task" in scene.control, "something must happen in it"
    assert scene_from_toml(scene_to_toml(scene), name="other") == scene
    assert not scene.decision.warnings
    assert asset("scenes", f"{name}.toml").read_text().startswith("# "), "its first line says what it is for"


def test_the_three_robots_have_scenes():
    assert {"arm", "icub", "ur5e"} < set(scene_names())


def test_names_in_a_file_are_meant_from_its_folder(tmp_path):
    (tmp_path / "own.urdf").write_text("x")
    (tmp_path / "own.stl").write_text("x")
    path = tmp_path / "own.toml"
    path.write_text("robot = 'own.urdf'\n[[objects]]\nname = 'm'\nkind = 'mesh'\nfile = 'own.stl'\n")
    scene = load_scene(str(path))
    assert scene.robot == str(tmp_path / "own.urdf")
    assert scene.objects[0].file == str(tmp_path / "own.stl")
    path.write_text("robot = 'arm'\n")
    assert load_scene(str(path)) == replace(Scene(name="own", robot="arm"))


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"#" * 1_000_001])
def test_a_file_that_is_none(tmp_path, content):
    path = tmp_path / "bad.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError, match="bad.toml"):
        load_scene(str(path))


def test_the_nearest_name_is_told():
    with pytest.raises(SceneError, match="self_tuch.*Did you mean self_touch"):
        load_scene("self_tuch")


def test_any_robot_has_a_scene():
    assert scene_for("arm") == load_scene("arm")
    scene = scene_for("/somewhere/my_robot.urdf")
    assert (scene.name, scene.title, scene.robot) == ("my_robot", "my_robot.urdf", "/somewhere/my_robot.urdf")
    assert scene.cover.links == ()
    assert len(scene.stimuli) == 1


def test_the_page_about_scene_files_names_everything_there_is():
    page = asset("scenes", "README.md").read_text()
    keys = [field.name for kind in (CoverSpec, Layer, ObjectSpec, Waypoint) for field in fields(kind)]
    for word in (*keys, *TASKS, *OUTPUTS, *EFFECTS, *OBJECT_KINDS, *KINDS, *scene_names()):
        assert f"`{word}`" in page, word
    for entry in EFFECTS.values():
        assert all(choice in page for choice in entry.choices), entry.key
