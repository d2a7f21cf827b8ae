"""Geodesic information map: taxels are embedded in three dimensions, like a body, and flattened from there.

McGregor, Polani and Dautenhahn's ANISOMAP (PLoS ONE 6(11), 2011) reconstructs a tactile surface in three dimensions
from information alone, by a scaling like Isomap's that tolerates sensor failure. Its exact steps are not known here, so
this is a similar method, not a copy: (1) information distance between taxels; (2) edges between near neighbours, each
distance relative to the local spacing of its two ends, so that a taxel with little information (touched less, at a
border, on a coarse part) is not pushed away; (3) paths; (4) scaling to three dimensions. The last step is new: (5) a
surface through the points, cut where necessary and flattened like that of a body.

Three dimensions are needed because bodies are closed: the plane has no room for a tube, whose two sides of a seam are
neighbours. In space the surface is a tube, which can be cut and unrolled like a geometric map. Of 250 taxels on a tube
the direct embedding in the plane keeps half of the neighbours, this method four fifths.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, MapError, MeshError, SkinError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.flattening.flatten import flatten
from tactile_maps.geometry.surface.connectivity import Connectivity, remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.learned.embedding import NEIGHBOURS, classical_mds, embed, embed_in_plane, smacof
from tactile_maps.maps.learned.information_distance import dissimilarity
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.learned.readings import detect_touch
from tactile_maps.skin.reconstruction.triangulation import triangulate

_LARGEST_HOLE = 8
"""Number of sides up to which a hole is an artefact of the triangulation, not an end of the body."""
_LEAST_COVERED = 0.8
_AROUND = 3


@dataclass(frozen=True, eq=False)
class FlattenedCloud:
    """Flattened points (m, 2) in the unit of the cloud, and findings."""

    points: FloatArray
    findings: tuple[Finding, ...]


def flatten_point_cloud(cloud: FloatArray) -> FlattenedCloud:
    """Flatten a point cloud; a point on a seam gets one of its two positions.

    Args:
        cloud: (m, 3) points close to a surface.

    Raises:
        MapError: No surface contains four fifths of the points, or it cannot be flattened.

    Cost: 0.1 s for 250 points.
    """
    try:
        faces, on_surface = _surface(cloud)
        chart = flatten(Mesh(cloud[on_surface], faces), name="learned surface")
    except (MeshError, SkinError) as error:
        raise error.at(kind=MapError, place="learned surface") from error
    notes = [*chart.findings]
    if len(chart.seams):
        action = "closed surface; cut along an additional seam"
        notes.append(Finding("opened", "learned surface", action, len(chart.seams)))
    points = np.zeros((len(cloud), 2))
    # In reverse order, so that the first of two positions is kept.
    points[on_surface[chart.vertex_of[::-1]]] = chart.plane[::-1]
    remaining = np.setdiff1d(np.arange(len(cloud)), on_surface)
    if remaining.size:
        points[remaining] = _means_of_nearest(cloud[remaining], cloud[on_surface], points[on_surface])
        action = "placed between their nearest neighbours on the surface"
        notes.append(Finding("taxels-beside-surface", "learned surface", action, int(remaining.size)))
    return FlattenedCloud(points, tuple(notes))


def _surface(cloud: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the largest component of a surface through the cloud: faces (f, 3) over points (k,), and these points."""
    faces = triangulate(cloud, where="learned surface").mesh.faces
    piece = Connectivity(faces).components if len(faces) else np.zeros(0, dtype=np.int64)
    largest = faces[piece == np.bincount(piece).argmax()] if len(faces) else faces
    own, kept = remove_unreferenced(largest)
    if len(kept) < _LEAST_COVERED * len(cloud):
        raise MapError(
            "no surface could be reconstructed from the learned points", value=f"{len(kept)} of {len(cloud)} are on one"
        )
    return without_small_holes(own), kept


def without_small_holes(faces: IntArray) -> IntArray:
    """Close each hole of few sides by a fan if one fits; the longest border is not a hole.

    A cut would go to every hole and separate neighbours unnecessarily.

    Args:
        faces: (m, 3) manifold and oriented.
    """
    connectivity = Connectivity(faces)
    edges = {(low, high) for low, high in connectivity.edges.tolist()}
    added: list[tuple[int, int, int]] = []
    for loop in connectivity.boundary_loops[1:]:
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


NAME = "geodesic-information"


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress) -> LearnedMap:
    """Build a map, see ``Builder``; deterministic. Cost: 0.2 s for 250 taxels and 3000 touches, 2 s for 1000."""
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(locally_scaled(dissimilarity(touch)), lay=embed_through_space, progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def embed_through_space(distances: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Embed distances (m, m) through three dimensions, or directly in the plane if no surface is found."""
    try:
        opened = flatten_point_cloud(embed_in_space(distances, progress=progress))
    except MapError as error:
        points, _ = embed_in_plane(distances, progress)
        return points, (Finding("no-learned-surface", NAME, f"{error.problem}; embedded in the plane directly"),)
    return opened.points, opened.findings


def embed_in_space(distances: FloatArray, *, progress: Progress = no_progress) -> FloatArray:
    """Return points (m, 3) for complete distances (m, m)."""
    return smacof(distances, classical_mds(distances, dimensions=3), progress=progress)


def locally_scaled(unlike: FloatArray, *, neighbours: int = NEIGHBOURS) -> FloatArray:
    """Divide each distance (k, k) by the geometric mean of the local spacings of its two ends.

    Zelnik-Manor and Perona 2004. The local spacing is the distance to the neighbour of rank ``neighbours``, or the
    largest known distance of a taxel with fewer.
    """
    known = np.where(np.isfinite(unlike), unlike, np.nan)
    np.fill_diagonal(known, np.nan)
    ordered = np.sort(known, axis=1)[:, :neighbours]
    ranks = np.maximum(np.isfinite(ordered).sum(axis=1), 1) - 1
    near = np.nan_to_num(ordered[np.arange(len(ordered)), ranks], nan=1.0)
    root = np.sqrt(np.where(near > 0, near, 1.0))
    return unlike / np.outer(root, root)
