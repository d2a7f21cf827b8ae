"""A prepared scene as attachments of a recording, so that the file stands alone."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.core.errors import Finding, RecordingError, TactileMapsError
from app.core.files import pack_arrays, unpack_arrays
from app.geometry.mesh import Mesh
from app.maps.formats.map_file import map_from_bytes, map_to_bytes
from app.robots.robot import Joint, Link, Robot
from app.scene.objects import ObjectSpec, SceneObject
from app.scene.scene_file import scene_from_toml, scene_to_toml
from app.session.prepare import PreparedScene

SCENE, ROBOT, MAP, OBJECTS = "scene.toml", "robot.zip", "map.npz", "objects.npz"
MEDIA_TYPES = {
    SCENE: "application/toml",
    ROBOT: "application/zip",
    MAP: "application/x-npz",
    OBJECTS: "application/x-npz",
}
_MAX_UNPACKED = 1_000_000_000
_MAX_MEMBERS = 5000


def pack_scene(prepared: PreparedScene) -> dict[str, bytes]:
    """Attachments by name: the scene as TOML, the robot as MJCF with its meshes, skin, map and objects as arrays."""
    return {
        SCENE: scene_to_toml(prepared.scene).encode(),
        ROBOT: robot_to_zip(prepared.robot),
        MAP: map_to_bytes(prepared.map),
        OBJECTS: objects_to_bytes(prepared.objects),
    }


def unpack_scene(attachments: dict[str, bytes], *, file: str) -> PreparedScene:
    """The prepared scene of a recording's attachments.

    Raises:
        RecordingError: One is missing or damaged.
    """
    missing = [name for name in MEDIA_TYPES if name not in attachments]
    if missing:
        raise RecordingError(
            "the recording does not hold what it was made with",
            file=file,
            value=missing[0],
            remedy="Only recordings made by this program can be replayed",
        )
    try:
        scene = scene_from_toml(attachments[SCENE].decode(), name="recording")
        robot = robot_from_zip(attachments[ROBOT], file=file)
        map_ = map_from_bytes(attachments[MAP])
        objects = objects_from_bytes(attachments[OBJECTS], scene.objects)
    except UnicodeDecodeError as error:
        raise RecordingError("the recording's scene is damaged", file=file, value=error) from error
    except TactileMapsError as error:
        raise RecordingError(
            f"the recording is damaged: {error.problem}",
            file=file,
            place=error.place,
            value=error.value,
            remedy=error.remedy,
        ) from error
    known = robot.link_index
    foreign = [patch.link for patch in map_.skin.patches if patch.link not in known]
    if foreign:
        raise RecordingError(
            "the recording's skin is worn by a link its robot does not have", file=file, value=foreign[0]
        )
    return PreparedScene(scene, robot, map_.skin, map_, objects)


def objects_to_bytes(objects: Sequence[SceneObject]) -> bytes:
    """The surfaces of a scene's objects, in its order: no file of a mesh is needed to have them again."""
    arrays: dict[str, NDArray[Any]] = {}
    for number, body in enumerate(objects):
        arrays |= {f"vertices {number}": body.mesh.vertices, f"faces {number}": body.mesh.faces}
    return pack_arrays({"names": [body.spec.name for body in objects]}, arrays)


def objects_from_bytes(data: bytes, specs: Sequence[ObjectSpec]) -> tuple[SceneObject, ...]:
    """The objects of a scene with their surfaces of ``objects_to_bytes``.

    Raises:
        RecordingError: Damaged, or not the surfaces of these objects.
        MeshError: A surface is none.
    """
    header, arrays = unpack_arrays(data, error=RecordingError)
    if header.get("names") != [spec.name for spec in specs]:
        raise RecordingError("the surfaces are not those of the scene's objects", value=header.get("names"))
    try:
        meshes = [Mesh(arrays[f"vertices {number}"], arrays[f"faces {number}"]) for number in range(len(specs))]
    except (KeyError, ValueError) as error:
        raise RecordingError("an object's surface is damaged", value=error) from error
    return tuple(SceneObject(spec, mesh) for spec, mesh in zip(specs, meshes, strict=True))


def robot_to_zip(robot: Robot) -> bytes:
    """The robot as a zip: ``robot.xml`` and its files (any MuJoCo tool opens them), and a header for what is ours."""
    header = {
        "name": robot.name,
        "source": robot.source,
        "links": [link.name for link in robot.links],
        "joints": [[j.name, j.lower, j.upper, j.slide] for j in robot.joints],
        "home": robot.home.tolist(),
        "findings": [asdict(finding) for finding in robot.findings],
    }
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("header.json", json.dumps(header))
        archive.writestr("robot.xml", robot.mjcf)
        for name, data in robot.assets.items():
            archive.writestr(f"assets/{name}", data)
        for number, link in enumerate(robot.links):
            if link.mesh is not None:
                archive.writestr(f"meshes/{number}.npy", _array(link.mesh.vertices))
                archive.writestr(f"meshes/{number}.faces.npy", _array(link.mesh.faces))
    return buffer.getvalue()


def robot_from_zip(data: bytes, *, file: str) -> Robot:
    """The robot of such a zip; nothing is written to disk, and no path in it is followed.

    Raises:
        RecordingError: It is damaged, would unpack to an absurd size, or names files outside itself.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            _check_members(archive.infolist(), file)
            parts = {name: archive.read(name) for name in archive.namelist()}
        header = json.loads(parts["header.json"])
        links = tuple(Link(str(name), _mesh(parts, number)) for number, name in enumerate(header["links"]))
        return Robot(
            name=str(header["name"]),
            source=str(header["source"]),
            mjcf=parts["robot.xml"].decode(),
            assets={name.removeprefix("assets/"): part for name, part in parts.items() if name.startswith("assets/")},
            links=links,
            joints=tuple(Joint(str(n), float(low), float(high), bool(s)) for n, low, high, s in header["joints"]),
            home=np.array(header["home"], dtype=np.float64),
            findings=tuple(Finding(**finding) for finding in header["findings"]),
        )
    except (
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,
        OSError,
        ValueError,
        KeyError,
        TypeError,
        RuntimeError,
        EOFError,
    ) as error:
        raise RecordingError("the recording's robot is damaged", file=file, value=error) from error


def _check_members(members: list[zipfile.ZipInfo], file: str) -> None:
    for member in members:
        path = PurePosixPath(member.filename)
        if path.is_absolute() or ".." in path.parts or "\\" in member.filename:
            raise RecordingError("the recording's robot names a file outside itself", file=file, value=member.filename)
    if len(members) > _MAX_MEMBERS or sum(member.file_size for member in members) > _MAX_UNPACKED:
        raise RecordingError(
            "the recording's robot would unpack to an absurd size", file=file, value=f"{len(members)} files"
        )


def _array(values: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, values, allow_pickle=False)
    return buffer.getvalue()


def _mesh(parts: dict[str, bytes], number: int) -> Mesh | None:
    if f"meshes/{number}.npy" not in parts:
        return None
    vertices = np.load(io.BytesIO(parts[f"meshes/{number}.npy"]), allow_pickle=False)
    return Mesh(vertices, np.load(io.BytesIO(parts[f"meshes/{number}.faces.npy"]), allow_pickle=False))
