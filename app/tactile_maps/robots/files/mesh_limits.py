"""Limits of the expanded size of mesh files, checked before decoding, and removal of everything but the shape.

A file of a kilobyte may state a billion vertices, show one mesh a million times, or contain a picture that unpacks to
gigabytes. Everything that a format can multiply is counted from the text of the file.
"""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import MeshError

MAX_PARTS = 10_000
"""Meshes, primitives and nodes of one file."""
MAX_DEPTH = 200
"""Nodes of a scene one below the other. The time of trimesh grows with the depth of each mesh."""
MAX_REPEATED = 2_000_000
"""Number of vertices that a file may have beyond those that it contains, by showing meshes several times."""
MAX_GROUPS = 500
"""Groups and materials of an OBJ file, or solids of an STL file, that are read apart. The time of trimesh grows with
the square of their number, and their triangles are joined afterwards."""
_GLB_HEADER = struct.Struct("<4sII")
_CHUNK_HEADER = struct.Struct("<II")
_LEAST_VERTEX_BYTES = 6
_REMEDY = "Export it again as one mesh"


def reduced_glb(data: bytes, path: Path) -> bytes:
    """Return a GLB file with the positions and triangles of the given one.

    Raises:
        MeshError: It would expand to too much.
        ValueError: It is not GLB. Damaged JSON also raises errors of other kinds.
    """
    magic, version, _ = _GLB_HEADER.unpack_from(data)
    length, kind = _CHUNK_HEADER.unpack_from(data, _GLB_HEADER.size)
    start = _GLB_HEADER.size + _CHUNK_HEADER.size
    if (magic, version, kind) != (b"glTF", 2, 0x4E4F534A):
        return data  # another version: trimesh reads it or says what is wrong
    text = json.dumps(_reduced(parse_json(data[start : start + length]), len(data), path)).encode()
    text += b" " * (-len(text) % 4)
    rest = data[start + length :]
    total = start + len(text) + len(rest)
    return _GLB_HEADER.pack(magic, version, total) + _CHUNK_HEADER.pack(len(text), kind) + text + rest


def reduced_gltf(data: bytes, path: Path) -> bytes:
    """Return a text glTF file with the positions and triangles of the given one; see ``reduced_glb``."""
    return json.dumps(_reduced(parse_json(data), len(data), path)).encode()


def _reduced(tree: dict[str, Any], size: int, path: Path) -> dict[str, Any]:
    """Return the tree without materials, pictures and unused numbers, once it is bounded."""
    accessors, meshes, nodes = (tree.get(name, []) for name in ("accessors", "meshes", "nodes"))
    primitives = [primitive for mesh in meshes for primitive in mesh["primitives"]]
    _check_parts("meshes", max(len(meshes), len(primitives)), path)
    _check_parts("nodes", len(nodes), path)
    _check_depth([node.get("children", []) for node in nodes], path)
    used: dict[int, int] = {}
    weights = []
    for mesh in meshes:
        weight = 0
        for primitive in mesh["primitives"]:
            named = [primitive["attributes"].get("POSITION"), primitive.get("indices")]
            for number in named:
                if number is not None:
                    used.setdefault(number, len(used))
                    weight += max(accessors[number]["count"], 0)
        weights.append(weight)
    shown = sum(weights[node["mesh"]] for node in nodes if "mesh" in node)
    most = MAX_REPEATED + size // _LEAST_VERTEX_BYTES
    largest = max((accessors[number]["count"] for number in used), default=0)
    for what, count in (("an accessor", largest), ("all meshes", sum(weights)), ("all nodes", shown)):
        if count > most:
            problem = "the mesh would expand to an implausible size"
            raise MeshError(
                problem,
                file=path,
                place=f"count of {what}",
                value=count,
                remedy=f"The maximum for a file of this size is {most}. {_REMEDY}",
            )
    for primitive in primitives:
        position = primitive["attributes"].get("POSITION")
        primitive["attributes"] = {} if position is None else {"POSITION": used[position]}
        if "indices" in primitive:
            primitive["indices"] = used[primitive["indices"]]
        for name in ("material", "targets"):
            primitive.pop(name, None)
    kept = {name: value for name, value in tree.items() if name not in _NO_SHAPE}
    return kept | ({"accessors": [accessors[number] for number in used]} if "accessors" in tree else {})


_NO_SHAPE = ("materials", "textures", "images", "samplers", "animations", "skins", "cameras", "extras")
"""Parts of a glTF file that do not affect its shape."""


def _check_depth(children: list[list[int]], path: Path) -> None:
    """Raise an error for nodes that are nested too deep or contain themselves."""
    below = {number for numbers in children for number in numbers}
    level = set(range(len(children))) - below
    reached = set(level)
    for _ in range(MAX_DEPTH):
        level = {number for above in level for number in children[above]}
        reached |= level
        if not level:
            break
    if level or len(reached) < len(children):
        problem = f"nodes of the mesh file contain themselves, or are more than {MAX_DEPTH} deep"
        raise MeshError(problem, file=path, place="nodes", remedy=_REMEDY)


def _check_parts(what: str, count: int, path: Path) -> None:
    if count > MAX_PARTS:
        problem = f"the mesh file has more than {MAX_PARTS} {what}"
        raise MeshError(problem, file=path, place=what, value=count, remedy=_REMEDY)


_GROUP = re.compile(rb"^(?:usemtl|o|g)\b[^\n]*$", re.MULTILINE)
_VERTEX = re.compile(rb"^[ \t]*v[ \t]", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f\b", re.MULTILINE)
_PLAIN_FACE = re.compile(rb"^[ \t]*f((?:[ \t]+\d+(?:/\d*)*)+)[ \t]*\r?$", re.MULTILINE)
"""A face in one line, without comment, whose corners are counted from the first vertex."""
_AFTER_SLASH = re.compile(rb"/[\d/]*")


def reduced_obj(data: bytes, path: Path) -> bytes:
    """Return an OBJ file without its groups and materials where it has more than ``MAX_GROUPS``.

    Raises:
        MeshError: A face names a vertex that the file does not contain; trimesh takes 0 for the last one.
    """
    _check_corners(data, path)
    return _GROUP.sub(b"", data) if len(set(_GROUP.findall(data))) > MAX_GROUPS else data


def _check_corners(data: bytes, path: Path) -> None:
    """Raise an error for the first corner of an OBJ file's faces that is not one of its vertices.

    Cost: 1.3 s for 500,000 faces with textures and normals, 2.4 s if one of them is not plain.
    """
    if _only_known_corners(data):
        return
    lines = [line.partition(b"#")[0].split() for line in data.split(b"\n")]
    count = sum(words[:1] == [b"v"] for words in lines)
    before = 0
    continued = False
    face = False
    for number, words in enumerate(lines, start=1):
        if not continued:
            before += words[:1] == [b"v"]
            face = words[:1] == [b"f"]
        for corner in words[not continued :] if face else ():
            if corner != b"\\" and not _is_corner(corner.partition(b"/")[0], before, count):
                raise MeshError(
                    f"a face names a vertex that is not among the {count} of the file",
                    file=path,
                    place=f"line {number}",
                    value=corner.decode("utf8", "replace"),
                    remedy="Number vertices from 1, or count back with negative numbers, and export the mesh again",
                )
        continued = words[-1:] == [b"\\"]


def _only_known_corners(data: bytes) -> bool:
    """Whether all faces are plain, and all their corners are vertices of the file."""
    faces = _PLAIN_FACE.findall(data)
    if len(faces) != len(_FACE.findall(data)):
        return False
    corners = np.fromstring(_AFTER_SLASH.sub(b"", b" ".join(faces)), dtype=np.int64, sep=" ")
    return bool(((corners >= 1) & (corners <= len(_VERTEX.findall(data)))).all())


def _is_corner(text: bytes, before: int, count: int) -> bool:
    """Whether a number is that of one of ``count`` vertices, or counts back from those ``before`` the face."""
    try:
        number = int(text)
    except ValueError:
        return False
    return 1 <= number <= count or -before <= number <= -1


_NEXT_SOLID = re.compile(rb"endsolid[^\n]*\n\s*solid\b[^\n]*\n")


def reduced_stl(data: bytes, _path: Path) -> bytes:
    """Return an STL file in text as one solid where it has more than ``MAX_GROUPS``."""
    return _NEXT_SOLID.sub(b"", data) if len(_NEXT_SOLID.findall(data)) > MAX_GROUPS else data


def check_collada(root: Element, path: Path) -> None:
    """Limit the expanded size of a COLLADA scene, whose library nodes may show each other many times.

    Raises:
        MeshError: It shows too many parts or too much text, or a node shows itself.
    """
    nodes = {node.get("id", ""): node for node in root.iter() if _name(node) == "node"}
    lengths = {
        geometry.get("id", ""): sum(len(part.text or "") for part in geometry.iter())
        for geometry in root.iter()
        if _name(geometry) == "geometry"
    }
    total = sum(lengths.values())
    known: dict[int, tuple[int, int]] = {}

    def expanded(element: Element, above: frozenset[int]) -> tuple[int, int]:
        """Return the numbers of parts and characters that an element shows."""
        key = id(element)
        if key in above:
            raise MeshError("a node of the file shows itself", file=path, place=element.get("id"), remedy=_REMEDY)
        if key not in known:
            parts = characters = 0
            for child in element:
                name = _name(child)
                target = child.get("url", "").removeprefix("#")
                if name == "instance_geometry":
                    more = 1, lengths.get(target, 0)
                elif name == "instance_node" and target in nodes:
                    more = expanded(nodes[target], above | {key})
                elif name == "node":
                    more = expanded(child, above | {key})
                else:
                    continue
                parts = parts + more[0]
                characters = characters + more[1]
            known[key] = parts, characters
        return known[key]

    for scene in root.iter():
        if _name(scene) == "visual_scene":
            parts, characters = expanded(scene, frozenset())
            _check_parts("parts", parts, path)
            if characters > total + 10 * MAX_REPEATED:
                problem = "the mesh would expand to an implausible size"
                raise MeshError(
                    problem, file=path, place="visual_scene", value=f"{characters} characters", remedy=_REMEDY
                )


def _name(element: Element) -> str:
    return element.tag.rpartition("}")[2]
