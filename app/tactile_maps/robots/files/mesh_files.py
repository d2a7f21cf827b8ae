"""Reading of mesh files of all formats as checked meshes, and writing in MuJoCo's format.

``AssetStore`` collects the mesh files of a robot under bare names, in a form that MuJoCo reads safely.
"""

from __future__ import annotations

import io
import logging
import os
import struct
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import chain, count
from json import JSONDecodeError
from pathlib import Path
from urllib.parse import unquote
from xml.etree.ElementTree import tostring

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import Finding, MeshError, RobotError, counted
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_limits import check_collada, reduced_glb, reduced_gltf, reduced_obj, reduced_stl
from tactile_maps.robots.files.plain_meshes import (
    read_binary_stl,
    read_plain_obj,
    short_faces,
    stl_truncation,
    tidy_obj,
)
from tactile_maps.robots.files.safe_files import parse_xml, read_bytes, resolve_inside

MESH_SUFFIXES = FileKind.MESH.suffixes
FOREIGN_FORMATS = {
    ".fbx": "Open it in Blender and export glTF (.glb)",
    ".blend": "Open it in Blender and export glTF (.glb)",
    ".step": "Open it in FreeCAD or another CAD program and export STL or glTF",
    ".stp": "Open it in FreeCAD or another CAD program and export STL or glTF",
    ".iges": "Open it in FreeCAD or another CAD program and export STL or glTF",
    ".3ds": "Open it in Blender and export glTF (.glb)",
}
"""Unsupported formats of meshes, with the remedy."""
MAX_FACES = 5_000_000
MAX_REPEATED_FACES = 400_000
"""Triangles that a robot may make of mesh files beyond twice those that the files contain. MuJoCo takes 1.5 kB each."""
MAX_COORDINATE = 1e7
# m, of the bounding box's diagonal
LARGEST_IN_METRES = 10.0
SMALLEST_IN_METRES = 1e-3
_FAR = 1e3  # sizes from the origin
logging.getLogger("trimesh").addHandler(logging.NullHandler())  # errors are reported as MeshError instead


def _parser_errors() -> tuple[type[Exception], ...]:
    """Return the errors that third-party parsers raise for invalid files; called only after an error."""
    from collada.common import DaeError  # 70 ms, because it imports a library of images

    return (
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        AttributeError,
        NameError,
        AssertionError,
        NotImplementedError,
        MemoryError,
        OverflowError,
        RecursionError,
        EOFError,
        struct.error,
        DaeError,
        DeprecationWarning,
    )


def read_mesh(path: Path) -> Mesh:
    """Read the triangles of a mesh file in its units, as one mesh; corners at the same place become one vertex.

    Raises:
        RobotError: The file is missing, a folder or larger than 64 MB.
        MeshError: The mesh cannot be read, is empty, or contains numbers that are not finite.
    """
    return parse_mesh(read_bytes(path), path)


def read_mesh_in_metres(path: Path, *, where: str) -> tuple[Mesh, tuple[Finding, ...]]:
    """Read a mesh like ``read_mesh``, in metres as ``to_metres`` assumes; findings also report what is left out.

    Args:
        path: The file.
        where: Name of the file, for findings.
    """
    read, left_out = _parsed(read_bytes(path), path, weld=True, where=where)
    mesh, assumed = to_metres(read, where=where)
    return mesh, (*left_out, *assumed)


def parse_mesh(data: bytes, path: Path, *, weld: bool = True) -> Mesh:
    """Read a mesh like ``read_mesh`` from bytes.

    Args:
        data: Content of the file.
        path: Path, whose suffix states the format.
        weld: Make corners at the same place one vertex. Not needed for files that ``AssetStore`` wrote.
    """
    return _parsed(data, path, weld=weld, where="")[0]


def _parsed(data: bytes, path: Path, *, weld: bool, where: str) -> tuple[Mesh, tuple[Finding, ...]]:
    check_format(path)
    if data.startswith(_LFS_POINTER):
        raise MeshError(
            "the file is a Git LFS pointer, not the mesh itself",
            file=path,
            remedy="Run `git lfs pull` in its repository",
        )
    if not data.strip():
        raise MeshError("the file is empty", file=path, remedy="Export it again")
    vertices, faces, findings = _triangles(data, path, where=where)
    if not len(faces):
        raise MeshError("the mesh has no triangles", file=path, remedy="Export it again with its surface")
    return _checked_mesh(vertices, faces, path, weld=weld), findings


def _checked_mesh(vertices: FloatArray, faces: IntArray, path: Path, *, weld: bool) -> Mesh:
    _check_limits(vertices, faces, path)
    try:
        mesh = Mesh(vertices, faces)
        return Mesh(*_weld(vertices, mesh.faces)) if weld else mesh
    except MeshError as error:
        raise error.at(file=path) from error


def _triangles(data: bytes, path: Path, *, where: str) -> tuple[FloatArray, IntArray, tuple[Finding, ...]]:
    """Return the vertices (n, 3) and faces (m, 3) of a file, and what was left out; a file of points has no faces."""
    suffix = path.suffix.lower()
    cut = stl_truncation(data) if suffix == ".stl" else ""
    if cut:
        raise MeshError(cut, file=path, remedy="Copy or export it again")
    if suffix == ".obj":
        data = tidy_obj(data)
    try:
        plain = _PLAIN_READERS[suffix](data) if suffix in _PLAIN_READERS else None
        if plain is not None:
            return *plain, ()
        short, first = short_faces(data) if suffix == ".obj" else (0, 0)
        action = f"fewer than three corners, dropped; the first is in line {first}"
        findings = (Finding("short-face", where, action, short),) if short else ()
        return *_by_trimesh(data, suffix, path), findings
    except _parser_errors() as error:
        line = f"line {error.lineno}" if isinstance(error, JSONDecodeError) else None
        form = suffix[1:].upper()
        problem = f"the mesh cannot be read: it is damaged, has no triangles, or is not in {form} format"
        remedy = "Export it again with its triangles, for example as STL"
        raise MeshError(problem, file=path, place=line, remedy=remedy) from error


def check_format(path: Path) -> None:
    """Raise an error for an unsupported format, before the file is opened.

    Raises:
        MeshError: It states what to export instead if the format is known.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        remedy = FOREIGN_FORMATS.get(suffix) or f"Convert it to one of: {', '.join(MESH_SUFFIXES)}"
        value = path.suffix or "no file extension"
        raise MeshError("the mesh format is not supported", file=path, value=value, remedy=remedy)


def to_metres(mesh: Mesh, *, where: str) -> tuple[Mesh, tuple[Finding, ...]]:
    """Return ``mesh`` unchanged, or scaled from millimetres if its size implies them.

    Formats other than glTF and Collada do not state a unit. A body of more than 10 m is assumed to be in millimetres;
    one below 1 mm, or one far from the origin, is unchanged. Findings report each assumption and doubt.

    Args:
        mesh: Mesh in the unit of its file.
        where: Name of the file, for findings.
    """
    size = mesh.size
    scale = 1.0
    notes = list[Finding]()
    if size > LARGEST_IN_METRES:
        notes = [Finding("units", where, f"{size:.3g} across, assumed to be in millimetres")]
        scale = 1e-3
    elif size < SMALLEST_IN_METRES:
        notes = [Finding("units", where, f"only {size:.3g} m across: scale it if unintended")]
    away = float(np.linalg.norm(mesh.bounds.mean(axis=0))) if size > 0 else 0.0
    if away > _FAR * size:
        notes.append(Finding("far-away", where, f"{away / size:.3g} times its size from the origin: precision is lost"))
    return (Mesh(scale * mesh.vertices, mesh.faces) if scale != 1.0 else mesh), tuple(notes)


def to_msh(mesh: Mesh) -> bytes:
    """Return ``mesh`` in MuJoCo's binary format: float32 coordinates, vertices and faces in their order.

    MuJoCo requires at least four vertices, so that a single triangle repeats its last one.

    Layout: four counts (vertices, normals, texture coordinates, faces), then vertices and faces; from the chapter on
    mesh assets of MuJoCo's XML reference.
    """
    vertices = np.vstack([mesh.vertices, *[mesh.vertices[-1:]] * (4 - len(mesh.vertices))])
    counts = struct.pack("<4i", len(vertices), 0, 0, len(mesh.faces))
    return counts + vertices.astype("<f4").tobytes() + mesh.faces.astype("<i4").tobytes()


def box_mesh(size: float) -> Mesh:
    """Return a cube with edges of ``size`` [m] about the origin, the placeholder for a missing mesh."""
    return Mesh(size * (np.indices((2, 2, 2), dtype=np.float64).reshape(3, 8).T - 0.5), _BOX_FACES)


_BOX_FACES = np.array(
    [[1, 3, 0], [4, 1, 0], [0, 3, 2], [2, 4, 0], [1, 7, 3], [5, 1, 4],
     [5, 7, 1], [3, 7, 2], [6, 4, 2], [2, 7, 6], [6, 5, 4], [7, 5, 6]]
)  # fmt: skip
"""Faces in the order of existing recordings, because a placeholder is recognised by its bytes."""


@cache
def placeholder() -> bytes:
    """Return the mesh file that replaces a missing one; it is recognised by its bytes."""
    return to_msh(box_mesh(PLACEHOLDER_SIZE))


def _check_limits(vertices: FloatArray, faces: IntArray, path: Path) -> None:
    largest = float(np.abs(vertices).max(initial=0.0))
    if largest > MAX_COORDINATE:  # false for NaN, which Mesh rejects with its place
        remedy = "Export it again in metres or millimetres"
        raise MeshError("a coordinate is implausibly large", file=path, value=largest, remedy=remedy)
    if len(faces) > MAX_FACES:
        problem = "the mesh has more than 5 million triangles"
        raise MeshError(problem, file=path, value=len(faces), remedy="Simplify it first")


def _from_msh(data: bytes) -> tuple[FloatArray, IntArray]:
    vertices, normals, coordinates, faces = struct.unpack_from("<4i", data)
    if min(vertices, normals, coordinates, faces) < 0:
        raise ValueError("a count is negative")
    positions = np.frombuffer(data, "<f4", 3 * vertices, 16).reshape(-1, 3)
    indices = np.frombuffer(data, "<i4", 3 * faces, 16 + 4 * (3 * vertices + 3 * normals + 2 * coordinates))
    return positions.astype(np.float64), indices.reshape(-1, 3).astype(np.int64)


_PLAIN_READERS: Mapping[str, Callable[[bytes], tuple[FloatArray, IntArray] | None]] = {
    ".msh": _from_msh,
    ".obj": read_plain_obj,
    ".stl": read_binary_stl,
}
"""Fast readers by suffix, which return None for files that need trimesh."""
_REDUCERS: Mapping[str, Callable[[bytes, Path], bytes]] = {
    ".glb": reduced_glb,
    ".gltf": reduced_gltf,
    ".obj": reduced_obj,
    ".stl": reduced_stl,
}
"""Functions by suffix that limit a file and remove everything but its shape before trimesh reads it."""


def _by_trimesh(data: bytes, suffix: str, path: Path) -> tuple[FloatArray, IntArray]:
    import trimesh  # 0.1 s, not needed for cached scenes

    unit = 1.0
    if suffix == ".dae":
        shapes = _collada_shapes(data, path)
        if shapes is None:
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        unit, data = shapes
    with np.errstate(all="ignore"), warnings.catch_warnings():  # invalid numbers are rejected below
        warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)  # of NumPy before 2.3
        buffers = _gltf_buffers(data, path) if suffix == ".gltf" else None
        reduce = _REDUCERS.get(suffix)
        data = data if reduce is None else reduce(data, path)
        loaded = trimesh.load(io.BytesIO(data), file_type=suffix[1:], process=False, resolver=buffers)
        if isinstance(loaded, trimesh.Scene) and loaded.is_empty:
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        mesh = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
    faces = getattr(mesh, "faces", np.zeros((0, 3), dtype=np.int64))  # points alone have none
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError("a vertex is not three numbers")
    return unit * vertices, np.asarray(faces, dtype=np.int64)


def _gltf_buffers(data: bytes, path: Path) -> dict[str, bytes]:
    """Return the buffer files in the folder of a glTF file by name; other folders are not allowed."""
    named = [buffer.get("uri", "") for buffer in parse_json(data).get("buffers", [])]
    return {
        name: read_bytes(resolve_inside(path.parent / unquote(name), [path.parent], file=path, named=name))
        for name in named
        if name and not name.startswith("data:")
    }


def _collada_shapes(data: bytes, path: Path) -> tuple[float, bytes] | None:
    """Return metres per unit, and the document without materials; None if its scene shows no shape.

    A broken material would remove its triangles. The up-axis is ignored, as in other URDF tools.
    """
    root = parse_xml(data, file=path)
    unit = root.find("{*}asset/{*}unit")
    metres = float(unit.get("meter", "1")) if unit is not None else 1.0
    if not (np.isfinite(metres) and metres > 0):
        raise MeshError("the unit is not a length", file=path, place="unit", value=metres, remedy="Export it again")
    if root.find("{*}scene/{*}instance_visual_scene") is None:
        return None
    for parent in root.iter():
        parent[:] = [child for child in parent if child.tag.rpartition("}")[2] not in _COLLADA_MATERIALS]
    check_collada(root, path)
    return metres, tostring(root)


_COLLADA_MATERIALS = ("bind_material", "library_effects", "library_materials", "library_images")


def _weld(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Merge corners at exactly the same place; formats such as STL repeat them for each triangle."""
    rows = np.ascontiguousarray(vertices + 0.0)  # -0.0 and 0.0 are equal
    _, first, inverse = np.unique(_hashes(rows), return_index=True, return_inverse=True)
    if not np.array_equal(rows[first[inverse]], rows):  # two places with one hash
        keys = rows.view([("", rows.dtype)] * 3).ravel()
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keep the file's order of vertices
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return rows[first[order]], rank[inverse.ravel()][faces]


_ODD = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)


def _hashes(rows: FloatArray) -> NDArray[np.uint64]:
    """Return a hash (n,) of the bits of ``rows`` (n, 3), because sorting numbers is four times as fast as rows."""
    mixed = rows.view(np.uint64) * _ODD
    mixed ^= mixed >> np.uint64(31)
    return np.asarray((mixed * _ODD[::-1]).sum(axis=1, dtype=np.uint64))


PLACEHOLDER_SIZE = 0.02  # m


def split_scale(text: str) -> tuple[str, tuple[float, ...]]:
    """Return the size and the signs of a ``scale``, because MuJoCo before 4.0 turns mirrored meshes inside out.

    Example: ``"-1 2 2"`` is ``"1 2 2"`` mirrored by (-1, 1, 1). Text that is not three numbers is returned unchanged.
    """
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != 3 or min(values) >= 0 or not np.isfinite(values).all():
        return text, (1.0, 1.0, 1.0)
    return " ".join(repr(abs(value)) for value in values), tuple(float(np.copysign(1.0, value)) for value in values)


def _mirrored(mesh: Mesh, signs: tuple[float, ...]) -> Mesh:
    if all(sign > 0 for sign in signs):
        return mesh
    faces = mesh.faces[:, ::-1] if np.prod(signs) < 0 else mesh.faces
    return Mesh(mesh.vertices * np.asarray(signs), faces)


@dataclass(frozen=True)
class MissingMesh:
    """File that does not contain a mesh.

    Attributes:
        path: Path of the file.
        reason: Why it contains no mesh.
        remedy: What the user can do; empty if the file has to be added.
    """

    path: Path
    reason: str
    remedy: str = ""


_LFS_POINTER = b"version https://git-lfs.github.com/"


def _hull(vertices: FloatArray) -> IntArray | None:
    """Return the outward faces (m, 3) of the convex hull of points; None if they span no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(vertices) if len(vertices) >= 4 else None
    except (QhullError, ValueError):  # flat, or not finite
        hull = None
    if hull is None:
        return None
    a, b, c = (vertices[hull.simplices[:, corner]] for corner in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    faces = np.asarray(hull.simplices, dtype=np.int64)
    faces[inward] = faces[inward, ::-1]
    return faces


class AssetStore:
    """Collects meshes while a robot is read. Mutable.

    Attributes:
        files: Mesh bytes by bare file name, all in MuJoCo's own format.
        findings: Problems noticed.
        missing: The names in ``files`` that hold a placeholder, and why.
    """

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.findings: list[Finding] = []
        self.missing: dict[str, MissingMesh] = {}
        self._names: dict[tuple[Path, str], str] = {}
        self._counts: dict[str, int] = {}
        self._loaded: set[Path] = set()
        self._faces = self._contained = self._repeated = 0

    def add(self, path: Path, *, variant: str = "", mirror: tuple[float, ...] = (1.0, 1.0, 1.0)) -> str:
        """Add a mesh file and return its bare name; a small box replaces a file without mesh.

        A file has no mesh if it does not exist, is empty, is a pointer of Git LFS, or has neither triangles nor points
        with a volume. For points without triangles the convex hull is used, as in MuJoCo (a Finding).

        Args:
            path: The file.
            variant: Distinguishes uses of one file that need different names, such as two scales.
            mirror: Signs of the file's axes; an odd number of negative ones reverses the triangles.

        Raises:
            MeshError: The file is damaged, or its format is not supported.
            RobotError: All meshes together have more than 5 million triangles.
        """
        key = (path, f"{variant} {mirror}")
        if key not in self._names:
            name = self._names[key] = self._free_name(path.stem)
            found = self._load(path)
            if isinstance(found, MissingMesh):
                self.missing[name] = found
                self.files[name] = placeholder()
            else:
                self.files[name] = to_msh(_mirrored(found, mirror))
                self._counts[name] = len(found.faces)
                if path in self._loaded:
                    self.repeat(name, path)
                else:
                    self._loaded.add(path)
                    self._contained += len(found.faces)
        return self._names[key]

    def repeat(self, name: str, path: Path) -> None:
        """Count one more mesh that the model makes of a file.

        Args:
            name: The mesh's bare name.
            path: The file, for the error.

        Raises:
            RobotError: These meshes have many more triangles than their files.
        """
        self._repeated += self._counts.get(name, 0)
        most = MAX_REPEATED_FACES + self._contained
        if self._repeated > most:
            remedy = f"The maximum is {most}: state each mesh once, so that its shapes share it, or simplify it"
            value = f"{counted(self._repeated, 'triangle')} more than the files contain"
            raise RobotError(
                "mesh files are used under too many names or scales", file=path, value=value, remedy=remedy
            )

    def _load(self, path: Path) -> Mesh | MissingMesh:
        if not os.path.exists(path):
            return MissingMesh(path, "there is no such file")
        check_format(path)
        data = read_bytes(path)
        if data.startswith(_LFS_POINTER):
            return MissingMesh(path, "a Git LFS pointer, not the mesh itself", "run `git lfs pull` in its repository")
        if not data.strip():
            return MissingMesh(path, "the file is empty", "export it again")
        cut = stl_truncation(data) if path.suffix.lower() == ".stl" else ""
        if cut:
            return MissingMesh(path, cut, "copy or export it again")
        vertices, faces, left_out = _triangles(data, path, where=str(path))
        self.findings += left_out
        if not len(faces):
            hull = _hull(vertices)
            if hull is None:
                return MissingMesh(path, "the mesh has no triangles", "export it again with its surface")
            faces = hull
            note = "no triangles: the convex hull of its points is used"
            self.findings.append(Finding("points-only", str(path), note))
        mesh = _checked_mesh(vertices, faces, path, weld=True)
        self._faces += len(mesh.faces)
        if self._faces > MAX_FACES:
            problem = "its meshes have more than 5 million triangles together"
            raise RobotError(problem, file=path, value=self._faces, remedy="Simplify them first")
        return mesh

    def _free_name(self, stem: str) -> str:
        names = chain([f"{stem}.msh"], (f"{stem}_{number}.msh" for number in count(2)))
        return next(name for name in names if name not in self.files)
