"""Cutting a patch along seams until it is a disk that can be flattened.

A weighted tree-cotree cut (Eppstein 2003; Erickson and Whittlesey 2005) with each boundary loop contracted to one node:
a shortest-path tree from the longest loop, a spanning tree of the faces beside it, and the edges that neither uses.
What hangs loose is pruned, so that a tube is cut along one shortest path, a closed ball between two far points, and a
surface with handles through each of them.

``SeamPlan`` says where a person wants seams and where not, and how many more. A seam lets a deep patch lie flatter and
takes neighbours apart. Further seams go where they help most: a tube is cut along the shortest path between its ends, a
closed body between two far points, and each one more reaches the place farthest from the border and the seams so far;
all keep out of areas of interest where they can.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice, pairwise

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.geodesics import distances_from, edge_graph, path_in_tree, shortest_path_tree
from tactile_maps.geometry.surface.connectivity import Connectivity, corner_fans, side_ends
from tactile_maps.geometry.surface.mesh import Mesh


@dataclass(frozen=True, eq=False)
class CutSurface:
    """A surface cut to a disk; its faces keep their numbers.

    Attributes:
        faces: (m, 3) into the cut's own vertices.
        vertex_of: (k,) the surface's vertex behind each of them; a seam's vertex has several copies.
        seams: (s, 2) cut edges as pairs of the surface's vertices.
    """

    faces: IntArray
    vertex_of: IntArray
    seams: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "faces", "vertex_of", "seams", dtype=np.int64)

    @cached_property
    def connectivity(self) -> Connectivity:
        """Which faces, edges and vertices of the cut surface meet; computed once."""
        return Connectivity(self.faces)


def cut_to_disk(
    surface: Mesh, *, terminals: Sequence[int] = (), importance: FloatArray | None = None, drawn: IntArray | None = None
) -> CutSurface:
    """Cut a connected, manifold, oriented surface to a disk with the shortest seams that do it.

    Args:
        surface: Any number of boundary loops, any genus; closed is allowed.
        terminals: Vertices that a seam must also reach.
        importance: (n,) by vertex, not negative: a seam counts as 1 + importance times as long there, so that it goes
            around areas of interest where it can.
        drawn: (s, 2) edges, as pairs of vertices, that are cut whatever else is.

    Raises:
        MapError: The surface is empty, not connected, not manifold, its faces disagree about the outside, a drawn pair
            is not an edge of it, or the drawn seams cut it in two.

    Cost: three sorts and one Dijkstra; 30 ms for 20,000 faces.
    """
    _check(surface)
    if drawn is None or not len(drawn):
        return _shortest_cut(surface, terminals, importance)
    faces, vertex_of = _open(surface, _drawn_edges(surface.connectivity, drawn))
    slit = Mesh(surface.vertices[vertex_of], faces)
    if len(faces) and slit.connectivity.components.max() > 0:
        raise MapError("the drawn seam cuts the patch in two", remedy="Leave a gap in it, or split the patch")
    first = {int(vertex): copy for copy, vertex in reversed(list(enumerate(vertex_of.tolist())))}
    rest = _shortest_cut(
        slit, [first[int(end)] for end in terminals], None if importance is None else importance[vertex_of]
    )
    below = vertex_of[rest.vertex_of]
    return CutSurface(rest.faces, below, _seams(surface.connectivity, rest.faces))


def _drawn_edges(connectivity: Connectivity, drawn: IntArray) -> BoolArray:
    """(e,) which edges are drawn; those of the border are cut already."""
    known = {tuple(edge): number for number, edge in enumerate(connectivity.edges.tolist())}
    chosen = np.zeros(len(connectivity.edges), dtype=bool)
    for pair in np.sort(drawn, axis=1).tolist():
        if tuple(pair) not in known:
            raise MapError(
                "a drawn seam leaves the edges of the surface",
                value=f"vertices {pair[0]} and {pair[1]}",
                remedy="Draw along edges",
            )
        chosen[known[tuple(pair)]] = True
    return chosen


def _seams(surface: Connectivity, faces: IntArray) -> IntArray:
    """(s, 2) the surface's inner edges that the two faces beside them no longer share in ``faces``."""
    sides = surface.twins
    corners = faces.ravel()
    after = side_ends(sides)
    parted = (corners[sides[:, 0]] != corners[after[:, 1]]) | (corners[after[:, 0]] != corners[sides[:, 1]])
    return surface.edges[surface.twin_edges[parted]]


def _shortest_cut(surface: Mesh, terminals: Sequence[int], importance: FloatArray | None) -> CutSurface:
    connectivity = surface.connectivity
    loops = connectivity.boundary_loops
    ends = list(terminals)
    if not loops and not ends and connectivity.euler_characteristic == 2:
        ends = far_points(surface, importance=importance)  # a ball: nothing but two far points says where to open it
    nodes, marked, root = _contract(surface, loops, ends)
    cut = _cut_edges(connectivity, _edge_costs(surface, importance), nodes, marked, root)
    faces, vertex_of = _open(surface, cut)
    result = CutSurface(faces, vertex_of, connectivity.edges[cut])
    if result.connectivity.euler_characteristic != 1 or len(result.connectivity.boundary_loops) != 1:
        raise MapError(
            "the surface could not be cut to a disk",
            value=f"{len(loops)} boundary loops",
            remedy="Split it into simpler patches",
        )
    return result


def far_points(surface: Mesh, *, importance: FloatArray | None = None) -> list[int]:
    """The vertex farthest from the middle, and the one farthest from it along the edges; unimportant if possible."""
    used = _unimportant(np.unique(surface.faces), importance)
    away = np.linalg.norm(surface.vertices[used] - surface.vertices[used].mean(axis=0), axis=1)
    first = int(used[away.argmax()])
    return [first, _farthest(surface, np.array([first]), importance)]


def farthest_from_border(surface: Mesh, cut: CutSurface, *, importance: FloatArray | None = None) -> int:
    """The vertex farthest, along the edges, from the border and the seams: where one more seam helps most."""
    return _farthest(surface, np.unique(cut.vertex_of[cut.connectivity.boundary_loops[0]]), importance)


def _farthest(surface: Mesh, sources: IntArray, importance: FloatArray | None) -> int:
    distance = distances_from(edge_graph(surface.edges, surface.edge_lengths, len(surface.vertices)), sources)
    allowed = _unimportant(np.flatnonzero(np.isfinite(distance)), importance)
    return int(allowed[np.argmax(distance[allowed])])


def _unimportant(vertices: IntArray, importance: FloatArray | None) -> IntArray:
    """Those of ``vertices`` outside areas of interest; all where nothing is outside."""
    if importance is None or (importance[vertices] > 0).all():
        return vertices
    return vertices[importance[vertices] == 0]


def _check(surface: Mesh) -> None:
    """Refuse what no cut can turn into a disk."""
    if not len(surface.faces):
        raise MapError("the surface has no faces to flatten")
    connectivity = surface.connectivity
    if connectivity.face_count.max() > 2:
        raise MapError(
            "an edge of the surface has more than two faces",
            value=int(connectivity.face_count.max()),
            remedy="Cover the link anew, or clean the mesh",
        )
    if not connectivity.agrees_in_direction:
        raise MapError("neighbouring faces are oriented inconsistently", remedy="Orient the faces alike")
    pieces = int(connectivity.components.max()) + 1
    if pieces > 1:
        raise MapError("the surface is not in one piece", value=f"{pieces} pieces", remedy="Make each piece a patch")


def _edge_costs(surface: Mesh, importance: FloatArray | None) -> FloatArray:
    """(e,) the length of each edge [m] as a seam counts it."""
    if importance is None:
        return surface.edge_lengths
    return surface.edge_lengths * (1 + importance[surface.edges].mean(axis=1))


def _contract(surface: Mesh, loops: Sequence[IntArray], ends: Sequence[int]) -> tuple[IntArray, BoolArray, int]:
    """Node of each vertex (a loop is one node), which nodes seams must reach, and the tree's root."""
    nodes = np.arange(len(surface.vertices))
    lengths = []
    for loop in loops:
        nodes[loop] = loop[0]
        sides = surface.vertices[loop] - np.roll(surface.vertices[loop], 1, axis=0)
        lengths.append(np.linalg.norm(sides, axis=1).sum())
    marked = np.zeros(len(nodes), dtype=bool)
    marked[[nodes[loop[0]] for loop in loops] + [nodes[end] for end in ends]] = True
    start = loops[int(np.argmax(lengths))][0] if loops else (ends[0] if ends else surface.faces[0, 0])
    return nodes, marked, int(nodes[start])


def _cut_edges(
    connectivity: Connectivity, lengths: FloatArray, nodes: IntArray, marked: BoolArray, root: int
) -> BoolArray:
    """(e,) which edges are seams; ``lengths`` (e,) as they count."""
    ends = nodes[connectivity.edges]
    shared = connectivity.face_count == 2
    tree, distance = _shortest_tree(ends, lengths, shared & (ends[:, 0] != ends[:, 1]), root, len(nodes))
    cotree = _face_tree(connectivity, tree, distance[ends].sum(axis=1) + lengths)
    loose = shared & ~tree & ~cotree
    return _pruned(ends, tree | loose, marked)


def _shortest_tree(
    ends: IntArray, lengths: FloatArray, usable: BoolArray, root: int, count: int
) -> tuple[BoolArray, FloatArray]:
    """Edges of a shortest-path tree from ``root``, and each node's distance."""
    # Of parallel edges between two nodes only the shortest may be in the tree.
    numbers = np.flatnonzero(usable)
    low = ends[numbers].min(axis=1)
    high = ends[numbers].max(axis=1)
    order = np.lexsort((lengths[numbers], high, low))
    numbers = numbers[order]
    low = low[order]
    high = high[order]
    first = np.ones(len(numbers), dtype=bool)
    first[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    numbers = numbers[first]
    low = low[first]
    high = high[first]
    graph = edge_graph(np.stack([low, high], axis=1), lengths[numbers], count)
    distance, before = shortest_path_tree(graph, root)
    reached = np.flatnonzero(before >= 0)
    key = np.minimum(reached, before[reached]) * count + np.maximum(reached, before[reached])
    tree = np.zeros(len(ends), dtype=bool)
    tree[numbers[np.searchsorted(low * count + high, key)]] = True
    return tree, np.where(np.isfinite(distance), distance, 0.0)


def _face_tree(connectivity: Connectivity, tree: BoolArray, weight: FloatArray) -> BoolArray:
    """Edges crossed by a spanning tree of the faces that avoids ``tree`` and prefers far, long edges."""
    free = ~tree[connectivity.twin_edges]
    pairs = connectivity.face_pairs[free]
    crossed = connectivity.twin_edges[free]
    cost = weight.max() - weight[crossed] + 1e-9 * (weight.max() or 1.0)
    count = len(connectivity.faces)
    # Faces that share two edges would have their costs added up by the matrix: keep the cheaper crossing only.
    key = pairs.min(axis=1) * count + pairs.max(axis=1)
    best = np.lexsort((cost, key))
    best = best[np.r_[True, key[best][1:] != key[best][:-1]]] if len(best) else best
    pairs = pairs[best]
    crossed = crossed[best]
    cost = cost[best]
    key = key[best]
    graph = edge_graph(np.sort(pairs, axis=1), cost, count)
    spanning = minimum_spanning_tree(graph).tocoo()
    used = np.minimum(spanning.row, spanning.col).astype(np.int64) * count + np.maximum(spanning.row, spanning.col)
    result = np.zeros(len(tree), dtype=bool)
    result[crossed[np.searchsorted(key, used)]] = True
    return result


def _pruned(ends: IntArray, cut: BoolArray, marked: BoolArray) -> BoolArray:
    """Drop cut edges that end at an unmarked node, until none does.

    Cost: 1 µs for each edge of ``cut``, however long the chains that hang loose.
    """
    chosen = np.flatnonzero(cut)
    near, far = ends[chosen].T
    degree = np.bincount(ends[chosen].ravel(), minlength=len(marked))
    # The sum of a node's edges, and of their other ends, tells the last one that is left.
    edges = np.zeros_like(degree)
    others = np.zeros_like(degree)
    for here, there in ((near, far), (far, near)):
        np.add.at(edges, here, chosen)
        np.add.at(others, here, there)
    loose = np.flatnonzero((degree == 1) & ~marked).tolist()
    left = degree.tolist()
    last = edges.tolist()
    other = others.tolist()
    kept = marked.tolist()
    dropped = []
    for node in loose:  # grows while it is read
        if left[node] != 1:
            continue
        edge = last[node]
        after = other[node]
        dropped.append(edge)
        left[node] = 0
        left[after] -= 1
        last[after] -= edge
        other[after] -= node
        if left[after] == 1 and not kept[after]:
            loose.append(after)
    result = cut.copy()
    result[dropped] = False
    return result


def _open(surface: Mesh, cut: BoolArray) -> tuple[IntArray, IntArray]:
    """Give each fan of faces between seams its own copy of the vertex: (faces, surface vertex of each copy)."""
    connectivity = surface.connectivity
    whole = connectivity.twins[~cut[connectivity.twin_edges]]
    _, first, faces = np.unique(corner_fans(surface.faces, whole), return_index=True, return_inverse=True)
    return faces.reshape(-1, 3), surface.faces.ravel()[first]


def _none_drawn() -> IntArray:
    return np.zeros((0, 2), dtype=np.int64)


MOST_SEAMS = 100
"""Extra seams of one patch; each takes a pass over the surface."""


@dataclass(frozen=True, eq=False)
class SeamPlan:
    """What is wanted of one patch's seams.

    Attributes:
        extra: Seams besides the drawn ones and those that the topology asks for; None for as many as are worth it.
        drawn: (s, 2) edges to be cut, as pairs of the surface's vertices.
        importance: (n,) by vertex, 0 or more: seams avoid what is important; None where nothing is.
    """

    extra: int | None = None
    drawn: IntArray = field(default_factory=_none_drawn)
    importance: FloatArray | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self, "drawn", dtype=np.int64, columns=2)
        if self.extra is not None and not 0 <= self.extra <= MOST_SEAMS:
            remedy = f"Choose 0 to {MOST_SEAMS}"
            raise MapError("the number of seams is out of range", place="seams", value=self.extra, remedy=remedy)
        if self.importance is not None:
            freeze_arrays(self, "importance")
            if not (np.isfinite(self.importance) & (self.importance >= 0)).all():
                raise MapError("an importance is not a number from 0 up", place="importance")


def cut_as_planned(surface: Mesh, plan: SeamPlan, extra: int) -> CutSurface:
    """The patch cut as planned, with ``extra`` seams more; errors as ``planned_cuts``."""
    return next(islice(planned_cuts(surface, plan), extra, None))


def planned_cuts(surface: Mesh, plan: SeamPlan) -> Iterator[CutSurface]:
    """The patch cut as planned, then with one seam more each time, each to the place farthest from all before.

    Raises:
        MapError: See ``cut_to_disk``; or the plan is for another surface.

    Cost: a cut each, see ``cut_to_disk``, and as much again to find the farthest place.
    """
    if plan.importance is not None and len(plan.importance) != len(surface.vertices):
        raise MapError("the areas of interest are another surface's", value=len(plan.importance))
    ends: list[int] = []
    while True:
        cut = _cut_with_ends(surface, plan, ends)
        yield cut
        ends.append(farthest_from_border(surface, cut, importance=plan.importance))


def _cut_with_ends(surface: Mesh, plan: SeamPlan, ends: Sequence[int]) -> CutSurface:
    # A closed surface is cut between two points anyway; those stay when more are added.
    closed = len(ends) > 0 and not len(plan.drawn) and not surface.connectivity.boundary_loops
    first = far_points(surface, importance=plan.importance) if closed else []
    return cut_to_disk(surface, terminals=[*first, *ends], importance=plan.importance, drawn=plan.drawn)


def shortest_edge_path(surface: Mesh, through: Sequence[int], *, importance: FloatArray | None = None) -> IntArray:
    """The shortest path along edges from vertex to vertex of ``through``: (s, 2) edges, a seam as drawn by hand.

    Raises:
        MapError: Fewer than two vertices, or no way between two of them.

    Cost: one Dijkstra a piece; 5 ms for 10,000 vertices.
    """
    if len(through) < 2:
        raise MapError("a seam needs two ends", value=len(through), remedy="Mark at least two places")
    graph = edge_graph(surface.edges, _edge_costs(surface, importance), len(surface.vertices))
    pieces = []
    for start, end in pairwise(through):
        walk = path_in_tree(shortest_path_tree(graph, start)[1], end)
        if walk[0] != start:
            raise MapError("no path along edges connects two points of the seam", value=f"vertices {start} and {end}")
        pieces.append(np.stack([walk[:-1], walk[1:]], axis=1))
    return np.unique(np.sort(np.concatenate(pieces), axis=1), axis=0)
