"""References for paths over seams: walking straight on over a surface's triangles, and maps without any stretch."""

from __future__ import annotations

import numpy as np

from app.geometry.mesh import Mesh
from app.maps.chart import Chart
from app.maps.cut import cut_to_disk
from app.maps.layout import MapLayout, Placement
from app.maps.tactile_map import TactileMap
from tests.numerics.map_surfaces import skin_of


def walk(surface: Mesh, face: int, point, direction, length: float):
    """Straight on from ``point`` in ``face``: (end point, its face, length left where the surface ended).

    From triangle to triangle: the direction keeps its angle to the edge that is crossed, as if both were one plane.
    """
    beside = {(int(f[k]), int(f[(k + 1) % 3])): i for i, f in enumerate(surface.faces) for k in range(3)}
    point, direction = np.asarray(point, float), np.asarray(direction, float)
    direction = direction - (direction @ surface.face_normals[face]) * surface.face_normals[face]
    direction /= np.linalg.norm(direction)
    came_over = None
    while True:
        best = None
        for k in range(3):
            edge = int(surface.faces[face, k]), int(surface.faces[face, (k + 1) % 3])
            if edge == came_over:
                continue
            a, b = surface.vertices[list(edge)]
            out = np.cross(b - a, surface.face_normals[face])
            speed = direction @ out
            if speed > 0 and (best is None or (a - point) @ out / speed < best[0]):
                best = ((a - point) @ out / speed, edge)
        reach, (first, second) = best
        if reach >= length:
            return point + length * direction, face, 0.0
        point, length = point + reach * direction, length - reach
        if (second, first) not in beside:
            return point, face, length
        after = beside[second, first]
        along = surface.vertices[second] - surface.vertices[first]
        along /= np.linalg.norm(along)
        out_here, out_there = (np.cross(along, surface.face_normals[f]) for f in (face, after))
        direction = (direction @ along) * along + (direction @ out_here) * out_there
        came_over, face = (second, first), after


def unrolled(surface: Mesh, *, taxels: int = 40, angle: float = 0.0, mirrored: bool = False) -> TactileMap:
    """The map of a surface that can be laid flat without stretch, by laying down one triangle after the other."""
    cut = cut_to_disk(surface)
    positions, plane = surface.vertices[cut.vertex_of], np.full((len(cut.vertex_of), 2), np.nan)
    beside = {(int(f[k]), int(f[(k + 1) % 3])): int(f[(k + 2) % 3]) for f in cut.faces for k in range(3)}
    a, b, _ = (int(v) for v in cut.faces[0])
    plane[a], plane[b] = 0, [np.linalg.norm(positions[b] - positions[a]), 0]
    open_ = [(a, b)]
    while open_:
        a, b = open_.pop()
        c = beside.get((a, b))
        if c is None or np.isfinite(plane[c]).all():
            continue
        edge, arm = positions[b] - positions[a], positions[c] - positions[a]
        size = np.linalg.norm(edge)
        along, across = arm @ edge / size, np.linalg.norm(np.cross(edge, arm)) / size
        u = (plane[b] - plane[a]) / size
        plane[c] = plane[a] + along * u + across * np.array([-u[1], u[0]])
        open_ += [(c, b), (a, c)]
    chart = Chart(cut.faces, plane - plane.min(axis=0), cut.vertex_of, cut.seams, "by hand")
    return TactileMap(skin_of(surface, taxels=taxels), (chart,), MapLayout((Placement(angle, (0.3, 0.1), mirrored),)))
