"""Wavefront OBJ files with texture coordinates, read line by line; what they mean as a map is said in ``obj_uv``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding, MapError
from app.geometry.mesh import Mesh
from app.skin.exchange.foreign_file import note, read_text

MAX_LINES = 5_000_000
_LARGEST = 1e6
_SQUARE = re.compile(r"# origin (\S+) (\S+) m, side (\S+) m")


@dataclass(frozen=True, eq=False)
class ObjUv:
    """A surface with texture coordinates.

    Attributes:
        surface: In the file's own units and order.
        uv: (k, 2) texture coordinates.
        corners: (m, 3) into ``uv``, for each corner of each face.
        groups: Names of the file's groups or objects.
        group_of: (m,) the group of each face; -1 before the first.
        square: Origin (x, y) and side [m] of the texture square, where this program's remark says so.
        findings: What was noticed.
    """

    surface: Mesh
    uv: FloatArray
    corners: IntArray
    groups: tuple[str, ...]
    group_of: IntArray
    square: tuple[float, float, float] | None
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "uv", readonly(self.uv))
        for name in ("corners", "group_of"):
            object.__setattr__(self, name, readonly(getattr(self, name), np.int64))


def read_obj(path: str | Path) -> ObjUv:
    """The surface and the texture coordinates in the OBJ file at ``path``.

    Faces with more than three corners are split into triangles, and counted.

    Raises:
        MapError: It cannot be read, a line is broken, or a face has no texture coordinates; names the line.

    Cost: about 5 µs a line.
    """
    path = Path(path)
    lines = read_text(path, error=MapError).splitlines()
    if len(lines) > MAX_LINES:
        raise MapError(f"the file has more than {MAX_LINES} lines", file=path, value=len(lines))
    gathered = _Gathered(path)
    for number, line in enumerate(lines, start=1):
        gathered.take(line, number)
    return gathered.result()


class _Gathered:
    """What has been read so far."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._vertices: list[list[float]] = []
        self._uv: list[list[float]] = []
        self._faces: list[list[int]] = []
        self._corners: list[list[int]] = []
        self._groups: dict[str, int] = {}
        self._group_of: list[int] = []
        self._group = -1
        self._square: tuple[float, float, float] | None = None
        self._polygons = 0

    def take(self, line: str, number: int) -> None:
        """One line of the file."""
        words = line.split()
        kind = words[0] if words else ""
        if kind == "v":
            self._vertices.append(self._floats(words[1:], 3, number))
        elif kind == "vt":
            self._uv.append(self._floats(words[1:], 2, number))
        elif kind == "f":
            self._face(words[1:], number)
        elif kind in ("g", "o"):
            self._group = self._groups.setdefault(" ".join(words[1:]), len(self._groups))
        elif kind == "#" and (square := _SQUARE.fullmatch(line.strip())):
            x, y, side = self._floats(square.groups(), 3, number)
            self._square = (x, y, side) if side > 0 else None

    def result(self) -> ObjUv:
        """The whole file."""
        if not self._faces:
            raise MapError("the file has no faces", file=self._path, remedy="Export the mesh with its faces")
        findings: list[Finding] = []
        note(findings, "polygon", self._path.name, "split into triangles", self._polygons)
        surface = Mesh(np.array(self._vertices), np.array(self._faces))
        corners = np.array(self._corners)
        return ObjUv(
            surface, np.array(self._uv), corners, tuple(self._groups), np.array(self._group_of), self._square,
            tuple(findings),
        )  # fmt: skip

    def _face(self, words: Sequence[str], line: int) -> None:
        if not 3 <= len(words) <= 1000:
            raise self._bad("a face must have three corners or more", line, len(words))
        corners = [self._corner(word, line) for word in words]
        self._polygons += len(corners) > 3
        for k in range(1, len(corners) - 1):
            fan = (corners[0], corners[k], corners[k + 1])
            self._faces.append([vertex for vertex, _ in fan])
            self._corners.append([uv for _, uv in fan])
            self._group_of.append(self._group)

    def _corner(self, word: str, line: int) -> tuple[int, int]:
        """Numbers, from zero, of a corner's vertex and texture coordinate; negative ones count from the last."""
        parts = word.split("/")
        if len(parts) < 2 or not parts[1]:
            remedy = "Unwrap the mesh, and export it with UV coordinates"
            raise self._bad("a corner has no texture coordinate", line, word, remedy)
        try:
            vertex, uv = int(parts[0]), int(parts[1])
        except ValueError as error:
            raise self._bad("a corner must be vertex/texture", line, word) from error
        vertex = vertex - 1 if vertex > 0 else len(self._vertices) + vertex
        uv = uv - 1 if uv > 0 else len(self._uv) + uv
        if not (0 <= vertex < len(self._vertices) and 0 <= uv < len(self._uv)):
            raise self._bad("a corner names something that does not come before it", line, word)
        return vertex, uv

    def _floats(self, words: Sequence[str], count: int, line: int) -> list[float]:
        try:
            values = [float(word) for word in words[:count]]
        except ValueError as error:
            raise self._bad("not a number", line, " ".join(words)) from error
        if len(values) < count or not all(abs(value) < _LARGEST for value in values):
            raise self._bad(f"{count} finite numbers below {_LARGEST:g} expected", line, " ".join(words))
        return values

    def _bad(self, problem: str, line: int, value: object, remedy: str = "Export the file again") -> MapError:
        return MapError(problem, file=self._path, place=f"line {line}", value=value, remedy=remedy)
