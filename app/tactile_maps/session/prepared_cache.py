"""Cache of prepared scenes on disk, so that a robot's skin and map are built once on a machine.

``prepare_cached`` is ``prepare`` with this cache. The key of an entry contains the request (robot, covers, grids, taxel
file, package roots), the source of the program and the versions of its libraries. An entry is used only while all files
that were read for it have the same content, so that it equals the result of ``prepare``, bit for bit. Entries are
archives as in recordings: reading one executes nothing, and a damaged entry is ignored.

The folder is ``$TACTILE_MAPS_CACHE``, or the user's cache folder; the word ``off`` disables the cache. It contains at
most ``MOST_BYTES``; the entries that were not used for the longest time are deleted first. ``tactile-maps cache`` shows
and empties it.
"""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import TypeVar

from tactile_maps.core.codec import dump_json, load_json
from tactile_maps.core.disk_cache import entries, read_entry, store_entry
from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import MAX_UNPACKED_BYTES, cache_folder, files_read, read_bounded_file
from tactile_maps.core.plugins import has_plugins
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.scene import Scene
from tactile_maps.session.bundle import robot_from_zip, robot_to_zip
from tactile_maps.session.link_levels import LinkLevels, links_digest
from tactile_maps.session.prepare import PreparedScene, check_shapes, check_start, load_robot_of, no_robot, prepare
from tactile_maps.session.program_digest import program_digest
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.skin.formats.vendors.mapping_file import mapping_path
from tactile_maps.skin.link_pieces import PIECES_SUFFIX

MOST_BYTES = 500_000_000
"""Size of all entries together. The arm takes 1 MB, the whole iCub with 4,000 taxels 12 MB."""
_FORMAT = 1
_SUFFIX = ".prepared"
_LEVELS_SUFFIX = ".levels"
_SUFFIXES = (_SUFFIX, _LEVELS_SUFFIX, PIECES_SUFFIX)
_FOLDER_VARIABLES = ("MENAGERIE_ROOT", "AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")
_SOURCES = "sources.json"
_ROBOT = "robot.zip"
_MAP = "map.npz"
T = TypeVar("T")


@dataclass(frozen=True)
class _Request:
    """Inputs of robot, skin and map, except the content of files."""

    robot: str
    taxel_files: tuple[str, ...]
    cover: CoverSpec
    grids: tuple[GridSpec, ...]
    more_covers: tuple[CoverSpec, ...]
    package_roots: tuple[str, ...]
    home: tuple[tuple[str, float], ...]
    listed: tuple[str, ...]
    folder: str
    searched: tuple[str, ...]
    program: str


@dataclass(frozen=True)
class _Source:
    path: str
    digest: str


@dataclass(frozen=True)
class _Sources:
    """Files that were read for an entry."""

    files: tuple[_Source, ...]


@dataclass(frozen=True)
class CacheContent:
    """Content of the folder.

    Attributes:
        folder: The folder; None if the cache is disabled.
        entries: Number of prepared scenes.
        size: Size of all files, with coarser links and pieces of links [bytes].
    """

    folder: Path | None
    entries: int
    size: int


def prepare_cached(
    scene: Scene, *, progress: Progress = no_progress, loaded: Callable[[Robot], None] = no_robot
) -> PreparedScene:
    """Return robot, skin, map and objects of a scene from the cache, or else from ``prepare``, and store them.

    Arguments are those of ``prepare``; ``loaded`` is not called for a cached scene.

    Cost: 0.05 to 0.2 s from the cache; otherwise that of ``prepare``, and 0.1 to 0.7 s to store the result.
    """
    found = find_prepared(scene)
    if found is not None:
        progress("Done", 1.0)
        return found
    with files_read() as read:
        prepared = prepare(scene, progress=progress, loaded=loaded)
    path = _entry_path(scene)
    # A missing mesh may be added later, so that such a robot is not stored.
    if path is not None and not any(link.missing or link.left_out for link in prepared.robot.links):
        store_entry(path, lambda: _pack(prepared, read), suffixes=_SUFFIXES, most=MOST_BYTES)
    return prepared


def find_prepared(scene: Scene) -> PreparedScene | None:
    """Return the cached robot, skin and map of a scene, with its objects; None without a valid entry.

    Raises:
        TactileMapsError: An object of the scene cannot be made.

    Cost: 0.05 to 0.2 s; under 20 ms without an entry.
    """
    kept = _read(scene, lambda entry, file: (_robot(entry, file), map_from_bytes(entry.read(_MAP))))
    if kept is None:
        return None
    robot, map_ = kept
    objects = check_start(scene, robot, map_.skin, make_objects(scene))
    return PreparedScene(scene, robot, map_.skin, map_, objects, check_shapes(scene, robot, map_.skin))


def load_robot_cached(scene: Scene) -> Robot:
    """Return the robot of a scene from the cache, or else from its file; raises the errors of ``load_robot``."""
    return _read(scene, _robot) or load_robot_of(scene)


def link_levels_cached(robot: Robot) -> LinkLevels:
    """Return the coarser surfaces of a robot's links from the cache, or else make and store them.

    Cost: 30 ms for the whole iCub from the cache; otherwise that of ``LinkLevels.make``.
    """
    folder = cache_folder()
    if folder is None:
        return LinkLevels.make(robot)
    path = folder / f"{_digest(f'{_FORMAT} {program_digest()} {links_digest(robot)}'.encode())}{_LEVELS_SUFFIX}"
    kept = read_entry(path, lambda: LinkLevels.from_bytes(_bytes_of(path), robot))
    if kept is not None:
        return kept
    levels = LinkLevels.make(robot)
    store_entry(path, levels.to_bytes, suffixes=_SUFFIXES, most=MOST_BYTES)
    return levels


def cache_content() -> CacheContent:
    """Return number, size and folder of the entries."""
    folder = cache_folder()
    found = entries(folder, _SUFFIXES) if folder is not None else []
    scenes = sum(path.suffix == _SUFFIX for path, _used, _size in found)
    return CacheContent(folder, scenes, sum(size for _path, _used, size in found))


def clear_cache() -> CacheContent:
    """Delete every entry and return the previous content. Other files in the folder are kept."""
    content = cache_content()
    if content.folder is not None:
        for path, _used, _size in entries(content.folder, _SUFFIXES):
            path.unlink(missing_ok=True)
    return content


def _robot(entry: zipfile.ZipFile, file: str) -> Robot:
    return robot_from_zip(entry.read(_ROBOT), file=file)


def _read(scene: Scene, read: Callable[[zipfile.ZipFile, str], T]) -> T | None:
    """Return the result of ``read``, called with the scene's entry and its path; None without a valid entry."""
    path = _entry_path(scene)

    def valid() -> T | None:
        with zipfile.ZipFile(str(path)) as entry:
            sources = load_json(_Sources, entry.read(_SOURCES), error=RecordingError, file=str(path))
            if not all(_digest(_bytes_of(Path(source.path))) == source.digest for source in sources.files):
                return None
            return read(entry, str(path))

    return None if path is None else read_entry(path, valid)


def _pack(prepared: PreparedScene, read: Sequence[Path]) -> bytes:
    sources = _Sources(tuple(_Source(str(file), _digest(_bytes_of(file))) for file in dict.fromkeys(read)))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(_SOURCES, dump_json(sources))
        archive.writestr(_ROBOT, robot_to_zip(prepared.robot))
        archive.writestr(_MAP, map_to_bytes(prepared.map))
    return buffer.getvalue()


def _entry_path(scene: Scene) -> Path | None:
    folder = cache_folder()
    if folder is None or (scene.taxel_files and has_plugins("importers")):
        return None  # the result of a plug-in may depend on more than the file's content
    folders = filter(os.path.isdir, scene.taxel_files)
    mappings = (mapping_path(Path(file)) for file in scene.taxel_files)
    request = _Request(
        scene.robot,
        scene.taxel_files,
        scene.cover,
        scene.grids,
        scene.more_covers,
        scene.package_roots,
        tuple(sorted(scene.home.items())),
        (  # a file may be added
            *(name for folder in folders for name in sorted(os.listdir(folder))),
            *(path.name for path in mappings if path.is_file()),
        ),
        os.getcwd(),
        tuple(os.environ.get(name, "") for name in _FOLDER_VARIABLES),
        f"{_FORMAT} {program_digest()}",
    )
    return folder / f"{_digest(dump_json(request))}{_SUFFIX}"


def _bytes_of(path: Path) -> bytes:
    return read_bounded_file(path, error=RecordingError, most=MAX_UNPACKED_BYTES)


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=16).hexdigest()
