"""Prepared scenes kept on disk, so that a robot's skin and map are made once on a machine.

``prepare_cached`` is ``prepare`` with a memory. An entry is found by what is asked for (robot, cover, grids, taxel
file, package roots), the program (the text of its modules) and the libraries it computes with; it is used only while
every file that was read for it still has the same content. So an entry is what ``prepare`` would make now, bit for bit,
or it is not used. Entries are archives as in recordings: reading one executes nothing, and a damaged one counts as
none.

The folder is ``$TACTILE_MAPS_CACHE``, or the user's cache folder; the word ``off`` keeps nothing. It holds at most
``MOST_BYTES``: those longest unused go first. ``tactile-maps cache`` shows and empties it.
"""

from __future__ import annotations

import logging
import os
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from itertools import chain
from pathlib import Path
from typing import TypeVar

from tactile_maps.core.codec import dump_json, load_json
from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.core.files import (
    MAX_UNPACKED_BYTES,
    ZIP_DAMAGE,
    cache_folder,
    files_read,
    open_atomically,
    read_bounded_file,
)
from tactile_maps.core.plugins import has_plugins
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.scene import Scene
from tactile_maps.session.bundle import robot_from_zip, robot_to_zip
from tactile_maps.session.link_levels import LinkLevels, links_digest
from tactile_maps.session.prepare import PreparedScene, check_shapes, check_start, load_robot_of, prepare
from tactile_maps.session.program_digest import program_digest
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.fit import GridSpec
from tactile_maps.skin.link_pieces import PIECES_SUFFIX

MOST_BYTES = 500_000_000
"""Of all entries together. The arm has 1 MB, the whole iCub with 4,000 taxels 12 MB."""
_FORMAT = 1
_SUFFIX = ".prepared"
_LEVELS_SUFFIX = ".levels"
_FOLDER_VARIABLES = ("MENAGERIE_ROOT", "AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")
_SOURCES = "sources.json"
_ROBOT = "robot.zip"
_MAP = "map.npz"
T = TypeVar("T")
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Question:
    """What robot, skin and map depend on, besides files."""

    robot: str
    taxel_file: str
    cover: CoverSpec
    grids: tuple[GridSpec, ...]
    package_roots: tuple[str, ...]
    home: tuple[tuple[str, float], ...]
    taxel_files: tuple[str, ...]
    folder: str
    searched: tuple[str, ...]
    program: str


@dataclass(frozen=True)
class _Source:
    """A file that was read, and the digest of its content."""

    path: str
    digest: str


@dataclass(frozen=True)
class _Sources:
    files: tuple[_Source, ...]


@dataclass(frozen=True)
class CacheContent:
    """What the folder holds.

    Attributes:
        folder: None where nothing is kept.
        entries: How many prepared scenes.
        size: Of them together, with the coarser links and the pieces of links of their robots [bytes].
    """

    folder: Path | None
    entries: int
    size: int


def prepare_cached(scene: Scene, *, progress: Progress = no_progress) -> PreparedScene:
    """Robot, skin, map and objects of a scene: those kept, or made now and kept. Arguments and errors as ``prepare``.

    Cost: 0.05 to 0.2 s where it is kept; else that of ``prepare`` and 0.1 to 0.7 s to keep it.
    """
    found = find_prepared(scene)
    if found is not None:
        progress("Done", 1.0)
        return found
    with files_read() as read:
        prepared = prepare(scene, progress=progress)
    _keep(prepared, read)
    return prepared


def find_prepared(scene: Scene) -> PreparedScene | None:
    """The kept robot, skin and map of a scene, with its objects; None where there is none that is still true.

    Raises:
        TactileMapsError: An object of the scene cannot be made.

    Cost: 0.05 to 0.2 s; under 20 ms where there is none.
    """
    kept = _read(scene, lambda entry, file: (_robot(entry, file), map_from_bytes(entry.read(_MAP))))
    if kept is None:
        return None
    robot, map_ = kept
    objects = check_start(scene, robot, map_.skin, make_objects(scene))
    return PreparedScene(scene, robot, map_.skin, map_, objects, check_shapes(scene, robot, map_.skin))


def load_robot_cached(scene: Scene) -> Robot:
    """The robot of a scene: the one kept with its skin and map, or loaded now; errors as ``load_robot``."""
    return _read(scene, _robot) or load_robot_of(scene)


def _robot(entry: zipfile.ZipFile, file: str) -> Robot:
    return robot_from_zip(entry.read(_ROBOT), file=file)


def _read(scene: Scene, read: Callable[[zipfile.ZipFile, str], T]) -> T | None:
    """What ``read`` finds in the scene's entry, whose file it is told; None without a whole one that is still true."""
    path = _entry_path(scene)
    if path is None or not os.path.isfile(path):
        return None
    try:
        with zipfile.ZipFile(path) as entry:
            sources = load_json(_Sources, entry.read(_SOURCES), error=RecordingError, file=str(path))
            if not all(_digest_of(Path(source.path)) == source.digest for source in sources.files):
                return None
            found = read(entry, str(path))
    except (*ZIP_DAMAGE, KeyError, TactileMapsError) as damage:
        _log.info("A prepared scene cannot be used and is made anew: %s: %s", path, damage)
        return None
    _touch(path)
    return found


def link_levels_cached(robot: Robot) -> LinkLevels:
    """The coarser surfaces of a robot's links: those kept, or made now and kept.

    Cost: 30 ms for the whole iCub where they are kept; else that of ``LinkLevels.make``.
    """
    folder = cache_folder()
    if folder is None:
        return LinkLevels.make(robot)
    path = folder / f"{_digest(f'{_FORMAT} {program_digest()} {links_digest(robot)}'.encode())}{_LEVELS_SUFFIX}"
    if path.is_file():
        try:
            data = read_bounded_file(path, error=RecordingError, most=MAX_UNPACKED_BYTES)
            kept = LinkLevels.from_bytes(data, robot)
        except TactileMapsError as damage:
            _log.info("Coarser links cannot be used and are made anew: %s: %s", path, damage)
        else:
            _touch(path)
            return kept
    levels = LinkLevels.make(robot)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with open_atomically(path, error=RecordingError) as stream:
            stream.write(levels.to_bytes())
        _forget_the_longest_unused(folder)
    except (OSError, TactileMapsError) as failure:
        _log.info("Coarser links could not be kept: %s", failure)
    return levels


def cache_content() -> CacheContent:
    """How much is kept, and where."""
    folder = cache_folder()
    found = _entries(folder) if folder is not None else []
    scenes = sum(path.suffix == _SUFFIX for path, _used, _size in found)
    return CacheContent(folder, scenes, sum(size for _path, _used, size in found))


def clear_cache() -> CacheContent:
    """Remove every entry; what was there is returned. Other files in the folder stay."""
    content = cache_content()
    if content.folder is not None:
        for path, _used, _size in _entries(content.folder):
            path.unlink(missing_ok=True)
    return content


def _entry_path(scene: Scene) -> Path | None:
    folder = cache_folder()
    if folder is None or (scene.taxel_file and has_plugins("importers")):
        return None  # what a plug-in reads is not known by its content alone
    question = _Question(
        scene.robot,
        scene.taxel_file,
        scene.cover,
        scene.grids,
        scene.package_roots,
        tuple(sorted(scene.home.items())),
        _names_in(scene.taxel_file),
        os.getcwd(),
        tuple(os.environ.get(name, "") for name in _FOLDER_VARIABLES),
        f"{_FORMAT} {program_digest()}",
    )
    return folder / f"{_digest(dump_json(question))}{_SUFFIX}"


def _names_in(taxel_file: str) -> tuple[str, ...]:
    """What a folder of taxel files holds: one that is added is a new skin."""
    folder = Path(taxel_file)
    return tuple(sorted(os.listdir(folder))) if taxel_file and os.path.isdir(folder) else ()


def _keep(prepared: PreparedScene, read: Sequence[Path]) -> None:
    """Write the entry; where that fails the scene is made anew the next time, which is all that is lost."""
    path = _entry_path(prepared.scene)
    if path is None or any(link.missing or link.left_out for link in prepared.robot.links):
        return  # a mesh that is missing may come
    try:
        sources = _Sources(tuple(_Source(str(file), _digest_of(file)) for file in dict.fromkeys(read)))
        path.parent.mkdir(parents=True, exist_ok=True)
        with open_atomically(path, error=RecordingError) as stream, zipfile.ZipFile(stream, "w") as archive:
            archive.writestr(_SOURCES, dump_json(sources))
            archive.writestr(_ROBOT, robot_to_zip(prepared.robot))
            archive.writestr(_MAP, map_to_bytes(prepared.map))
        _forget_the_longest_unused(path.parent)
    except (OSError, TactileMapsError) as failure:
        _log.info("A prepared scene could not be kept: %s", failure)


def _forget_the_longest_unused(folder: Path) -> None:
    entries = sorted(_entries(folder), key=lambda entry: entry[1], reverse=True)
    total = 0
    for path, _used, size in entries:
        total += size
        if total > MOST_BYTES:
            path.unlink(missing_ok=True)


def _entries(folder: Path) -> list[tuple[Path, float, int]]:
    """Each entry, when it was last used, and its size [bytes]; another process may remove some meanwhile."""
    found = []
    for path in chain.from_iterable(folder.glob(f"*{suffix}") for suffix in (_SUFFIX, _LEVELS_SUFFIX, PIECES_SUFFIX)):
        try:
            status = path.stat()
        except FileNotFoundError:
            continue
        found.append((path, status.st_mtime, status.st_size))
    return found


def _touch(path: Path) -> None:
    try:
        os.utime(path)
    except OSError:
        _log.info("The folder of prepared scenes cannot be written: %s", path.parent)


def _digest_of(path: Path) -> str:
    """Of a file's content.

    Raises:
        RecordingError: It is no longer there.
    """
    return _digest(read_bounded_file(path, error=RecordingError, most=MAX_UNPACKED_BYTES))


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()
