"""Scenes by name or file: those that ship with the app, a person's own, and one for any robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from app.errors import SceneError
from app.scene.scene import Scene
from app.scene.scene_text import scene_from_toml
from app.stimuli.stroke import Stroke
from app.toml.nearest import nearest
from app.toml.reader import TomlReader
from assets import asset

_MAX_BYTES = 1_000_000


def scene_names() -> tuple[str, ...]:
    """Names of the scenes that ship with the app."""
    return tuple(sorted(path.stem for path in asset("scenes").glob("*.toml")))


def _trusting(_scene: Scene) -> None:
    """Nothing more is checked."""


def load_scene(name: str, *, check: Callable[[Scene], None] = _trusting) -> Scene:
    """The scene of that name or file. In a file, robot, taxels and meshes may be named relative to its folder.

    Args:
        name: Of a shipped scene, or a path.
        check: Refuses what this folder cannot know, by an error whose place says the keys; it gets its line.

    Raises:
        SceneError: There is none, or it has a mistake; the message names the line and the key.
    """
    path = asset("scenes", f"{name}.toml") if name in scene_names() else Path(name)
    if not path.is_file():
        remedy = f"{nearest(name, scene_names())}, or give the path of a file"
        raise SceneError("there is no such scene", value=name, remedy=remedy)
    if path.stat().st_size > _MAX_BYTES:
        raise SceneError("the file is too large for a scene", file=path, value=f"{path.stat().st_size} bytes")
    try:
        text = path.read_text(encoding="utf8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError("the scene cannot be read", file=path, value=error) from error
    scene = scene_from_toml(text, name=path.stem, file=str(path))
    scene = replace(
        scene,
        robot=_beside(path, scene.robot),
        taxel_file=_beside(path, scene.taxel_file),
        objects=tuple(replace(spec, file=_beside(path, spec.file)) for spec in scene.objects),
    )
    reader = TomlReader(text, file=str(path))
    with reader.locating(reader.raw, ()):
        check(scene)
    return scene


def scene_for(robot: str) -> Scene:
    """The scene for a robot's name or file: the shipped one of that name, or one with a cover and a stroke."""
    if robot in scene_names():
        return load_scene(robot)
    return Scene(name=Path(robot).stem or robot, robot=robot, title=Path(robot).name, stimuli=(Stroke(),))


def _beside(scene: Path, value: str) -> str:
    """A file's name that is meant from the scene's folder, as a path; anything else unchanged."""
    return str(scene.parent / value) if value and (scene.parent / value).is_file() else value
