"""Edges of a patch, without Qt: shortest paths along them, runs between branches, and where they lie on the map."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from app.arrays import FloatArray, IntArray
from app.editing.document import MapDocument
from app.geometry.mesh import Mesh
from app.geometry.surface_point import SurfacePoint
from app.geometry.topology import edge_table
from app.maps.chart import Chart


class EdgePaths:
    """Shortest paths along the edges of one surface, around areas of interest; the same as drawn seams take.

    Args:
        surface: The patch's.
        importance: (n,) by vertex; None where nothing is.

    Cost: a Dijkstra a start, 5 ms for 10,000 vertices; every end of it is free.
    """

    def __init__(self, surface: Mesh, importance: FloatArray | None = None) -> None:
        edges, count = surface.edges, len(surface.vertices)
        lengths = np.linalg.norm(np.diff(surface.vertices[edges], axis=1)[:, 0], axis=1)
        if importance is not None:
            lengths = lengths * (1 + importance[edges].mean(axis=1))
        self._graph = coo_matrix((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
        self._before: dict[int, IntArray] = {}

    def path(self, start: int, end: int) -> IntArray:
        """(k,) the vertices from ``start`` to ``end``; just the ends where there is no way."""
        if start not in self._before:
            self._before[start] = dijkstra(self._graph, directed=False, indices=start, return_predecessors=True)[1]
        before, walk = self._before[start], [end]
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


def runs(edges: IntArray) -> list[IntArray]:
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
                here, there = line[-1], min(beside[line[-1]])
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
        self._edges = edge_table(chart.faces).edges
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
    return [document.map.uv[number][line] for line in runs(_chart_edges(document.charts[number]).of(edges))]


def vertex_on_map(document: MapDocument, number: int, vertex: int) -> FloatArray:
    """(k, 2) the map points [m] of a vertex of a patch's surface: several on a seam."""
    return document.map.uv[number][document.charts[number].vertex_of == vertex]


def vertex_point(document: MapDocument, number: int, vertex: int) -> SurfacePoint:
    """A vertex of a patch's surface as a place of the skin."""
    faces = document.skin.patches[number].surface.faces
    face, corner = np.argwhere(faces == vertex)[0].tolist()
    weights = [float(k == corner) for k in range(3)]
    return SurfacePoint(number, face, (weights[0], weights[1], weights[2]))
