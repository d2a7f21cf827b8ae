"""What a file or a name is, so that it can be opened: robot, mesh, scene, taxels or recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.core.errors import UsageError
from app.scene.scene import Scene
from app.scene.scene_file import load_scene, scene_for

ROBOTS = (".xml", ".mjcf", ".urdf")
MESHES = (".obj", ".stl", ".ply", ".off", ".glb", ".dae")
RECORDINGS = (".mcap",)
SCENES = (".toml",)
MAPS = (".npz",)
TAXELS = (".txt",)
ROBOT_FILTER = "Robots and meshes (" + " ".join(f"*{end}" for end in (*ROBOTS, *MESHES, *SCENES)) + ")"
RECORDING_FILTER = "Recordings (*.mcap)"
SCENE_FILTER = "Scenes (*.toml)"
SCRIPT_FILTER = "Stimulus scripts (*.toml)"
TAXEL_FILTER = "iCub taxel positions (*.txt)"


def is_recording(path: str) -> bool:
    """Whether the file's name is that of a recording."""
    return Path(path).suffix.lower() in RECORDINGS


def is_scene(path: str) -> bool:
    """Whether the file's name is that of a scene."""
    return Path(path).suffix.lower() in SCENES


def is_map(path: str) -> bool:
    """Whether the file's name is that of a saved map."""
    return Path(path).suffix.lower() in MAPS


def is_taxel_file(path: str) -> bool:
    """Whether the file's name is that of an iCub positions file."""
    return Path(path).suffix.lower() in TAXELS


def scene_to_open(path: str) -> Scene:
    """The scene for a dropped or chosen file; what a scene's file names is not opened yet.

    Raises:
        UsageError: Nothing can be done with such a file.
        SceneError: A scene file with a mistake.
    """
    ending = Path(path).suffix.lower()
    if is_scene(path):
        return load_scene(path)
    if ending in (*ROBOTS, *MESHES):
        return scene_for(path)
    known = ", ".join((*ROBOTS, *MESHES, *SCENES, *MAPS, *RECORDINGS, *TAXELS))
    raise UsageError(
        "this type of file cannot be opened",
        file=path,
        value=ending or "no file extension",
        remedy=f"Give one of: {known}",
    )


def with_taxels(scene: Scene, path: str) -> Scene:
    """The same robot with the taxels of a positions file; the scripted finger touches the first patch."""
    stimuli = tuple(replace(stimulus, patch="") for stimulus in scene.stimuli[:1])
    return replace(scene, taxel_file=path, stimuli=stimuli, title=f"{scene.title} with {Path(path).name}")
