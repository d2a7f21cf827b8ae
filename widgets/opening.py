"""What a file or a name is, so that it can be opened: robot, mesh, scene, taxels or recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.errors import UsageError
from app.simulation.scene import Scene
from app.simulation.scene_file import load_scene, scene_for

ROBOTS = (".xml", ".mjcf", ".urdf")
MESHES = (".obj", ".stl", ".ply", ".off", ".glb", ".dae")
RECORDINGS = (".mcap",)
SCENES = (".toml",)
MAPS = (".npz",)
TAXELS = (".txt",)
ROBOT_FILTER = "Robots and meshes (" + " ".join(f"*{end}" for end in (*ROBOTS, *MESHES, *SCENES)) + ")"
RECORDING_FILTER = "Recordings (*.mcap)"
TAXEL_FILTER = "iCub taxel positions (*.txt)"


def is_recording(path: str) -> bool:
    """Whether the file's name is that of a recording."""
    return Path(path).suffix.lower() in RECORDINGS


def is_map(path: str) -> bool:
    """Whether the file's name is that of a saved map."""
    return Path(path).suffix.lower() in MAPS


def is_taxel_file(path: str) -> bool:
    """Whether the file's name is that of an iCub positions file."""
    return Path(path).suffix.lower() in TAXELS


def scene_to_open(path: str) -> Scene:
    """The scene for a dropped or chosen file.

    Raises:
        UsageError: Nothing can be done with such a file.
        SceneError: A scene file with a mistake.
    """
    ending = Path(path).suffix.lower()
    if ending in SCENES:
        return load_scene(path)
    if ending in (*ROBOTS, *MESHES):
        return scene_for(path)
    known = ", ".join((*ROBOTS, *MESHES, *SCENES, *MAPS, *RECORDINGS, *TAXELS))
    raise UsageError(
        "this kind of file cannot be opened", file=path, value=ending or "no ending", remedy=f"Give one of: {known}"
    )


def with_taxels(scene: Scene, path: str) -> Scene:
    """The same robot wearing the taxels of a positions file; the scripted hand strokes the first patch."""
    strokes = tuple(replace(stroke, patch="") for stroke in scene.strokes[:1])
    return replace(scene, taxel_file=path, strokes=strokes, title=f"{scene.title} with {Path(path).name}")
