"""Slow and plain answers to compare the fast ones with."""

from __future__ import annotations

import numpy as np

from app.geometry.mesh import Mesh


def distances(points: np.ndarray, mesh: Mesh) -> np.ndarray:
    """(k,) distance of each point to the mesh: inside a triangle's prism to its plane, else to its edges."""
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
    """Distance to the first face along a unit direction, from either side; inf for none (Möller & Trumbore 1997)."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    e1, e2 = b - a, c - a
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
