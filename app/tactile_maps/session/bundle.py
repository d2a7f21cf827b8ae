"""Attachments of a recording that contain its prepared scene, so that the file is self-contained."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.codec import dump_json, load_json
from tactile_maps.core.errors import Finding, MeshError, RecordingError, TactileMapsError, counted
from tactile_maps.core.files import ZIP_DAMAGE, pack_array, pack_arrays, unpack_array, unpack_arrays
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.robots.files.mesh_files import parse_mesh
from tactile_maps.robots.model.mujoco_spec import robot_spec
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.robots.model.sanitize import missing_meshes
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.scene.scene_file import scene_from_toml, scene_to_toml
from tactile_maps.session.prepare import PreparedScene

DAMAGED = "The recording is damaged, or was not made by this program"
"""Remedy stated for invalid data."""
SCENE = "scene.toml"
ROBOT = "robot.zip"
MAP = "map.npz"
OBJECTS = "objects.npz"
MEDIA_TYPES = {
    SCENE: "application/toml",
    ROBOT: "application/zip",
    MAP: "application/x-npz",
    OBJECTS: "application/x-npz",
}
_HEADER = "header.json"
_MJCF = "robot.xml"
_MAX_UNPACKED = 400_000_000
_MAX_MEMBERS = 5000


def pack_scene(prepared: PreparedScene) -> dict[str, bytes]:
    """Return attachments by name: the scene as TOML, the robot as MJCF with meshes, skin, map and objects as arrays.

    Cost: 0.2 s for 1,000 taxels on our arm, 1 ms for a scene that was packed before.
    """
    return {
        SCENE: scene_to_toml(prepared.scene).encode(),
        ROBOT: robot_to_zip(prepared.robot),
        MAP: _map_to_bytes(prepared.map),
        OBJECTS: objects_to_bytes(prepared.objects),
    }


_map_to_bytes = weak_cache(map_to_bytes)


def unpack_scene(attachments: dict[str, bytes], *, file: str) -> PreparedScene:
    """Return the prepared scene of a recording's attachments.

    Raises:
        RecordingError: An attachment is missing or damaged.
    """
    missing = [name for name in MEDIA_TYPES if name not in attachments]
    if missing:
        raise RecordingError("an attachment of the recording is missing", file=file, value=missing[0], remedy=DAMAGED)
    with _damage_in(SCENE, file):
        scene = scene_from_toml(attachments[SCENE].decode(errors="replace"), name="recording")
    with _damage_in(ROBOT, file):
        robot = robot_from_zip(attachments[ROBOT], file=file)
    with _damage_in(MAP, file):
        map_ = map_from_bytes(attachments[MAP])
    with _damage_in(OBJECTS, file):
        objects = objects_from_bytes(attachments[OBJECTS], scene.objects)
    known = robot.link_index
    foreign = [patch.link for patch in map_.skin.patches if patch.link not in known]
    if foreign:
        problem = "the recording's skin is on a link that its robot does not have"
        raise RecordingError(problem, file=file, value=foreign[0], remedy=DAMAGED)
    return PreparedScene(scene, robot, map_.skin, map_, objects)


@contextmanager
def _damage_in(part: str, file: str) -> Iterator[None]:
    """Raise errors in an attachment as damage of the recording."""
    try:
        yield
    except TactileMapsError as error:
        place = ", ".join(filter(None, (part, error.place)))
        remedy = error.remedy or DAMAGED
        raise error.at(kind=RecordingError, file=file, place=place, remedy=remedy) from error


def objects_to_bytes(objects: Sequence[SceneObject]) -> bytes:
    """Return the surfaces of a scene's objects, in its order, so that their mesh files are not needed."""
    arrays: dict[str, NDArray[Any]] = {}
    for number, body in enumerate(objects):
        arrays |= {f"vertices {number}": body.mesh.vertices, f"faces {number}": body.mesh.faces}
    return pack_arrays({"names": [body.spec.name for body in objects]}, arrays)


def objects_from_bytes(data: bytes, specs: Sequence[ObjectSpec]) -> tuple[SceneObject, ...]:
    """Return the objects of a scene with the surfaces that ``objects_to_bytes`` wrote.

    Raises:
        RecordingError: The data are damaged or contain the surfaces of other objects.
    """
    header, arrays = unpack_arrays(data, error=RecordingError)
    if header.get("names") != [spec.name for spec in specs]:
        problem = "the surfaces are not those of the scene's objects"
        raise RecordingError(problem, value=header.get("names"), remedy=DAMAGED)
    try:
        meshes = [
            _checked_mesh(arrays[f"vertices {number}"], arrays[f"faces {number}"], place=f"object {spec.name}")
            for number, spec in enumerate(specs)
        ]
    except KeyError as error:
        raise RecordingError("an object has no surface", value=error, remedy=DAMAGED) from error
    return tuple(SceneObject(spec, mesh) for spec, mesh in zip(specs, meshes, strict=True))


@dataclass(frozen=True, eq=False)
class RobotHeader:
    """Attributes of a ``Robot`` without files and meshes; links by name."""

    name: str
    source: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    home: FloatArray
    findings: tuple[Finding, ...]


@weak_cache
def robot_to_zip(robot: Robot) -> bytes:
    """Return the robot as a zip: ``robot.xml`` and its files, which MuJoCo opens, and a header with the other data."""
    links = tuple(robot.link_index)
    header = RobotHeader(robot.name, robot.source, links, robot.joints, robot.home, robot.findings)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(_HEADER, dump_json(header))
        archive.writestr(_MJCF, robot.mjcf)
        for name, data in robot.assets.items():
            archive.writestr(f"assets/{name}", data)
        for number, link in enumerate(robot.links):
            if link.mesh is not None:
                archive.writestr(f"meshes/{number}.npy", pack_array(link.mesh.vertices))
                archive.writestr(f"meshes/{number}.faces.npy", pack_array(link.mesh.faces))
    return buffer.getvalue()


def robot_from_zip(data: bytes, *, file: str) -> Robot:
    """Read the robot from a zip of ``robot_to_zip``; nothing is written to disk, and no path in it is followed.

    Raises:
        RecordingError: The zip is damaged, would unpack to an implausible size, or names files outside itself.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_members(archive.infolist(), file)
            parts = {name: archive.read(name) for name in archive.namelist()}
        mjcf = parts[_MJCF].decode()
        found = parts[_HEADER]
    except (*ZIP_DAMAGE, KeyError) as error:
        raise RecordingError("the recording's robot is damaged", file=file, value=error, remedy=DAMAGED) from error
    header = load_json(RobotHeader, found, error=RecordingError, place=_HEADER, file=file, remedy=DAMAGED)
    if header.home.shape != (len(header.joints),):
        where = f"{_HEADER}: home"
        raise RecordingError(
            "expected one number per joint", file=file, place=where, value=header.home.shape, remedy=DAMAGED
        )
    assets = {name.removeprefix("assets/"): part for name, part in parts.items() if name.startswith("assets/")}
    for name, part in assets.items():
        _check_asset(name, part, file)
    # Check the text now; a session compiles it later.
    spec = robot_spec(Robot(header.name, file, mjcf, assets, (), (), header.home))
    missing = missing_meshes(spec, assets)
    links = tuple(
        Link(name, _mesh(parts, number, file), missing.get(name, ())) for number, name in enumerate(header.links)
    )
    return Robot(header.name, header.source, mjcf, assets, links, header.joints, header.home, header.findings)


def _check_asset(name: str, data: bytes, file: str) -> None:
    """Raise an error for a file that is not a mesh as this program writes them; MuJoCo would read it unchecked."""
    if not name.endswith(".msh"):
        problem = "a file of the recording's robot is not a mesh"
        raise RecordingError(problem, file=file, place=ROBOT, value=name, remedy=DAMAGED)
    parse_mesh(data, Path(name), weld=False)


def _check_members(members: list[zipfile.ZipInfo], file: str) -> None:
    for member in members:
        path = PurePosixPath(member.filename)
        if path.is_absolute() or ".." in path.parts or "\\" in member.filename:
            problem = "the recording's robot names a file outside itself"
            raise RecordingError(problem, file=file, value=member.filename, remedy=DAMAGED)
    if len(members) > _MAX_MEMBERS or sum(member.file_size for member in members) > _MAX_UNPACKED:
        problem = "the recording's robot would unpack to an implausible size"
        raise RecordingError(problem, file=file, value=counted(len(members), "file"), remedy=DAMAGED)


def _mesh(parts: dict[str, bytes], number: int, file: str) -> Mesh | None:
    names = {"vertices": f"meshes/{number}.npy", "faces": f"meshes/{number}.faces.npy"}
    if names["vertices"] not in parts:
        return None
    if names["faces"] not in parts:
        raise RecordingError("a mesh has no faces", file=file, place=names["faces"], remedy=DAMAGED)
    arrays = {
        key: unpack_array(parts[name], place=name, file=file, error=RecordingError) for key, name in names.items()
    }
    return _checked_mesh(**arrays, file=file, place=f"link {number}")


def _checked_mesh(vertices: NDArray[Any], faces: NDArray[Any], *, place: str, file: str | None = None) -> Mesh:
    """Return the mesh of untrusted arrays."""
    kinds = (vertices.dtype.kind, faces.dtype.kind)
    shapes = (vertices.shape[1:], faces.shape[1:])
    if kinds[0] != "f" or kinds[1] not in "iu" or shapes != ((3,), (3,)):
        found = f"{vertices.shape} {vertices.dtype}, {faces.shape} {faces.dtype}"
        raise RecordingError("the arrays do not describe a mesh", file=file, place=place, value=found, remedy=DAMAGED)
    try:
        return Mesh(vertices, faces)
    except MeshError as error:
        where = ", ".join(filter(None, (place, error.place)))
        raise error.at(kind=RecordingError, file=file, place=where, remedy=DAMAGED) from error
