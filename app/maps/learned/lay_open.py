"""A cloud of points in space laid flat: a surface put through it, cut where it must be, and flattened.

This is what lets a learned map open a tube. Distances alone cannot: they say that both sides of a seam are neighbours,
and a plane has no room for that. A surface says where it is closed, and the geometric maps know how to cut it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray
from app.errors import Finding, MapError, MeshError, SkinError
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops, compact, face_components
from app.maps.flatten import flatten
from app.skin.triangulate import triangulate

_LARGEST_HOLE = 8
"""A hole with no more sides is an accident of the triangles, not an end of the body."""
_LEAST_COVERED = 0.8
_AROUND = 3


@dataclass(frozen=True, eq=False)
class Opened:
    """Points (m, 2) in the unit of the cloud, and what was noticed."""

    points: FloatArray
    findings: tuple[Finding, ...]


def lay_open(cloud: FloatArray) -> Opened:
    """Lay a cloud flat; a point on a seam takes one of its two places.

    Args:
        cloud: (m, 3) points on something like a surface.

    Raises:
        MapError: No surface goes through four fifths of the points, or it cannot be laid flat.

    Cost: 0.1 s for 250 points.
    """
    try:
        faces, on_surface = _surface(cloud)
        chart = flatten(Mesh(cloud[on_surface], faces), name="learned surface")
    except (MeshError, SkinError) as error:
        raise MapError(error.problem, place="learned surface", value=error.value) from error
    notes = [*chart.findings]
    if len(chart.seams):
        action = "closed in space; cut along a seam of its own"
        notes.append(Finding("opened", "learned surface", action, len(chart.seams)))
    points = np.zeros((len(cloud), 2))
    # Backwards, so that of two places the first is written last, and stays.
    points[on_surface[chart.vertex_of[::-1]]] = chart.plane[::-1]
    beside = np.setdiff1d(np.arange(len(cloud)), on_surface)
    if beside.size:
        points[beside] = _means_of_nearest(cloud[beside], cloud[on_surface], points[on_surface])
        action = "put between the nearest that are on it"
        notes.append(Finding("taxels-beside-surface", "learned surface", action, int(beside.size)))
    return Opened(points, tuple(notes))


def _surface(cloud: FloatArray) -> tuple[IntArray, IntArray]:
    """The largest piece of a surface through the cloud: faces (f, 3) into the points (k,) that are on it."""
    faces = triangulate(cloud, where="learned surface").mesh.faces
    piece = face_components(faces) if len(faces) else np.zeros(0, dtype=np.int64)
    largest = faces[piece == np.bincount(piece).argmax()] if len(faces) else faces
    own, kept = compact(largest)
    if len(kept) < _LEAST_COVERED * len(cloud):
        raise MapError("no surface goes through the learned points", value=f"{len(kept)} of {len(cloud)} are on one")
    return without_small_holes(own), kept


def without_small_holes(faces: IntArray) -> IntArray:
    """The faces with each hole of few sides closed by a fan, where one fits; the longest border is no hole.

    A cut goes to every hole, and each would tear neighbours apart for nothing.

    Args:
        faces: (m, 3) manifold and oriented.
    """
    edges = {tuple(side) for side in np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).tolist()}
    added: list[tuple[int, int, int]] = []
    for loop in boundary_loops(faces)[1:]:
        for start in range(len(loop) if len(loop) <= _LARGEST_HOLE else 0):
            first, *others = np.roll(loop, -start).tolist()
            spokes = {(min(first, other), max(first, other)) for other in others[1:-1]}
            if edges.isdisjoint(spokes):
                edges |= spokes
                added += [(first, b, a) for a, b in pairwise(others)]
                break
    return np.concatenate([faces, np.array(added, dtype=np.int64).reshape(-1, 3)])


def _means_of_nearest(asked: FloatArray, known: FloatArray, places: FloatArray) -> FloatArray:
    away, near = cKDTree(known).query(asked, _AROUND)
    weights = 1 / np.maximum(away, 1e-12)
    return np.einsum("kc,kcd->kd", weights / weights.sum(axis=1, keepdims=True), places[near])
