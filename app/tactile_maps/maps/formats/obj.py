"""A map as the texture coordinates of a mesh: export to unwrapping tools, and import as a map of the same skin.

Wavefront OBJ files with texture coordinates are read line by line. An imported map may be moved, scaled, mirrored, cut
elsewhere and in another order; only the triangles of the skin must be present. They are identified by the positions of
their corners on the body.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import Finding, MapError, MeshError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text, write_lines
from tactile_maps.flattening.bijectivity import crossings, signed_areas
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.plane import winding_numbers
from tactile_maps.maps.model.layout import MapLayout, Placement, pack_charts
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin

MAX_LINES = 5_000_000
_LARGEST = 1e6
_SQUARE = re.compile(r"# origin (\S+) (\S+) m, side (\S+) m")


@dataclass(frozen=True, eq=False)
class ObjUv(ArrayFields):
    """A surface with texture coordinates.

    Attributes:
        surface: Surface in the file's units and order.
        uv: (k, 2) texture coordinates.
        corners: (m, 3) into ``uv``, for each corner of each face.
        groups: Names of the file's groups or objects.
        group_of: (m,) the group of each face; -1 before the first.
        square: Origin (x, y) and side [m] of the texture square, where this program's remark says so.
        findings: Problems noticed.
    """

    surface: Mesh
    uv: FloatArray
    corners: IntArray
    groups: tuple[str, ...]
    group_of: IntArray
    square: tuple[float, float, float] | None
    findings: tuple[Finding, ...]


def read_obj(path: str | Path) -> ObjUv:
    """Read the surface and the texture coordinates of the OBJ file at ``path``.

    Faces with more than three corners are split into triangles, and counted.

    Raises:
        MapError: The file cannot be read, a line is invalid, or a face has no texture coordinates; names the line.

    Cost: about 5 µs a line.
    """
    path = Path(path)
    lines = read_bounded_text(path, error=MapError).splitlines()
    if len(lines) > MAX_LINES:
        raise MapError(f"the file has more than {MAX_LINES} lines", file=path, value=len(lines))
    gathered = _ObjParser(path)
    for number, line in enumerate(lines, start=1):
        gathered.take(line, number)
    return gathered.result()


class _ObjParser:
    """Parser state of an OBJ file."""

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
        """Parse one line of the file."""
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
        """Return the contents of the whole file."""
        if not self._faces:
            raise MapError("the file has no faces", file=self._path, remedy="Export the mesh with its faces")
        findings: list[Finding] = []
        add_finding(findings, "polygon", self._path.name, "split into triangles", self._polygons)
        surface = Mesh(np.array(self._vertices), np.array(self._faces))
        corners = np.array(self._corners)
        return ObjUv(
            surface,
            np.array(self._uv),
            corners,
            tuple(self._groups),
            np.array(self._group_of),
            self._square,
            tuple(findings),
        )

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
        """Return a corner's vertex and texture index, from zero; negative numbers count from the last."""
        parts = word.split("/")
        if len(parts) < 2 or not parts[1]:
            remedy = "Unwrap the mesh, and export it with UV coordinates"
            raise self._bad("a corner has no texture coordinate", line, word, remedy)
        try:
            vertex = int(parts[0])
            uv = int(parts[1])
        except ValueError as error:
            raise self._bad("a corner must be vertex/texture", line, word) from error
        vertex = vertex - 1 if vertex > 0 else len(self._vertices) + vertex
        uv = uv - 1 if uv > 0 else len(self._uv) + uv
        if not (0 <= vertex < len(self._vertices) and 0 <= uv < len(self._uv)):
            raise self._bad("a face refers to an element that is not defined before it", line, word)
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


OBJ_METHOD = "from OBJ"
_SAME_PLACE = 1e-4
"""Distance, as a share of the patch's size, below which corners are equal: tools write six digits."""
_SAME_UV = 1e-7
_SAME_SCALE = 0.01
_TRUE_SCALE = 1e-4


def write_map_obj(map_: TactileMap, path: str | Path) -> None:
    """Write the skin as OBJ with the map as texture coordinates, one group per patch, each in the frame of its link.

    The larger side of the map fills the texture square; a comment in the file gives the conversion to metres.

    Raises:
        MapError: The file cannot be written.
    """
    low = map_.bounds[0]
    side = float(np.ptp(map_.bounds, axis=0).max()) or 1.0
    lines = [
        "# tactile map: vt = (map point - origin) / side",
        f"# origin {low[0]:.9g} {low[1]:.9g} m, side {side:.9g} m",
    ]
    vertex = 1
    corner = 1
    for patch, chart, uv in zip(map_.skin.patches, map_.charts, map_.uv, strict=True):
        surface = patch.surface
        lines.append(f"g {group_name(patch.name)}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in surface.vertices.tolist()]
        lines += [f"vt {u:.9g} {v:.9g}" for u, v in ((uv - low) / side).tolist()]
        pairs = np.stack([surface.faces + vertex, chart.faces + corner], axis=2).reshape(-1, 6).tolist()
        lines += [f"f {a}/{d} {b}/{e} {c}/{f}" for a, d, b, e, c, f in pairs]
        vertex = vertex + len(surface.vertices)
        corner = corner + len(uv)
    write_lines(Path(path), lines, error=MapError)


def read_map_obj(path: str | Path, skin: Skin) -> TactileMap:
    """Read the map of ``skin`` from the texture coordinates of the OBJ file at ``path``.

    Each chart is scaled to its patch's true area. The patches keep their positions if they have one scale and do not
    overlap; otherwise they are packed again. Findings of the charts report both.

    Raises:
        MapError: The file cannot be read, lacks triangles of the skin, or a patch is not one flat, one-to-one piece.
    """
    path = Path(path)
    obj = read_obj(path)
    with errors_in_file(path):
        islands = [
            _island(patch.name, patch.surface, _corner_uv(obj, chosen, patch.surface, patch.name))
            for patch, chosen in zip(skin.patches, _faces_by_patch(obj, skin), strict=True)
        ]
        if not islands:
            raise MapError("the skin has no patches")
        return _arranged(skin, islands, obj)


def group_name(patch: str) -> str:
    """Return the name of a patch in an OBJ file, without blanks."""
    return "_".join(patch.split()) or "patch"


@dataclass(frozen=True, eq=False)
class _Island:
    """A patch as laid out in the file, face up; the chart has its true size."""

    chart: Chart
    corner: FloatArray  # (2,) of its box, which is the origin of the chart [file units]
    scale: float  # [m per unit of the file]
    mirrored: bool


def _faces_by_patch(obj: ObjUv, skin: Skin) -> list[IntArray]:
    """Return the candidate faces of the file for each patch: those of its group, or else by order."""
    names = [group_name(patch.name) for patch in skin.patches]
    known = {name: k for k, name in enumerate(obj.groups)}
    if len(set(names)) == len(names) and all(name in known for name in names):
        return [np.flatnonzero(obj.group_of == known[name]) for name in names]
    counts = [len(patch.surface.faces) for patch in skin.patches]
    if sum(counts) != len(obj.surface.faces):
        raise MapError(
            "the file does not have the skin's faces",
            value=f"{len(obj.surface.faces)} faces, the skin has {sum(counts)}",
            remedy="Export all patches, in triangles, with their names as groups",
        )
    ends = np.cumsum(counts)
    return [np.arange(end - count, end) for count, end in zip(counts, ends, strict=True)]


def _corner_uv(obj: ObjUv, chosen: IntArray, surface: Mesh, name: str) -> FloatArray:
    """Return texture coordinates (m, 3, 2) of the corners of ``surface``, found among the file's faces ``chosen``."""
    tolerance = _SAME_PLACE * surface.size
    body = obj.surface.vertices[obj.surface.faces[chosen]]
    uv = obj.uv[obj.corners[chosen]]
    own = surface.vertices[surface.faces]
    if body.shape == own.shape and (np.linalg.norm(body - own, axis=2) <= tolerance).all():
        return uv
    away, vertex = cKDTree(surface.vertices).query(body.reshape(-1, 3))
    vertex = np.where(away <= tolerance, vertex, -1).reshape(-1, 3)
    place = _find_rows(np.sort(vertex, axis=1), np.sort(surface.faces, axis=1))
    if (place < 0).any():
        raise MapError(
            "the file does not have the skin's faces",
            place=f"patch {name}",
            value=f"{int((place < 0).sum())} of {len(place)} are missing",
            remedy="Export the mesh in triangles, in metres, without moving its vertices",
        )
    corner = (vertex[place][:, None, :] == surface.faces[:, :, None]).argmax(axis=2)
    return np.take_along_axis(uv[place], corner[:, :, None], axis=1)


def _find_rows(rows: IntArray, targets: IntArray) -> IntArray:
    """Return the index (w,) in ``rows`` of each row of ``targets``; -1 if it is missing."""
    _, number = np.unique(np.concatenate([rows, targets]), axis=0, return_inverse=True)
    number = number.ravel()
    place = np.full(number.max(initial=-1) + 1, -1)
    place[number[: len(rows)]] = np.arange(len(rows))
    return place[number[len(rows) :]]


def _island(name: str, surface: Mesh, corner_uv: FloatArray) -> _Island:
    """Validate and return the chart of a patch."""
    faces, points, vertex_of = _joined_corners(surface, corner_uv)
    areas = signed_areas(points, faces)
    mirrored = bool((areas < 0).all())
    if not (mirrored or (areas > 0).all()):
        bad = min(int((areas <= 0).sum()), int((areas >= 0).sum()))
        raise _unfit(name, "triangles are flipped", f"{bad} of {len(areas)}", "Unwrap the patch without folds")
    if mirrored:
        points = points * [-1.0, 1.0]
    flat = Connectivity(faces)
    _require_disk(name, flat, points)
    scale = float(np.sqrt(surface.area / np.abs(areas).sum()))
    findings = [Finding("mirrored-chart", name, "mirrored in the file, so mirrored on the map")] if mirrored else []
    corner = points.min(axis=0)
    seams = _seams(surface.connectivity, flat)
    chart = Chart(faces, (points - corner) * scale, vertex_of, seams, OBJ_METHOD, findings=tuple(findings))
    return _Island(chart, corner, scale, mirrored)


def _joined_corners(surface: Mesh, corner_uv: FloatArray) -> tuple[IntArray, FloatArray, IntArray]:
    """Return faces (m, 3), points (k, 2) and vertices (k,), merging corners at one vertex and one map point."""
    uv = corner_uv.reshape(-1, 2)
    vertex = surface.faces.reshape(-1, 1)
    step = _SAME_UV * max(float(np.ptp(uv, axis=0).max()), 1e-300)
    keys = np.concatenate([vertex, np.rint((uv - uv.min(axis=0)) / step).astype(np.int64)], axis=1)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return number.reshape(-1, 3), uv[first], vertex[first, 0]


def _require_disk(name: str, flat: Connectivity, points: FloatArray) -> None:
    pieces = int(flat.components.max()) + 1
    if pieces > 1:
        raise _unfit(name, "the patch is in several pieces", pieces, "Join its islands in the unwrapping tool")
    try:
        loops = flat.boundary_loops
    except MeshError as error:
        raise _unfit(name, "the patch is not unwrapped in one piece", error.problem, "Unwrap it again") from error
    if len(loops) != 1:
        raise _unfit(name, "the patch is not cut open", f"{len(loops)} borders", "Mark a seam that opens it")
    overlaps = crossings(points[loops[0]])
    if overlaps:
        raise _unfit(name, "the patch overlaps itself", f"{overlaps} crossings of its border", "Unwrap it again")


def _unfit(name: str, problem: str, value: object, remedy: str) -> MapError:
    return MapError(problem, place=f"patch {name}", value=value, remedy=remedy)


def _seams(body: Connectivity, flat: Connectivity) -> IntArray:
    """Return the edges (s, 2) of the surface with two faces that are two edges on the map."""
    border = flat.face_count[flat.edge_of] == 1
    return body.edges[np.unique(body.edge_of[border & (body.face_count[body.edge_of] == 2)])]


def _arranged(skin: Skin, islands: Sequence[_Island], obj: ObjUv) -> TactileMap:
    """Return the map, with the patches where the file has them if possible."""
    scales = np.array([island.scale for island in islands])
    common = float(np.median(scales))
    origin = np.zeros(2)
    findings = list(obj.findings)
    if obj.square is not None and abs(obj.square[2] / common - 1) < _TRUE_SCALE:
        common = obj.square[2]
        origin = np.array(obj.square[:2])
    else:
        findings.append(
            Finding("scaled", OBJ_METHOD, f"one unit of the file is {common:.6g} m, by the skin's true area")
        )
    charts = tuple(island.chart for island in islands)
    layout = MapLayout(tuple(_placement(island, common, origin) for island in islands))
    if (np.abs(scales / common - 1) > _SAME_SCALE).any() or not _apart(TactileMap(skin, charts, layout).outlines):
        layout = pack_charts(charts)
        findings.append(Finding("rearranged", OBJ_METHOD, "the patches had different scales or overlapped"))
    first = charts[0]
    reported = Chart(
        first.faces, first.plane, first.vertex_of, first.seams, OBJ_METHOD, findings=(*first.findings, *findings)
    )
    return TactileMap(skin, (reported, *charts[1:]), layout)


def _placement(island: _Island, scale: float, origin: FloatArray) -> Placement:
    flip = np.array([-1.0 if island.mirrored else 1.0, 1.0])
    x, y = island.corner * flip * scale + origin
    return Placement(offset=(float(x), float(y)), mirrored=island.mirrored)


def _apart(outlines: Sequence[FloatArray]) -> bool:
    """Return whether no two outlines cross or contain each other."""
    if crossings(*outlines):
        return False
    starts = np.array([outline[0] for outline in outlines])
    return all(not np.delete(winding_numbers(outline, starts), k).any() for k, outline in enumerate(outlines))
