"""The geodesic information map: taxels placed in space first, as a body is, and flattened from there.

McGregor, Polani and Dautenhahn's ANISOMAP (PLoS ONE 6(11), 2011) reconstructs a tactile surface in three dimensions
from information alone, by a scaling of Isomap's kind that withstands sensor failure. Its exact steps are not known
here; this is a map of the same kind, not a copy of theirs: (1) information distance between taxels; (2) near neighbours
joined, each distance in units of what is near for its two ends, so that a taxel which tells little (touched less, at a
border, on a coarse part) is not pushed away; (3) paths; (4) scaling to three dimensions. Ours is the last step: (5) a
surface through the points, cut where it must be and flattened as a body's is.

Three dimensions first, because bodies are closed: in the plane a tube must be crushed at once. In space it is a tube,
which can be cut and unrolled. Distances alone cannot open it: they say that both sides of a seam are neighbours, and a
plane has no room for that. A surface says where it is closed, and the geometric maps know how to cut it. Of 250 taxels
on a tube the plane keeps half of the neighbours, this way four fifths.
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
"""A hole with no more sides is an accident of the triangles, not an end of the body."""
_LEAST_COVERED = 0.8
_AROUND = 3


@dataclass(frozen=True, eq=False)
class FlattenedCloud:
    """Points (m, 2) in the unit of the cloud, and what was noticed."""

    points: FloatArray
    findings: tuple[Finding, ...]


def flatten_point_cloud(cloud: FloatArray) -> FlattenedCloud:
    """Lay a cloud flat; a point on a seam takes one of its two places.

    Args:
        cloud: (m, 3) points on something like a surface.

    Raises:
        MapError: No surface goes through four fifths of the points, or it cannot be flattened.

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
    # Backwards, so that of two places the first is written last, and stays.
    points[on_surface[chart.vertex_of[::-1]]] = chart.plane[::-1]
    beside = np.setdiff1d(np.arange(len(cloud)), on_surface)
    if beside.size:
        points[beside] = _means_of_nearest(cloud[beside], cloud[on_surface], points[on_surface])
        action = "placed between their nearest neighbours on the surface"
        notes.append(Finding("taxels-beside-surface", "learned surface", action, int(beside.size)))
    return FlattenedCloud(points, tuple(notes))


def _surface(cloud: FloatArray) -> tuple[IntArray, IntArray]:
    """The largest piece of a surface through the cloud: faces (f, 3) into the points (k,) that are on it."""
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
    """The faces with each hole of few sides closed by a fan, where one fits; the longest border is no hole.

    A cut goes to every hole, and each would tear neighbours apart for nothing.

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
    """See ``Builder``. There is no chance in it. Cost: 0.2 s for 250 taxels and 3000 touches, 2 s for 1000."""
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = detect_touch(readings)
    placed = embed(locally_scaled(dissimilarity(touch)), lay=embed_through_space, progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def embed_through_space(wanted: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Places (m, 2) for distances (m, m) by way of space; straight in the plane where no surface shows there."""
    try:
        opened = flatten_point_cloud(embed_in_space(wanted, progress=progress))
    except MapError as error:
        points, _ = embed_in_plane(wanted, progress)
        return points, (Finding("no-learned-surface", NAME, f"{error.problem}; embedded in the plane directly"),)
    return opened.points, opened.findings


def embed_in_space(wanted: FloatArray, *, progress: Progress = no_progress) -> FloatArray:
    """(m, 3) points for distances (m, m) that all are known."""
    return smacof(wanted, classical_mds(wanted, dimensions=3), progress=progress).points


def locally_scaled(unlike: FloatArray, *, neighbours: int = NEIGHBOURS) -> FloatArray:
    """(k, k) each distance divided by the geometric mean of what its two ends have for near.

    Zelnik-Manor and Perona 2004. Near is the distance to the neighbour of rank ``neighbours``, or the
    farthest known where a taxel has fewer.
    """
    known = np.where(np.isfinite(unlike), unlike, np.nan)
    np.fill_diagonal(known, np.nan)
    ordered = np.sort(known, axis=1)[:, :neighbours]
    ranks = np.maximum(np.isfinite(ordered).sum(axis=1), 1) - 1
    near = np.nan_to_num(ordered[np.arange(len(ordered)), ranks], nan=1.0)
    root = np.sqrt(np.where(near > 0, near, 1.0))
    return unlike / np.outer(root, root)
