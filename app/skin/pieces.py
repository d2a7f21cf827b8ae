"""Where on a wrapped link skin can lie: not where neighbouring links move, in tidy connected pieces."""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np
from scipy.sparse import diags

from app.arrays import BoolArray, FloatArray
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.topology import (
    averaging,
    boundary_edges,
    bow_tie_vertices,
    compact,
    face_components,
    faces_at,
)

_ROWS_BEHIND = 3


def clear_of(surface: Mesh, others: Sequence[Mesh], *, distance: float) -> BoolArray:
    """(n,) vertices that keep ``distance`` [m] from every other mesh and do not lie inside one.

    Args:
        surface: The candidate surface.
        others: Cleaned meshes in the surface's frame; they need not be closed (inside is judged by winding number).
        distance: To keep [m].
    """
    clear = np.ones(len(surface.vertices), dtype=bool)
    for other in others:
        low, high = other.bounds
        near = ((surface.vertices > low - distance) & (surface.vertices < high + distance)).all(axis=1)
        near = np.flatnonzero(near & clear)
        if len(near):
            points = np.ascontiguousarray(surface.vertices[near])
            away = ClosestPoint(other).query(points)[2]
            winding = igl.fast_winding_number(other.vertices, other.faces, points)
            clear[near[(away < distance) | (np.abs(winding) > 0.5)]] = False
    return clear


def tidy_pieces(surface: Mesh, usable: BoolArray, *, smallest: float, largest_hole: float) -> list[Mesh]:
    """Connected pieces of the faces whose corners are all usable, largest first.

    Small holes in the usable part are filled again, ragged borders are trimmed and smoothed.

    Args:
        surface: Manifold.
        usable: (n,) by vertex.
        smallest: Pieces below this area [m²] are dropped.
        largest_hole: Holes up to this area [m²] are filled.
    """
    keep = np.asarray(usable[surface.faces].all(axis=1))
    keep = _without_crumbs(surface, keep, smallest)
    keep = ~_without_crumbs(surface, ~keep, largest_hole)
    keep = _trimmed(surface, keep)
    pieces = []
    for faces in _split(surface, keep):
        numbered, used = compact(faces)
        piece = Mesh(surface.vertices[used], numbered)
        if piece.area >= smallest:
            pieces.append(Mesh(_smooth_border(piece), numbered))
    return sorted(pieces, key=lambda piece: -piece.area)


def piece_name(link: str, before: int) -> str:
    """Name of the patch on ``link`` when ``before`` others have been named: "forearm", "forearm 2"."""
    return link if before == 0 else f"{link} {before + 1}"


def _split(surface: Mesh, keep: BoolArray) -> list[np.ndarray[tuple[int, int], np.dtype[np.int64]]]:
    faces = surface.faces[keep]
    if not len(faces):
        return []
    labels = face_components(faces)
    return [faces[labels == label] for label in range(labels.max() + 1)]


def _without_crumbs(surface: Mesh, keep: BoolArray, smallest: float) -> BoolArray:
    """Drop connected groups of kept faces whose area is below ``smallest``."""
    if not keep.any():
        return keep
    labels = face_components(surface.faces[keep])
    areas = np.bincount(labels, weights=surface.face_areas[keep])
    result = keep.copy()
    result[np.flatnonzero(keep)[areas[labels] < smallest]] = False
    return result


def _trimmed(surface: Mesh, keep: BoolArray) -> BoolArray:
    """Peel faces that hang by one edge, and faces at vertices where two fans meet, until none is left."""
    keep = keep.copy()
    while keep.any():
        faces = surface.faces[keep]
        border = np.sort(boundary_edges(faces), axis=1)
        count = np.bincount(border.ravel(), minlength=len(surface.vertices))
        pairs = {tuple(edge) for edge in border.tolist()}
        suspects = np.flatnonzero((count[faces] > 0).all(axis=1))
        sides = [sum(tuple(sorted((f[k], f[k - 2]))) in pairs for k in range(3)) for f in faces[suspects].tolist()]
        drop = faces_at(faces, bow_tie_vertices(faces), len(surface.vertices))
        drop[suspects[np.array(sides, dtype=int) >= 2]] = True
        if not drop.any():
            return keep
        keep[np.flatnonzero(keep)[drop]] = False
    return keep


def _smooth_border(piece: Mesh, rounds: int = 12) -> FloatArray:
    """Vertices with the border slid along itself to a smooth line, and the rows behind it evened out.

    Each vertex stays in its own tangent plane.
    """
    border, edges, count = boundary_edges(piece.faces), piece.edges, len(piece.vertices)
    if not len(border):
        return piece.vertices
    on_border = np.zeros(count, dtype=bool)
    on_border[border] = True
    behind = on_border.copy()
    for _ in range(_ROWS_BEHIND):
        behind[edges[behind[edges].any(axis=1)]] = True
    average = averaging(edges, count)
    # A border vertex follows the border alone, the others all their neighbours.
    average = diags(on_border.astype(float)) @ averaging(border, count) + diags((~on_border).astype(float)) @ average
    vertices, normals = piece.vertices, piece.vertex_normals
    for _ in range(rounds):
        step = np.where(behind[:, None], 0.5 * (average @ vertices - vertices), 0.0)
        vertices = vertices + step - (step * normals).sum(axis=1, keepdims=True) * normals
    return vertices
