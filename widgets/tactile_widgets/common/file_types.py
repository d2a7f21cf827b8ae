"""What a file or a name is, so that it can be opened: robot, mesh, scene, taxels or recording."""

from __future__ import annotations

import os
from enum import Enum
from pathlib import Path

from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene, scene_for
from tactile_maps.skin.formats.import_skin import TAXEL_ENDINGS, holds_taxels, is_robot_with_taxels
from tactile_maps.skin.formats.taxel_files import TAXEL_FORMATS

ROBOTS = (".xml", ".mjcf", ".urdf", ".xacro")
MESHES = (".obj", ".stl", ".ply", ".off", ".glb", ".dae")
RECORDINGS = (".mcap",)
SCENES = (".toml",)
MAPS = (".npz",)
ROBOT_FILTER = "Robots and meshes (" + " ".join(f"*{end}" for end in (*ROBOTS, *MESHES, *SCENES)) + ")"
RECORDING_FILTER = "Recordings (*.mcap)"
SCENE_FILTER = "Scenes (*.toml)"
STUDY_FILTER = "Tables of studies (*.csv *.parquet)"
SCRIPT_FILTER = "Stimulus scripts (*.toml)"


def taxel_filter() -> str:
    """Of files with taxels, those of plug-ins among them."""
    endings = (*TAXEL_ENDINGS, ".npz", ".urdf", ".xml", ".mjcf", *_added_endings())
    return "Taxels (" + " ".join(f"*{end}" for end in endings) + ")"


def _added_endings() -> tuple[str, ...]:
    return tuple(ending for form in TAXEL_FORMATS.values() for ending in form.endings)


def is_recording(path: str) -> bool:
    """Whether the file's name is that of a recording."""
    return Path(path).suffix.lower() in RECORDINGS


def is_scene(path: str) -> bool:
    """Whether the file's name is that of a scene."""
    return Path(path).suffix.lower() in SCENES


def is_map(path: str) -> bool:
    """Whether the file is a saved map: an npz that is not known to hold taxels."""
    return Path(path).suffix.lower() in MAPS and not holds_taxels(path)


def is_taxel_file(path: str) -> bool:
    """Whether the file holds taxels for a robot; a robot description that states its own is opened as a robot."""
    return holds_taxels(path) and not is_robot_with_taxels(path)


class FileRole(Enum):
    """As what a file is opened; the first three are named as the options of the command line are."""

    SCENE = "scene"
    ROBOT = "robot"
    SKIN = "skin"
    RECORDING = "recording"
    MAP = "map"


def role_of(path: str) -> FileRole:
    """As what ``path`` is opened, by its ending, or for robots and npz by what is in it. Cost: as ``holds_taxels``.

    Raises:
        TactileMapsError: There is no such file.
        UsageError: Nothing can be done with such a file.
    """
    if not os.path.exists(path):
        raise TactileMapsError("there is no such file", file=path)
    for role, fits in (
        (FileRole.RECORDING, is_recording),
        (FileRole.MAP, is_map),
        (FileRole.SKIN, is_taxel_file),
        (FileRole.SCENE, is_scene),
    ):
        if fits(path):
            return role
    if Path(path).suffix.lower() in (*ROBOTS, *MESHES):
        return FileRole.ROBOT
    raise _unknown(path)


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
    raise _unknown(path)


def _unknown(path: str) -> UsageError:
    known = ", ".join((*ROBOTS, *MESHES, *SCENES, *MAPS, *RECORDINGS, *TAXEL_ENDINGS, *_added_endings()))
    return UsageError(
        "this type of file cannot be opened",
        file=path,
        value=Path(path).suffix.lower() or "no file extension",
        remedy=f"Give one of: {known}",
    )
