"""Vertices, edges and seams under the pointer in either view, without Qt.

Paths along edges are shortest paths (Dijkstra, over the patch's edge lengths, longer where the skin matters); a seam
falls into runs between its branches. Then what the pointer means: the vertex, the seam or the vertices near it.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_widgets.views.interaction.polyline import points_near_segment
from tactile_widgets.views.interaction.view_tool import PointerHit


class EdgePaths:
    """Shortest paths along the edges of one surface, around areas of interest; the same as drawn seams take.

    Args:
        surface: The patch's.
        importance: (n,) by vertex; None where nothing is.

    Cost: a Dijkstra a start, 5 ms for 10,000 vertices; every end of it is free.
    """

    def __init__(self, surface: Mesh, importance: FloatArray | None = None) -> None:
        edges = surface.edges
        count = len(surface.vertices)
        lengths = np.linalg.norm(np.diff(surface.vertices[edges], axis=1)[:, 0], axis=1)
        if importance is not None:
            lengths = lengths * (1 + importance[edges].mean(axis=1))
        self._graph = coo_matrix((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
        self._before: dict[int, IntArray] = {}

    def path(self, start: int, end: int) -> IntArray:
        """(k,) the vertices from ``start`` to ``end``; just the ends where there is no way."""
        if start not in self._before:
            self._before[start] = dijkstra(self._graph, directed=False, indices=start, return_predecessors=True)[1]
        before = self._before[start]
        walk = [end]
        while walk[-1] != start:
            if before[walk[-1]] < 0:
                return np.array([start, end])
            walk.append(int(before[walk[-1]]))
        return np.array(walk[::-1])

    def through(self, vertices: list[int]) -> IntArray:
        """(k,) the path through ``vertices``, one after the other."""
        pieces = [self.path(a, b)[1:] for a, b in pairwise(vertices)]
        return np.concatenate([vertices[:1], *pieces]).astype(np.int64)


def present_seams(document: MapDocument, number: int) -> IntArray:
    """(s, 2) edges at which a patch is cut, as pairs of its surface's vertices, each once."""
    edges = np.concatenate([document.charts[number].seams, document.patches[number].seams.drawn])
    return np.unique(np.sort(edges.reshape(-1, 2), axis=1), axis=0)


def seam_runs(edges: IntArray) -> list[IntArray]:
    """The lines that ``edges`` (s, 2) make, each (k,) vertices from one end or branch to the next; rings close."""
    beside: dict[int, set[int]] = {}
    for a, b in edges.tolist():
        beside.setdefault(a, set()).add(b)
        beside.setdefault(b, set()).add(a)
    stops = {vertex for vertex, others in beside.items() if len(others) != 2}
    found = []
    for start in [*stops, *beside]:  # rings have no stops; whatever is left begins anywhere
        while beside[start]:
            line = [start]
            while len(line) == 1 or (line[-1] not in stops and line[-1] != start):
                here = line[-1]
                there = min(beside[line[-1]])
                beside[here].discard(there)
                beside[there].discard(here)
                line.append(there)
            found.append(np.array(line))
    return found


def as_edges(line: IntArray) -> IntArray:
    """(k - 1, 2) the edges of a line of vertices (k,)."""
    return np.stack([line[:-1], line[1:]], axis=1)


class ChartEdges:
    """Where a surface's edges lie on its chart: once inside, twice on a seam."""

    def __init__(self, chart: Chart) -> None:
        self._edges = chart.connectivity.edges
        self._count = int(chart.vertex_of.max(initial=0)) + 1
        self._keys = np.sort(chart.vertex_of[self._edges], axis=1) @ [self._count, 1]

    def of(self, edges: IntArray) -> IntArray:
        """(k, 2) the chart's points at the ends of ``edges`` (s, 2), pairs of the surface's vertices."""
        wanted = np.sort(np.asarray(edges).reshape(-1, 2), axis=1) @ [self._count, 1]
        return self._edges[np.isin(self._keys, wanted)]


@lru_cache(maxsize=8)
def _chart_edges(chart: Chart) -> ChartEdges:
    return ChartEdges(chart)


def on_map(document: MapDocument, number: int, edges: IntArray) -> FloatArray:
    """(k, 2, 2) the map segments [m] of ``edges`` (s, 2), pairs of the vertices of a patch's surface."""
    return document.map.uv[number][_chart_edges(document.charts[number]).of(edges)]


def lines_on_map(document: MapDocument, number: int, edges: IntArray) -> list[FloatArray]:
    """Each (k, 2) [m]: the same segments, put together to lines."""
    return [document.map.uv[number][line] for line in seam_runs(_chart_edges(document.charts[number]).of(edges))]


def vertex_on_map(document: MapDocument, number: int, vertex: int) -> FloatArray:
    """(k, 2) the map points [m] of a vertex of a patch's surface: several on a seam."""
    return document.map.uv[number][document.charts[number].vertex_of == vertex]


def vertex_point(document: MapDocument, number: int, vertex: int) -> SurfacePoint:
    """A vertex of a patch's surface as a place of the skin."""
    faces = document.skin.patches[number].surface.faces
    face, corner = np.argwhere(faces == vertex)[0].tolist()
    weights = [float(k == corner) for k in range(3)]
    return SurfacePoint(number, face, (weights[0], weights[1], weights[2]))


PICK_RADIUS_PX = 12.0
"""Nearer than this is meant, beside the skin and beside a seam."""

Vertex = tuple[int, int]
"""Patch, and vertex of its surface."""


def vertex_at(document: MapDocument, place: PointerHit) -> Vertex | None:
    """The nearest corner of the face under the pointer; beside the map's patches the nearest of a border in reach."""
    if place.at is not None:
        number = place.at.patch
        corners = document.skin.patches[place.at.patch].surface.faces[place.at.face]
        if place.point is None:
            there = document.skin.patches[number].surface.vertices[corners]
            away = np.linalg.norm(there - document.skin.position(place.at), axis=1)
        else:
            there = document.map.uv[number][document.charts[number].faces[place.at.face]]
            away = np.linalg.norm(there - place.point, axis=1)
        return number, int(corners[away.argmin()])
    return None if place.point is None else _on_border(document, place.point, PICK_RADIUS_PX * place.pixel)


def _on_border(document: MapDocument, point: FloatArray, reach: float) -> Vertex | None:
    best = reach
    found = None
    for number in _visible_patches(document):
        chart = document.charts[number]
        away = np.linalg.norm(document.map.outlines[number] - point, axis=1)
        if away.min() <= best:
            best = float(away.min())
            found = (number, int(chart.vertex_of[chart.border[away.argmin()]]))
    return found


def seam_at(document: MapDocument, place: PointerHit) -> tuple[int, IntArray] | None:
    """The patch and the run (k,) of vertices, from branch to branch, of the seam in reach of the pointer."""
    best = PICK_RADIUS_PX * place.pixel
    found = None
    for number in (
        _visible_patches(document) if place.point is not None else [] if place.at is None else [place.at.patch]
    ):
        for run in seam_runs(present_seams(document, number)):
            away = _distance(document, number, as_edges(run), place)
            if away <= best:
                best = away
                found = (number, run)
    return found


def _distance(document: MapDocument, number: int, edges: IntArray, place: PointerHit) -> float:
    """From the pointer to the nearest of ``edges`` (s, 2), on the map or on the body [m]."""
    if place.point is not None:
        point = place.point
        segments = on_map(document, number, edges)
    else:
        assert place.at is not None
        point = document.skin.position(place.at)
        segments = document.skin.patches[number].surface.vertices[edges]
    start = segments[:, 0]
    along = segments[:, 1] - segments[:, 0]
    length = np.maximum(np.einsum("sk,sk->s", along, along), np.finfo(float).tiny)
    share = np.clip(np.einsum("sk,sk->s", point - start, along) / length, 0, 1)
    return float(np.linalg.norm(start + share[:, None] * along - point, axis=1).min(initial=np.inf))


def vertices_under_brush(
    document: MapDocument, before: PointerHit, place: PointerHit, radius: float
) -> dict[int, IntArray]:
    """By patch the vertices that a brush of ``radius`` [px] covered on its straight way from one place to the next.

    However small it is, on the skin it covers the vertex nearest to its middle.
    """
    reach = radius * place.pixel
    if place.point is not None:
        start = place.point if before.point is None else before.point
        covered = {
            k: np.unique(
                document.charts[k].vertex_of[
                    points_near_segment(np.stack([start, place.point]), document.map.uv[k], reach)
                ]
            )
            for k in _visible_patches(document)
        }
    elif place.at is not None:
        covered = {place.at.patch: np.flatnonzero(_brushed_on_body(document, before, place, reach))}
    else:
        covered = {}
    if place.at is not None:
        nearest = vertex_at(document, place)
        assert nearest is not None
        covered[nearest[0]] = np.union1d(covered.get(nearest[0], []), [nearest[1]]).astype(np.int64)
    return {number: vertices for number, vertices in covered.items() if len(vertices)}


def _brushed_on_body(document: MapDocument, before: PointerHit, place: PointerHit, reach: float) -> BoolArray:
    """(n,) vertices near the way that look the way the skin does there: a thin patch's far side is not painted."""
    assert place.at is not None
    surface = document.skin.patches[place.at.patch].surface
    here = document.skin.position(place.at)
    same = before.at is not None and before.point is None and before.at.patch == place.at.patch
    start = document.skin.position(before.at) if same and before.at is not None else here
    facing = surface.vertex_normals @ document.skin.normal(place.at) > 0
    return facing & points_near_segment(np.stack([start, here]), surface.vertices, reach)


def _visible_patches(document: MapDocument) -> list[int]:
    """Patches that the map view shows."""
    return [number for number, patch in enumerate(document.patches) if patch.visible]
