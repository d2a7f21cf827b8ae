"""A map as the texture coordinates of a mesh: out to any unwrapping tool, and back as a map of the same skin.

What comes back may be moved, scaled, mirrored, cut elsewhere and in another order: only the skin's triangles must be
there. They are found again by where their corners lie on the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import BoolArray, FloatArray, IntArray
from app.errors import Finding, MapError, MeshError
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops, edge_table, face_components
from app.maps.bijective import crossings, signed_areas
from app.maps.chart import Chart
from app.maps.exchange.obj_file import ObjUv, read_obj
from app.maps.layout import MapLayout, Placement
from app.maps.packing import pack
from app.maps.tactile_map import TactileMap
from app.skin.exchange.foreign_file import naming, write_lines
from app.skin.skin import Skin

METHOD = "from OBJ"
_SAME_PLACE = 1e-4
"""Corners this near, as a share of the patch's size, are one: tools write six digits."""
_SAME_UV = 1e-7
_SAME_SCALE = 0.01
_TRUE_SCALE = 1e-4


def write_obj(map_: TactileMap, path: str | Path) -> None:
    """Write the skin as OBJ with the map as texture coordinates, one group a patch, each in its link's frame.

    The texture square is filled by the map's larger side; a remark says how to get metres back.

    Raises:
        MapError: The file cannot be written.
    """
    low, side = map_.bounds[0], float(np.ptp(map_.bounds, axis=0).max()) or 1.0
    lines = [
        "# tactile map: vt = (map point - origin) / side",
        f"# origin {low[0]:.9g} {low[1]:.9g} m, side {side:.9g} m",
    ]
    vertex, corner = 1, 1
    for patch, chart, uv in zip(map_.skin.patches, map_.charts, map_.uv, strict=True):
        surface = patch.surface
        lines.append(f"g {group_name(patch.name)}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in surface.vertices.tolist()]
        lines += [f"vt {u:.9g} {v:.9g}" for u, v in ((uv - low) / side).tolist()]
        pairs = np.stack([surface.faces + vertex, chart.faces + corner], axis=2).reshape(-1, 6).tolist()
        lines += [f"f {a}/{d} {b}/{e} {c}/{f}" for a, d, b, e, c, f in pairs]
        vertex, corner = vertex + len(surface.vertices), corner + len(uv)
    write_lines(Path(path), lines, error=MapError)


def read_map_obj(path: str | Path, skin: Skin) -> TactileMap:
    """The map of ``skin`` that the texture coordinates in the OBJ file at ``path`` are.

    Each chart is scaled to its patch's true area. The patches keep their places where they have one scale and do not
    lie on each other; else they are arranged anew. Both are told as findings of the charts.

    Raises:
        MapError: It cannot be read, does not hold the skin's triangles, or is not one flat, one-to-one piece a patch.
    """
    path = Path(path)
    obj = read_obj(path)
    with naming(path):
        islands = [
            _island(patch.name, patch.surface, _corner_uv(obj, chosen, patch.surface, patch.name))
            for patch, chosen in zip(skin.patches, _faces_by_patch(obj, skin), strict=True)
        ]
        if not islands:
            raise MapError("the skin has no patches")
        return _arranged(skin, islands, obj)


def group_name(patch: str) -> str:
    """What a patch is called in an OBJ file, where names have no blanks."""
    return "_".join(patch.split()) or "patch"


@dataclass(frozen=True, eq=False)
class _Island:
    """One patch as the file lays it out, turned face up; the chart is already of true size."""

    chart: Chart
    corner: FloatArray  # (2,) of its box, which the chart has at the origin [file units]
    scale: float  # metres of the chart for one unit of the file
    mirrored: bool


def _faces_by_patch(obj: ObjUv, skin: Skin) -> list[IntArray]:
    """For each patch the file's faces to look among: those of its group, else those in its turn."""
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
    """(m, 3, 2) texture coordinates of the corners of ``surface``, found among the file's faces ``chosen``."""
    tolerance = _SAME_PLACE * surface.size
    body, uv = obj.surface.vertices[obj.surface.faces[chosen]], obj.uv[obj.corners[chosen]]
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
            remedy="Export the mesh in triangles, in metres, with its vertices where they were",
        )
    corner = (vertex[place][:, None, :] == surface.faces[:, :, None]).argmax(axis=2)
    return np.take_along_axis(uv[place], corner[:, :, None], axis=1)


def _find_rows(rows: IntArray, wanted: IntArray) -> IntArray:
    """(w,) where each row of ``wanted`` stands in ``rows``; -1 where it does not."""
    _, number = np.unique(np.concatenate([rows, wanted]), axis=0, return_inverse=True)
    number = number.ravel()
    place = np.full(number.max(initial=-1) + 1, -1)
    place[number[: len(rows)]] = np.arange(len(rows))
    return place[number[len(rows) :]]


def _island(name: str, surface: Mesh, corner_uv: FloatArray) -> _Island:
    """The patch's chart, once it is known to be one."""
    faces, points, vertex_of = _joined_corners(surface, corner_uv)
    areas = signed_areas(points, faces)
    mirrored = bool((areas < 0).all())
    if not (mirrored or (areas > 0).all()):
        bad = min(int((areas <= 0).sum()), int((areas >= 0).sum()))
        raise _unfit(name, "triangles are turned over", f"{bad} of {len(areas)}", "Unwrap the patch without folds")
    if mirrored:
        points = points * [-1.0, 1.0]
    _require_disk(name, faces, points)
    scale = float(np.sqrt(surface.area / np.abs(areas).sum()))
    findings = [Finding("mirrored-chart", name, "the file shows it mirrored; so does the map")] if mirrored else []
    corner = points.min(axis=0)
    seams = _seams(surface, faces)
    chart = Chart(faces, (points - corner) * scale, vertex_of, seams, METHOD, findings=tuple(findings))
    return _Island(chart, corner, scale, mirrored)


def _joined_corners(surface: Mesh, corner_uv: FloatArray) -> tuple[IntArray, FloatArray, IntArray]:
    """Faces (m, 3), points (k, 2) and vertices (k,): corners at one vertex and one place on the map are one point."""
    uv, vertex = corner_uv.reshape(-1, 2), surface.faces.reshape(-1, 1)
    step = _SAME_UV * max(float(np.ptp(uv, axis=0).max()), 1e-300)
    keys = np.concatenate([vertex, np.rint((uv - uv.min(axis=0)) / step).astype(np.int64)], axis=1)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return number.reshape(-1, 3), uv[first], vertex[first, 0]


def _require_disk(name: str, faces: IntArray, points: FloatArray) -> None:
    pieces = int(face_components(faces).max()) + 1
    if pieces > 1:
        raise _unfit(name, "the patch lies in several pieces", pieces, "Join its islands in the unwrapping tool")
    try:
        loops = boundary_loops(faces)
    except MeshError as error:
        raise _unfit(name, "the patch is not laid flat as one piece", error.problem, "Unwrap it again") from error
    if len(loops) != 1:
        raise _unfit(name, "the patch is not cut open", f"{len(loops)} borders", "Mark a seam that opens it")
    overlaps = crossings(points[loops[0]])
    if overlaps:
        raise _unfit(name, "the patch lies on itself", f"{overlaps} crossings of its border", "Unwrap it again")


def _unfit(name: str, problem: str, value: object, remedy: str) -> MapError:
    return MapError(problem, place=f"patch {name}", value=value, remedy=remedy)


def _seams(surface: Mesh, faces: IntArray) -> IntArray:
    """(s, 2) edges of the surface with a face on both sides that are two edges on the map."""
    body, flat = edge_table(surface.faces), edge_table(faces)
    border = flat.face_count[flat.edge_of] == 1
    return body.edges[np.unique(body.edge_of[border & (body.face_count[body.edge_of] == 2)])]


def _arranged(skin: Skin, islands: Sequence[_Island], obj: ObjUv) -> TactileMap:
    """The map, its patches where the file has them if they can stay there."""
    scales = np.array([island.scale for island in islands])
    common, origin = float(np.median(scales)), np.zeros(2)
    findings = list(obj.findings)
    if obj.square is not None and abs(obj.square[2] / common - 1) < _TRUE_SCALE:
        common, origin = obj.square[2], np.array(obj.square[:2])
    else:
        findings.append(Finding("scaled", METHOD, f"one unit of the file is {common:.6g} m, by the skin's true area"))
    charts = tuple(island.chart for island in islands)
    layout = MapLayout(tuple(_placement(island, common, origin) for island in islands))
    if (np.abs(scales / common - 1) > _SAME_SCALE).any() or not _apart(TactileMap(skin, charts, layout).outlines):
        layout = pack(charts)
        findings.append(Finding("rearranged", METHOD, "the patches had several scales, or lay on each other"))
    first = charts[0]
    told = Chart(first.faces, first.plane, first.vertex_of, first.seams, METHOD, findings=(*first.findings, *findings))
    return TactileMap(skin, (told, *charts[1:]), layout)


def _placement(island: _Island, scale: float, origin: FloatArray) -> Placement:
    flip = np.array([-1.0 if island.mirrored else 1.0, 1.0])
    x, y = island.corner * flip * scale + origin
    return Placement(offset=(float(x), float(y)), mirrored=island.mirrored)


def _apart(outlines: Sequence[FloatArray]) -> bool:
    """Whether no two outlines cross or lie within each other."""
    if crossings(*outlines):
        return False
    starts = np.array([outline[0] for outline in outlines])
    return all(not np.delete(_inside(outline, starts), k).any() for k, outline in enumerate(outlines))


def _inside(outline: FloatArray, points: FloatArray) -> BoolArray:
    """(k,) which points the outline runs around: an odd number of its sides lies to their right."""
    a, b = outline[None], np.roll(outline, -1, axis=0)[None]
    x, y = points[:, 0, None], points[:, 1, None]
    spans = (a[..., 1] > y) != (b[..., 1] > y)
    rise = np.where(spans, b[..., 1] - a[..., 1], 1.0)
    right = a[..., 0] + (y - a[..., 1]) / rise * (b[..., 0] - a[..., 0]) > x
    return np.asarray((spans & right).sum(axis=1) % 2 == 1)
