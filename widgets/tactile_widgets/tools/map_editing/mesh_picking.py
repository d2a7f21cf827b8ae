"""Vertices, edges and seams under the pointer in either view, without Qt.

Paths along edges are shortest paths (Dijkstra over the patch's edge lengths, which areas of interest increase). A seam
is split into runs between its branches. Picking finds the vertex, the seam or the vertices near the pointer.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.editing.document import MapDocument
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_widgets.views.interaction.polyline import points_near_segment
from tactile_widgets.views.interaction.view_tool import PointerHit


class EdgePaths:
    """Shortest paths along the edges of one surface, around areas of interest, as for drawn seams.

    Args:
        surface: Surface of the patch.
        importance: (n,) importance of the vertices; None for zero.

    Cost: one Dijkstra search per start, 5 ms for 10,000 vertices; further ends cost nothing.
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
        """Return the vertices (k,) from ``start`` to ``end``; only these two if they are not connected."""
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
        """Return the path (k,) through ``vertices`` in order."""
        pieces = [self.path(a, b)[1:] for a, b in pairwise(vertices)]
        return np.concatenate([vertices[:1], *pieces]).astype(np.int64)


def present_seams(document: MapDocument, number: int) -> IntArray:
    """Return the unique edges (s, 2) at which a patch is cut, as pairs of surface vertices."""
    edges = np.concatenate([document.charts[number].seams, document.patches[number].seams.drawn])
    return np.unique(np.sort(edges.reshape(-1, 2), axis=1), axis=0)


def seam_runs(edges: IntArray) -> list[IntArray]:
    """Join ``edges`` (s, 2) to lines of vertices (k,), each from one end or branch to the next; rings are closed."""
    neighbours: dict[int, set[int]] = {}
    for a, b in edges.tolist():
        neighbours.setdefault(a, set()).add(b)
        neighbours.setdefault(b, set()).add(a)
    stops = {vertex for vertex, others in neighbours.items() if len(others) != 2}
    found = []
    for start in [*stops, *neighbours]:  # rings have no stops: the remaining edges start anywhere
        while neighbours[start]:
            line = [start]
            while len(line) == 1 or (line[-1] not in stops and line[-1] != start):
                here = line[-1]
                there = min(neighbours[line[-1]])
                neighbours[here].discard(there)
                neighbours[there].discard(here)
                line.append(there)
            found.append(np.array(line))
    return found


def as_edges(line: IntArray) -> IntArray:
    """Return the edges (k - 1, 2) of a line of vertices (k,)."""
    return np.stack([line[:-1], line[1:]], axis=1)


class ChartEdges:
    """Chart edges of a surface's edges: one inside, two on a seam."""

    def __init__(self, chart: Chart) -> None:
        self._edges = chart.connectivity.edges
        self._count = int(chart.vertex_of.max(initial=0)) + 1
        self._keys = np.sort(chart.vertex_of[self._edges], axis=1) @ [self._count, 1]

    def of(self, edges: IntArray) -> IntArray:
        """Return the chart edges (k, 2), as point indices, of ``edges`` (s, 2), pairs of surface vertices."""
        keys = np.sort(np.asarray(edges).reshape(-1, 2), axis=1) @ [self._count, 1]
        return self._edges[np.isin(self._keys, keys)]


@weak_cache
def _chart_edges(chart: Chart) -> ChartEdges:
    return ChartEdges(chart)


def on_map(document: MapDocument, number: int, edges: IntArray) -> FloatArray:
    """Return the map segments (k, 2, 2) [m] of ``edges`` (s, 2), pairs of surface vertices of a patch."""
    return document.map.uv[number][_chart_edges(document.charts[number]).of(edges)]


def lines_on_map(document: MapDocument, number: int, edges: IntArray) -> list[FloatArray]:
    """Return the map segments of ``edges`` joined to lines, each (k, 2) [m]."""
    return [document.map.uv[number][line] for line in seam_runs(_chart_edges(document.charts[number]).of(edges))]


def vertex_on_map(document: MapDocument, number: int, vertex: int) -> FloatArray:
    """Return the map points (k, 2) [m] of a surface vertex: several on a seam."""
    return document.map.uv[number][document.charts[number].vertex_of == vertex]


def vertex_point(document: MapDocument, number: int, vertex: int) -> SurfacePoint:
    """Return a surface vertex of a patch as a skin location."""
    faces = document.skin.patches[number].surface.faces
    face, corner = np.argwhere(faces == vertex)[0].tolist()
    weights = [float(k == corner) for k in range(3)]
    return SurfacePoint(number, face, (weights[0], weights[1], weights[2]))


PICK_RADIUS_PX = 12.0
"""Picking distance from the skin border and from seams."""

Vertex = tuple[int, int]
"""Patch number and surface vertex."""


def vertex_at(document: MapDocument, place: PointerHit) -> Vertex | None:
    """Return the nearest corner of the face under the pointer; off the map's patches, the nearest border vertex."""
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
    """Return the patch and the vertices (k,), from branch to branch, of the seam in reach of the pointer."""
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
    """Return the distance from the pointer to the nearest of ``edges`` (s, 2), on the map or on the body [m]."""
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
    """Return the vertices, by patch, covered by a brush of ``radius`` [px] moved in a straight line.

    On the skin, it covers at least the vertex nearest to its centre.
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
    """Return the mask (n,) of vertices near the line that face the same side, excluding a thin patch's back."""
    assert place.at is not None
    surface = document.skin.patches[place.at.patch].surface
    here = document.skin.position(place.at)
    same = before.at is not None and before.point is None and before.at.patch == place.at.patch
    start = document.skin.position(before.at) if same and before.at is not None else here
    facing = surface.vertex_normals @ document.skin.normal(place.at) > 0
    return facing & points_near_segment(np.stack([start, here]), surface.vertices, reach)


def _visible_patches(document: MapDocument) -> list[int]:
    """Return the patches that the map view shows."""
    return [number for number, patch in enumerate(document.patches) if patch.visible]
