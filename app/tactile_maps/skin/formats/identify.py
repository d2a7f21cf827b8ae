"""Kinds of files, by suffix, and by content where several kinds share the suffix.

The window, the command line and the library all use it. Only a bounded part of the file is read. A damaged file has the
kind of its suffix, so that the function that reads this kind reports the damage.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import BinaryIO

from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.core.file_kinds import SUFFIXES, FileKind
from tactile_maps.core.files import MAX_UNPACKED_BYTES, array_format, open_regular_file, text_encoding
from tactile_maps.robots.formats.touch_sensors import states_touch_sensors
from tactile_maps.skin.formats.npz import FORMAT as TAXEL_FORMAT
from tactile_maps.skin.formats.taxel_files import SPREADSHEETS, TAXEL_FORMATS, taxel_format_for
from tactile_maps.skin.formats.vendors.documents import names_readings, separator_of
from tactile_maps.skin.model.skin_file import FORMAT, MAP_FORMAT

_HEAD_BYTES = 4096
_MCAP_HEADER = struct.Struct("<8sBQ")  # magic, opcode, length; MCAP specification, Header (op=0x01)
_MCAP_MAGIC = b"\x89MCAP0\r\n"
MJCF_SUFFIXES = (".xml", ".mjcf")
_CONNECT = "Connect to it as a source of readings, with File > Connect or the command listen"
_REMEDIES = {
    FileKind.LAYOUT: "Open it alone as a flat skin, or with the positions file of the same patch as its drawn map",
    FileKind.ROS_RECORDING: _CONNECT,
    FileKind.READINGS: _CONNECT,
}
"""Remedies for files that cannot be opened on their own."""


def identify(path: str | Path, *, expected: Collection[FileKind] = tuple(FileKind)) -> FileKind:
    """Return the kind of the file at ``path``; a folder of iCub positions files is a taxel file.

    Args:
        path: File or folder.
        expected: Kinds that the caller can open.

    Raises:
        TactileMapsError: The file does not exist.
        UsageError: It is another folder, or its kind is unknown or not expected; the message lists the suffixes that
            can be opened.

    Cost: reading 4 kB; for URDF files, reading the file.
    """
    if not os.path.exists(path):
        raise TactileMapsError("there is no such file", file=path)
    kind = kind_of(path)
    if kind is not None and kind in expected:
        return kind
    if kind is None and os.path.isdir(path):
        remedy = "Choose a file in it, or a folder of a skin's positions files (*.txt)"
        raise UsageError("this is a folder, not a file", file=path, remedy=remedy)
    known = dict.fromkeys(suffix for kind in expected for suffix in suffixes_of(kind))
    raise UsageError(
        "this type of file cannot be opened" if kind is None else f"a {kind.value} cannot be opened here",
        file=path,
        value=Path(path).suffix.lower() or "no file extension",
        remedy=_REMEDIES.get(kind) if kind in _REMEDIES else f"Give one of: {', '.join(known)}",
    )


def kind_of(path: str | Path) -> FileKind | None:
    """Return the kind of the file at ``path``; None for any other name, such as that of a robot or scene.

    A file that does not exist or cannot be read has the first kind of its suffix. A spreadsheet counts as a taxel file,
    whose reading names the remedy.
    """
    path = Path(path)
    if os.path.isdir(path):
        return _kind_of_folder(path)
    suffix = path.suffix.lower()
    if suffix in SPREADSHEETS:
        return FileKind.TAXELS
    kind = next((kind for kind, suffixes in SUFFIXES.items() if suffix in suffixes), None)
    try:
        if suffix in _SNIFFERS:
            with open_regular_file(path, error=TactileMapsError) as stream:
                kind = _SNIFFERS[suffix](stream)
        if kind is FileKind.ROBOT and suffix == ".urdf" and taxel_format_for(path) is not None:
            return FileKind.ROBOT_WITH_TAXELS
        if kind is None and taxel_format_for(path) is not None:
            return FileKind.TAXELS
    except TactileMapsError:
        pass  # reported when the file is read
    return kind


def suffixes_of(kind: FileKind) -> tuple[str, ...]:
    """Return the suffixes of a kind of file, including those of plug-ins."""
    added = (suffix for form in TAXEL_FORMATS.values() for suffix in form.endings) if kind is FileKind.TAXELS else ()
    return (*SUFFIXES[kind], *added)


def is_robot_with_taxels(path: str | Path, kind: FileKind | None) -> bool:
    """Whether the file is a robot that states taxels: a URDF with shapes too, or an MJCF model with touch sensors.

    Args:
        path: The file.
        kind: Its kind.

    Cost: an MJCF model is read with the files that it includes.
    """
    if kind is FileKind.ROBOT and Path(path).suffix.lower() in MJCF_SUFFIXES:
        return states_touch_sensors(Path(path))
    return kind is FileKind.ROBOT_WITH_TAXELS


def holds_taxels(path: str | Path, kind: FileKind | None, *, robots: bool = True) -> bool:
    """Whether a skin can be read from the file without placing taxels.

    Args:
        path: The file.
        kind: Its kind.
        robots: Include robots that state their taxels.
    """
    stated = (FileKind.TAXELS, FileKind.LAYOUT, FileKind.SKIN, FileKind.MAP)
    return kind in stated or (robots and is_robot_with_taxels(path, kind))


def _kind_of_folder(folder: Path) -> FileKind | None:
    if any(folder.glob("*.txt")):
        return FileKind.TAXELS
    return FileKind.ROS_RECORDING if (folder / "metadata.yaml").is_file() else None


def _arrays(stream: BinaryIO) -> FileKind:
    """Sniff an npz: a table of taxels that another program wrote has no format; maps and damaged files are maps."""
    zipped = stream.read(2) == b"PK"
    found = array_format(stream) if os.fstat(stream.fileno()).st_size <= MAX_UNPACKED_BYTES else MAP_FORMAT
    if found == FORMAT:
        return FileKind.SKIN
    return FileKind.TAXELS if zipped and found in (None, TAXEL_FORMAT) else FileKind.MAP


def _urdf(stream: BinaryIO) -> FileKind:
    data = stream.read(MAX_UNPACKED_BYTES)
    if b"<tactile" not in data:
        return FileKind.ROBOT
    return FileKind.ROBOT_WITH_TAXELS if b"<visual" in data or b"<collision" in data else FileKind.TAXELS


def _table(stream: BinaryIO) -> FileKind:
    """Sniff a CSV: the table of a study has a column ``seed``, and one of readings a time and taxels by number."""
    head = stream.read(_HEAD_BYTES)
    lines = head.decode(text_encoding(head), "replace").splitlines()
    header = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    columns = header.strip().split(separator_of(header))
    if "seed" in columns:
        return FileKind.STUDY_TABLE
    return FileKind.READINGS if names_readings(columns) else FileKind.TAXELS


def _mcap(stream: BinaryIO) -> FileKind:
    """Sniff an MCAP file: the header names the library that wrote it, which is this program for our own recordings."""
    head = stream.read(_HEAD_BYTES)
    try:
        magic, opcode, _ = _MCAP_HEADER.unpack_from(head)
        (profile,) = struct.unpack_from("<I", head, _MCAP_HEADER.size)
        (library,) = struct.unpack_from("<I", head, _MCAP_HEADER.size + 4 + profile)
    except struct.error:
        return FileKind.RECORDING
    start = _MCAP_HEADER.size + 8 + profile
    foreign = (magic, opcode) == (_MCAP_MAGIC, 1) and head[start : start + library] != b"tactile-maps"
    return FileKind.ROS_RECORDING if foreign else FileKind.RECORDING


_SNIFFERS: Mapping[str, Callable[[BinaryIO], FileKind]] = {
    ".npz": _arrays,
    ".urdf": _urdf,
    ".csv": _table,
    ".mcap": _mcap,
}
