"""Isomap: vertices placed in the plane by their distances over the body (Tenenbaum, de Silva and Langford 2000).

Nothing is learned from touch here; the method is that of the learned maps with true distances put in. It comes in two
kinds, to show what the usual one loses. A path along a mesh's edges zigzags: on equilateral triangles it is longer than
the straight way by 3 / pi (sqrt(3) / 2 + 1 / (2 sqrt(3))) = 1.103 in the mean over all directions and 1.155 at worst.
So a map made of such paths shows everything about a tenth too long, and not evenly, for ways along the edges' own three
directions are true. Exact distances have no such bias.
"""

from __future__ import annotations

import time
from typing import Literal

import numpy as np

from app.core.arrays import FloatArray, IntArray
from app.core.errors import Finding, MapError
from app.core.progress import Progress, no_progress
from app.geometry.geodesics import Geodesics, all_path_lengths, edge_graph
from app.geometry.mesh import Mesh
from app.maps.learned.embedding import classical_mds, kruskal_stress
from app.maps.learned.learned_map import LearnedMap

Distances = Literal["edges", "exact"]


def isomap(
    surface: Mesh, *, vertices: IntArray | None = None, distances: Distances = "exact", progress: Progress = no_progress
) -> LearnedMap:
    """Lay vertices of a surface flat.

    Args:
        surface: Connected; not cut, so a tube or closed body is crushed, not opened.
        vertices: (k,) which; None for all.
        distances: ``edges`` along the mesh's edges, ``exact`` over its faces.
        progress: Told how far it is.

    Returns:
        Points (k, 2) [m], at the scale of the distances.

    Raises:
        MapError: Fewer than three vertices, or some between which no way leads.

    Cost: exact distances take 10 ms a vertex on 1000 faces, 200 ms on 8000; along edges a thousandth of that.
    """
    started = time.perf_counter()
    chosen = np.unique(surface.faces) if vertices is None else np.asarray(vertices, dtype=np.int64)
    if len(chosen) < 3:
        raise MapError("a map needs three vertices or more", value=len(chosen))
    findings: tuple[Finding, ...] = ()
    if distances == "edges":
        apart = all_path_lengths(edge_graph(surface.edges, surface.edge_lengths, len(surface.vertices)), chosen)
    else:
        geodesics = Geodesics(surface)
        apart = _over_faces(geodesics, chosen, progress)
        if not geodesics.exact:
            findings = (Finding("inexact-distance", "surface", "body distances taken along edges"),)
    if not np.isfinite(apart).all():
        raise MapError("some vertices are not connected", remedy="Map each connected piece by itself")
    points, placed = classical_mds(apart), np.ones(len(chosen), dtype=bool)
    seconds = time.perf_counter() - started
    return LearnedMap(points, placed, f"isomap-{distances}", seconds, kruskal_stress(points, apart), findings)


def _over_faces(geodesics: Geodesics, chosen: IntArray, progress: Progress) -> FloatArray:
    """(k, k) exact distances [m], the mean of both ways."""
    rows = []
    for number, vertex in enumerate(chosen):
        progress("Computing geodesic distances", number / len(chosen))
        rows.append(geodesics.from_vertex(int(vertex), chosen))
    apart = np.stack(rows)
    return 0.5 * (apart + apart.T)
