"""Kinds of files that can be opened, with the suffixes of their names: the one table behind dialogs, drops and readers.

``tactile_maps.skin.formats.identify`` decides between kinds that share a suffix by the content of the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType


class FileKind(Enum):
    """Kind of a file; the value is its name in messages."""

    SCENE = "scene"
    ROBOT = "robot"
    ROBOT_WITH_TAXELS = "robot with taxels"
    MESH = "mesh"
    TAXELS = "taxel file"
    SKIN = "skin"
    MAP = "map"
    LAYOUT = "layout"
    RECORDING = "recording"
    ROS_RECORDING = "ROS 2 recording"
    STUDY_TABLE = "study table"
    READINGS = "table of readings"

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Suffixes of such files in lower case, without those that plug-ins add."""
        return SUFFIXES[self]


SUFFIXES: Mapping[FileKind, tuple[str, ...]] = MappingProxyType(
    {
        FileKind.SCENE: (".toml",),
        FileKind.ROBOT: (".xml", ".mjcf", ".urdf", ".xacro"),
        FileKind.ROBOT_WITH_TAXELS: (".urdf",),
        FileKind.MESH: (".obj", ".stl", ".ply", ".off", ".gltf", ".glb", ".dae", ".msh"),
        FileKind.TAXELS: (".txt", ".csv", ".tsv", ".json", ".yaml", ".yml", ".npz", ".urdf"),
        FileKind.MAP: (".npz",),
        FileKind.SKIN: (".npz",),
        FileKind.LAYOUT: (".ini",),
        FileKind.RECORDING: (".mcap",),
        FileKind.ROS_RECORDING: (".db3", ".mcap"),
        FileKind.STUDY_TABLE: (".csv", ".parquet"),
        FileKind.READINGS: (".csv",),
    }
)
SOURCES = frozenset({FileKind.ROS_RECORDING, FileKind.READINGS})
"""Kinds that are sources of readings and cannot be opened without a skin."""
ALL_SUFFIXES = tuple(dict.fromkeys(suffix for suffixes in SUFFIXES.values() for suffix in suffixes))
