"""Who touches whom in a triangle mesh: edges, boundaries, components. Pure index arithmetic, no coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components

from app.arrays import BoolArray, IntArray
from app.errors import MeshError


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """Every undirected edge once, and the faces beside it.

    Attributes:
        edges: (e, 2) vertex pairs, smaller first, sorted.
        edge_of: (m, 3) the edge opposite to no corner but from corner k to corner k + 1 of each face.
        face_count: (e,) how many faces share each edge.
    """

    edges: IntArray
    edge_of: IntArray
    face_count: IntArray


def edge_table(faces: IntArray) -> EdgeTable:
    """Number the edges of ``faces`` (m, 3). Cost: one sort of 3 m pairs."""
    pairs = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    # One number a pair sorts ten times faster than rows of two.
    base = int(faces.max(initial=0)) + 1
    keys, inverse, count = np.unique(pairs[:, 0] * base + pairs[:, 1], return_inverse=True, return_counts=True)
    return EdgeTable(np.stack(np.divmod(keys, base), axis=1), inverse.reshape(-1, 3), count)


def face_pairs(faces: IntArray) -> IntArray:
    """(p, 2) faces that share an edge with exactly two faces."""
    table = edge_table(faces)
    order = np.argsort(table.edge_of.ravel(), kind="stable")
    owner, edge = order // 3, table.edge_of.ravel()[order]
    inner = table.face_count[edge] == 2
    return owner[inner].reshape(-1, 2)


def face_components(faces: IntArray) -> IntArray:
    """(m,) component label of each face; faces are connected through edges shared by two faces."""
    pairs, count = face_pairs(faces), len(faces)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def boundary_edges(faces: IntArray) -> IntArray:
    """(b, 2) directed edges with a face on their left side only."""
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    table = edge_table(faces)
    return directed[(table.face_count[table.edge_of] == 1).ravel()]


def boundary_loops(faces: IntArray) -> list[IntArray]:
    """Closed loops of boundary vertices, each in the faces' own direction, the longest (by count) first.

    Raises:
        MeshError: A boundary vertex has more than one way on (two fans meet in it) or the faces disagree in direction.
    """
    border = boundary_edges(faces)
    starts, counts = np.unique(border[:, 0], return_counts=True)
    ends = np.unique(border[:, 1])
    if (counts > 1).any() or len(starts) != len(ends) or (starts != ends).any():
        raise MeshError(
            "the boundary is not made of simple loops",
            place=f"vertex {starts[counts.argmax()]}",
            remedy="Split the vertex, or orient the faces alike",
        )
    following = dict(zip(border[:, 0].tolist(), border[:, 1].tolist(), strict=True))
    loops = []
    while following:
        first, vertex = following.popitem()
        loop = [first]
        while vertex != first:
            loop.append(vertex)
            vertex = following.pop(vertex)
        loops.append(np.array(loop, dtype=np.int64))
    return sorted(loops, key=lambda loop: (-len(loop), int(loop.min())))


def bow_tie_vertices(faces: IntArray) -> IntArray:
    """Boundary vertices where more than one fan of faces meets."""
    starts, counts = np.unique(boundary_edges(faces)[:, 0], return_counts=True)
    return starts[counts > 1]


def euler_characteristic(faces: IntArray) -> int:
    """Vertices - edges + faces of the used vertices: 2 for a ball, 1 for a disk, 0 for a tube."""
    return len(np.unique(faces)) - len(edge_table(faces).edges) + len(faces)


def is_closed_manifold(faces: IntArray) -> bool:
    """Whether every edge has two faces that run through it in opposite directions."""
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    base = int(faces.max(initial=0)) + 1
    once = len(np.unique(directed[:, 0] * base + directed[:, 1])) == len(directed)
    return bool(once and (edge_table(faces).face_count == 2).all())


def compact(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Renumber so that only used vertices remain: (faces, kept vertex numbers)."""
    kept, inverse = np.unique(faces, return_inverse=True)
    return inverse.reshape(-1, 3), kept


def faces_at(faces: IntArray, vertices: IntArray, count: int) -> BoolArray:
    """(m,) whether a face touches any of ``vertices``; ``count`` is the number of vertices of the mesh."""
    marked = np.zeros(count, dtype=bool)
    marked[vertices] = True
    return np.asarray(marked[faces].any(axis=1))


def averaging(edges: IntArray, count: int) -> csr_matrix:
    """Sparse (count, count): row i takes the mean over the other ends of the edges at i; zero where there is none."""
    both = np.concatenate([edges, edges[:, ::-1]])
    adjacency = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count)).tocsr()
    degree = np.asarray(adjacency.sum(axis=1)).ravel()
    return (diags(1.0 / np.maximum(degree, 1.0)) @ adjacency).tocsr()
