"""Slow reference implementations: closest points, rays, straight walks on a surface, and fields of taxels."""

from __future__ import annotations

import numpy as np

from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.cut import cut_to_disk
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.interpolation import TaxelTriangles
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tests.support.surfaces import skin_of


def distances(points: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Return the (k,) distance of each point to the mesh: to the plane inside a triangle's prism, else to its edges."""
    corners = mesh.vertices[mesh.faces]
    best = np.full(len(points), np.inf)
    for a, b, c in corners:
        for start, end in ((a, b), (b, c), (c, a)):
            along = end - start
            t = np.clip((points - start) @ along / max(along @ along, 1e-300), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - start - t[:, None] * along, axis=1))
        normal = np.cross(b - a, c - a)
        size = np.linalg.norm(normal)
        if size > 0:
            normal /= size
            height = (points - a) @ normal
            foot = points - height[:, None] * normal
            sides = [np.cross(e - s, foot - s) @ normal for s, e in ((a, b), (b, c), (c, a))]
            inside = (np.array(sides) >= 0).all(axis=0)
            best = np.where(inside, np.minimum(best, np.abs(height)), best)
    return best


def first_hit(origin: np.ndarray, direction: np.ndarray, mesh: Mesh) -> float:
    """Return the distance to the first face along a unit direction, from either side; inf if none.

    Source: Möller and Trumbore 1997.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    e1 = b - a
    e2 = c - a
    p = np.cross(direction, e2)
    det = (e1 * p).sum(axis=1)
    ok = np.abs(det) > 1e-14
    inverse = 1 / np.where(ok, det, 1.0)
    s = origin - a
    u = (s * p).sum(axis=1) * inverse
    q = np.cross(s, e1)
    v = (q @ direction) * inverse
    t = (e2 * q).sum(axis=1) * inverse
    hit = ok & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return float(t[hit].min()) if hit.any() else float("inf")


def walk(surface: Mesh, face: int, point, direction, length: float):
    """Walk straight on from ``point`` in ``face``; return the end point, its face, and the length left at a border.

    At each edge the direction keeps its angle to the edge, as if both triangles were in one plane.
    """
    neighbours = {(int(f[k]), int(f[(k + 1) % 3])): i for i, f in enumerate(surface.faces) for k in range(3)}
    point = np.asarray(point, float)
    direction = np.asarray(direction, float)
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
        point = point + reach * direction
        length = length - reach
        if (second, first) not in neighbours:
            return point, face, length
        after = neighbours[second, first]
        along = surface.vertices[second] - surface.vertices[first]
        along /= np.linalg.norm(along)
        out_here, out_there = (np.cross(along, surface.face_normals[f]) for f in (face, after))
        direction = (direction @ along) * along + (direction @ out_here) * out_there
        came_over = (second, first)
        face = after


def unrolled(surface: Mesh, *, taxels: int = 40, angle: float = 0.0, mirrored: bool = False) -> TactileMap:
    """Return the map of a developable surface, made by unfolding one triangle after another."""
    cut = cut_to_disk(surface)
    positions = surface.vertices[cut.vertex_of]
    plane = np.full((len(cut.vertex_of), 2), np.nan)
    neighbours = {(int(f[k]), int(f[(k + 1) % 3])): int(f[(k + 2) % 3]) for f in cut.faces for k in range(3)}
    a, b, _ = (int(v) for v in cut.faces[0])
    plane[a] = 0
    plane[b] = [np.linalg.norm(positions[b] - positions[a]), 0]
    open_ = [(a, b)]
    while open_:
        a, b = open_.pop()
        c = neighbours.get((a, b))
        if c is None or np.isfinite(plane[c]).all():
            continue
        edge = positions[b] - positions[a]
        arm = positions[c] - positions[a]
        size = np.linalg.norm(edge)
        along = arm @ edge / size
        across = np.linalg.norm(np.cross(edge, arm)) / size
        u = (plane[b] - plane[a]) / size
        plane[c] = plane[a] + along * u + across * np.array([-u[1], u[0]])
        open_ += [(c, b), (a, c)]
    chart = Chart(cut.faces, plane - plane.min(axis=0), cut.vertex_of, cut.seams, "by hand")
    return TactileMap(skin_of(surface, taxels=taxels), (chart,), MapLayout((Placement(angle, (0.3, 0.1), mirrored),)))


def jittered(side=9, *, seed=0, jitter=0.3) -> np.ndarray:
    """Return (side², 2) taxels about 10 mm apart, with no two rows aligned."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    places = np.stack([x, y], axis=-1).reshape(-1, 2) + 0.5
    return 0.01 * (places + np.random.default_rng(seed).uniform(-jitter, jitter, places.shape))


def horseshoe() -> np.ndarray:
    """Return (n, 2) taxels on two arms 40 mm apart and joined at one end, for interpolation across the gap."""
    x, y = np.meshgrid(np.arange(16), np.arange(10))
    places = np.stack([x, y], axis=-1).reshape(-1, 2)
    arms = places[(places[:, 0] < 3) | (places[:, 1] < 3) | (places[:, 1] > 6)]
    return 0.01 * (arms + np.random.default_rng(0).uniform(-0.2, 0.2, arms.shape))


def held(triangles: TaxelTriangles, *, count=3000, seed=1) -> np.ndarray:
    """Return (k, 2) random points inside triangles."""
    low = triangles.sites.min(axis=0)
    high = triangles.sites.max(axis=0)
    points = np.random.default_rng(seed).uniform(low, high, (count, 2))
    kept = points[triangles.locate(points)[0] >= 0]
    assert len(kept) > 0.3 * count
    return kept


def disc_stress(radius: np.ndarray, depth: float) -> np.ndarray:
    """Return the normal stress on the axis of a disc with unit pressure: 1 - (1 + (a/h)²)^(-3/2).

    Also the share of a point's force that passes within ``radius`` of the axis at that depth.

    Args:
        radius: Radius of the disc [m], any shape.
        depth: Depth below the surface [m], > 0.
    """
    return np.asarray(1 - (1 + np.square(np.asarray(radius) / depth)) ** -1.5)
