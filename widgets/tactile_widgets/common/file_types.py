"""Files that the window opens, and the filters of its file dialogs."""

from __future__ import annotations

from tactile_maps.core.file_kinds import FileKind
from tactile_maps.skin.formats.identify import suffixes_of

OPENED = frozenset(FileKind) - {FileKind.LAYOUT, FileKind.ROS_RECORDING}
"""Kinds that the window opens when they are chosen, dropped or named on the command line."""
ROBOTS = (FileKind.ROBOT, FileKind.ROBOT_WITH_TAXELS, FileKind.MESH)


def file_filter(title: str, *kinds: FileKind) -> str:
    """Return the filter of a file dialog for some kinds, with the suffixes of plug-ins."""
    suffixes = dict.fromkeys(suffix for kind in kinds for suffix in suffixes_of(kind))
    return f"{title} ({' '.join(f'*{suffix}' for suffix in suffixes)})"


def taxel_filter() -> str:
    """Return the filter for files with taxels, among them robots that state their own."""
    return file_filter("Taxels", FileKind.TAXELS, FileKind.SKIN, FileKind.ROBOT)


ROBOT_FILTER = file_filter("Robots and meshes", *ROBOTS, FileKind.SCENE)
RECORDING_FILTER = file_filter("Recordings", FileKind.RECORDING)
SCENE_FILTER = file_filter("Scenes", FileKind.SCENE)
STUDY_FILTER = file_filter("Tables of studies", FileKind.STUDY_TABLE)
SCRIPT_FILTER = "Stimulus scripts (*.toml)"
