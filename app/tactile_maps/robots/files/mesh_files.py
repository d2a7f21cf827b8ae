"""Mesh files in and out: whatever the format, what leaves here is a checked Mesh or a named error.

``AssetStore`` gathers the mesh files a robot names under bare names, in a form MuJoCo can be trusted with.
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
from json import JSONDecodeError
from pathlib import Path
from urllib.parse import unquote
from xml.etree.ElementTree import tostring

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import Finding, MeshError, RobotError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_limits import check_collada, reduced_glb, reduced_gltf, reduced_obj, reduced_stl
from tactile_maps.robots.files.plain_meshes import read_binary_stl, read_plain_obj
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
"""Formats of meshes that are not read, and what to do with them."""
MAX_FACES = 5_000_000
MAX_REPEATED_FACES = 400_000
"""Triangles that a robot may make of mesh files beyond twice those that the files contain. MuJoCo takes 1.5 kB each."""
MAX_COORDINATE = 1e7
# m, of the bounding box's diagonal
LARGEST_IN_METRES = 10.0
SMALLEST_IN_METRES = 1e-3
_FAR = 1e3  # sizes from the origin
logging.getLogger("trimesh").addHandler(logging.NullHandler())  # its tracebacks are not for users; our errors are


def _parser_errors() -> tuple[type[Exception], ...]:
    """What third-party parsers raise on files that are not what they claim to be; asked for only when one has."""
    from collada.common import DaeError  # 70 ms: it brings a library of pictures along

    return (ValueError, TypeError, KeyError, IndexError, AttributeError, NameError, AssertionError,
            NotImplementedError, MemoryError, OverflowError, RecursionError, EOFError, struct.error,
            DaeError, DeprecationWarning)  # fmt: skip


def read_mesh(path: Path) -> Mesh:
    """The triangles of a mesh file in the file's own units, as one mesh; corners at the same place become one vertex.

    Raises:
        RobotError: The file is missing, a folder or larger than 64 MB.
        MeshError: It cannot be read, is empty, or holds numbers that are not finite.
    """
    return parse_mesh(read_bytes(path), path)


def parse_mesh(data: bytes, path: Path, *, weld: bool = True) -> Mesh:
    """Like ``read_mesh``, from bytes.

    Args:
        data: The file's.
        path: Tells the format by its suffix, and the name for errors.
        weld: Whether corners at the same place become one vertex. In files that ``AssetStore`` wrote they are.
    """
    check_format(path)
    if data.startswith(_LFS_POINTER):
        raise MeshError("the file is a Git LFS pointer, not the mesh itself", file=path,
                        remedy="Run `git lfs pull` in its repository")  # fmt: skip
    vertices, faces = _triangles(data, path)
    if not len(faces):
        raise MeshError("the mesh has no triangles", file=path, remedy="Export it again with its surface")
    return _checked_mesh(vertices, faces, path, weld=weld)


def _checked_mesh(vertices: FloatArray, faces: IntArray, path: Path, *, weld: bool) -> Mesh:
    _check_limits(vertices, faces, path)
    try:
        mesh = Mesh(vertices, faces)
        return Mesh(*_weld(vertices, mesh.faces)) if weld else mesh
    except MeshError as error:
        raise error.at(file=path) from error


def _triangles(data: bytes, path: Path) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) and faces (m, 3) as the file states them; a file of points has no faces."""
    suffix = path.suffix.lower()
    try:
        plain = _PLAIN_READERS[suffix](data) if suffix in _PLAIN_READERS else None
        return plain or _by_trimesh(data, suffix, path)
    except _parser_errors() as error:
        line = f"line {error.lineno}" if isinstance(error, JSONDecodeError) else None
        form = suffix[1:].upper()
        problem = f"the mesh cannot be read: it is damaged, has no triangles, or is not in {form} format"
        remedy = "Export it again with its triangles, for example as STL"
        raise MeshError(problem, file=path, place=line, remedy=remedy) from error


def check_format(path: Path) -> None:
    """Refuse a file whose name says that it is no mesh we read, before it is opened.

    Raises:
        MeshError: Saying what to export instead, where the format is known.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        known = FOREIGN_FORMATS.get(suffix)
        raise MeshError(
            "the mesh format is not supported",
            file=path,
            value=path.suffix or "no file extension",
            remedy=known or f"Convert it to one of: {', '.join(MESH_SUFFIXES)}",
        )


def to_metres(mesh: Mesh, *, where: str) -> tuple[Mesh, tuple[Finding, ...]]:
    """``mesh`` as it is, or a thousandth of it where its size says that the file was in millimetres.

    Formats other than glTF and Collada do not state a unit. A body more than 10 m across is taken for millimetres; one
    below 1 mm, or one far from the origin, is left as it is. Each guess and doubt is a Finding.

    Args:
        mesh: In the file's own unit.
        where: The file's name, for findings.
    """
    size = mesh.size
    scale = 1.0
    notes = list[Finding]()
    if size > LARGEST_IN_METRES:
        notes = [Finding("units", where, f"{size:.3g} across, so taken for millimetres")]
        scale = 1e-3
    elif size < SMALLEST_IN_METRES:
        notes = [Finding("units", where, f"only {size:.3g} m across: scale it if unintended")]
    away = float(np.linalg.norm(mesh.bounds.mean(axis=0))) if size > 0 else 0.0
    if away > _FAR * size:
        notes.append(Finding("far-away", where, f"{away / size:.3g} times its size from the origin: precision is lost"))
    return (Mesh(scale * mesh.vertices, mesh.faces) if scale != 1.0 else mesh), tuple(notes)


def to_msh(mesh: Mesh) -> bytes:
    """``mesh`` in MuJoCo's binary format: float32 coordinates, vertices and faces in their order.

    MuJoCo wants four vertices at least, so a single triangle repeats its last.

    Layout: four counts (vertices, normals, texture coordinates, faces), then vertices and faces; from the chapter on
    mesh assets of MuJoCo's XML reference.
    """
    vertices = np.vstack([mesh.vertices, *[mesh.vertices[-1:]] * (4 - len(mesh.vertices))])
    counts = struct.pack("<4i", len(vertices), 0, 0, len(mesh.faces))
    return counts + vertices.astype("<f4").tobytes() + mesh.faces.astype("<i4").tobytes()


def box_mesh(size: float) -> Mesh:
    """A cube with edges of ``size`` [m] about the origin: the placeholder for a mesh that is missing."""
    return Mesh(size * (np.indices((2, 2, 2), dtype=np.float64).reshape(3, 8).T - 0.5), _BOX_FACES)


_BOX_FACES = np.array(
    [[1, 3, 0], [4, 1, 0], [0, 3, 2], [2, 4, 0], [1, 7, 3], [5, 1, 4],
     [5, 7, 1], [3, 7, 2], [6, 4, 2], [2, 7, 6], [6, 5, 4], [7, 5, 6]]
)  # fmt: skip
"""In the order that recordings of before have: a placeholder is known by its bytes."""


@cache
def placeholder() -> bytes:
    """The mesh file that stands for one that is missing: whoever meets its bytes knows."""
    return to_msh(box_mesh(PLACEHOLDER_SIZE))


def _check_limits(vertices: FloatArray, faces: IntArray, path: Path) -> None:
    largest = float(np.abs(vertices).max(initial=0.0))
    if largest > MAX_COORDINATE:  # not so for NaN, which Mesh refuses with its place
        raise MeshError(
            "a coordinate is implausibly large",
            file=path,
            value=largest,
            remedy="Export it again in metres or millimetres",
        )
    if len(faces) > MAX_FACES:
        raise MeshError(
            "the mesh has more than 5 million triangles", file=path, value=len(faces), remedy="Simplify it first"
        )


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
"""By suffix, what reads a file without trimesh, or gives None where it takes trimesh."""


_REDUCERS: Mapping[str, Callable[[bytes, Path], bytes]] = {
    ".glb": reduced_glb,
    ".gltf": reduced_gltf,
    ".obj": reduced_obj,
    ".stl": reduced_stl,
}
"""By suffix, what bounds a file and leaves out everything but its shape before trimesh reads it."""


def _by_trimesh(data: bytes, suffix: str, path: Path) -> tuple[FloatArray, IntArray]:
    import trimesh  # 0.1 s, and what is kept on disk needs none

    unit = 1.0
    if suffix == ".dae":
        shapes = _collada_shapes(data, path)
        if shapes is None:
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        unit, data = shapes
    with np.errstate(all="ignore"), warnings.catch_warnings():  # absurd numbers are refused below, with the file's name
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
    """The files beside a glTF file that hold its numbers, by the names it calls them; it may not reach further."""
    named = [buffer.get("uri", "") for buffer in parse_json(data).get("buffers", [])]
    return {
        name: read_bytes(resolve_inside(path.parent / unquote(name), [path.parent], file=path, named=name))
        for name in named
        if name and not name.startswith("data:")
    }


def _collada_shapes(data: bytes, path: Path) -> tuple[float, bytes] | None:
    """Metres per unit, and the document without its materials: a broken one would take its triangles along.

    None where its scene shows no shape.

    The up-axis is left alone because URDF tools leave it alone.
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
    """Let corners at exactly the same place share a vertex; formats such as STL repeat them for each triangle."""
    rows = np.ascontiguousarray(vertices + 0.0)  # -0.0 and 0.0 are one place
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
    """(n,) of the bits of ``rows`` (n, 3): numbers are sorted four times as fast as rows."""
    mixed = rows.view(np.uint64) * _ODD
    mixed ^= mixed >> np.uint64(31)
    return np.asarray((mixed * _ODD[::-1]).sum(axis=1, dtype=np.uint64))


PLACEHOLDER_SIZE = 0.02  # m


def split_scale(text: str) -> tuple[str, tuple[float, ...]]:
    """A ``scale`` as its size and its signs: MuJoCo before 4.0 leaves a mesh of negative scale inside out.

    Example: ``"-1 2 2"`` is ``"1 2 2"`` mirrored by (-1, 1, 1). What is not three numbers is returned as it is.
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
    """A mesh file that holds no mesh.

    Attributes:
        path: Where the mesh should be.
        reason: Why there is none.
        remedy: What the user can do; empty where that is to put the file there.
    """

    path: Path
    reason: str
    remedy: str = ""


_LFS_POINTER = b"version https://git-lfs.github.com/"


def _hull(vertices: FloatArray) -> IntArray | None:
    """(m, 3) faces of the convex hull of points, outside first; None where they span no volume."""
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
        findings: What was noticed.
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
        """Take in a mesh file and return its bare name; a small box is the placeholder of a file that holds no mesh.

        A file holds no mesh where it does not exist, is empty, is a pointer of Git LFS, or has neither triangles nor
        points with a volume. Of points alone the convex hull is used, as MuJoCo does (a Finding).

        Args:
            path: The file.
            variant: Uses of one file that must keep different names, such as two scales.
            mirror: Signs by which the file's axes are multiplied; an odd number of them turns the triangles round.

        Raises:
            MeshError: The file is damaged, or of a format that is not read.
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
            raise RobotError(
                "mesh files are used under too many names or scales",
                file=path,
                value=f"{self._repeated} triangles more than the files contain",
                remedy=f"The most is {most}: state each mesh once, so that its shapes share it, or simplify it",
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
        vertices, faces = _triangles(data, path)
        if not len(faces):
            hull = _hull(vertices)
            if hull is None:
                return MissingMesh(path, "the mesh has no triangles", "export it again with its surface")
            faces = hull
            self.findings.append(
                Finding("points-only", str(path), "no triangles: the convex hull of its points is used")
            )
        mesh = _checked_mesh(vertices, faces, path, weld=True)
        self._faces += len(mesh.faces)
        if self._faces > MAX_FACES:
            raise RobotError(
                "its meshes have more than 5 million triangles together",
                file=path,
                value=self._faces,
                remedy="Simplify them first",
            )
        return mesh

    def _free_name(self, stem: str) -> str:
        name = f"{stem}.msh"
        count = 1
        while name in self.files:
            count += 1
            name = f"{stem}_{count}.msh"
        return name
