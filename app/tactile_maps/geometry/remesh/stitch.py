"""Stitching of T-junctions: vertices of one face inside an edge of its neighbour, which does not share them.

Meshes that were refined in parts have them. The surface looks closed but is connected only through shared vertices.
``stitch_junctions`` inserts such vertices into the coarse edge and divides the coarse face, so that both sides have the
same edges. No vertex moves.

Two rules decide which vertices belong to an edge:

- A **crack** between one edge and a chain of border edges, as on a curved surface that is coarse on one side. The chain
  leads from one end of the edge to the other, its distance from the edge is at most ``MOST_GAP`` of the edge's length,
  and its faces continue the surface on the far side. All its vertices are inserted.
- A vertex **on the edge**, within ``ON_EDGE`` of the mesh's size and 1 % of the edge's length, then within ``ROUNDED``.
  It is inserted if a second face, which extends to the far side, then shares one of the two parts of the edge. The
  subdivisions of the two sides may alternate.

An opening as narrow as a crack next to one straight edge cannot be distinguished from it and is closed too. Wider
openings, slits wider than ``ROUNDED`` with vertices on both sides, the mouth of a flat pocket and borders of separate
walls stay open. ``open_cracks`` counts the border edges that may be an unclosed crack.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import chain

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.connectivity import Connectivity, run_starts
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.point_location import owner_and_rank

ON_EDGE = 1e-5
"""Distance from an edge, as a share of the mesh's size, within which a vertex is on it."""
_ON_EDGE_LENGTHS = 0.01
ROUNDED = 1e-4
"""The same for rounded coordinates, used for edges that are still open."""
MOST_GAP = 0.05
"""Largest height of a crack that is closed, as a share of the coarse edge's length. An edge of a polygon that
approximates a circle is 0.05 of its length inside the circle where it spans 23 degrees."""
MOST_OPEN = 2 * MOST_GAP
"""Width of an opening, as a share of the longer edge along it, up to which it may be a crack that stayed open."""
_NEAREST_PARTS = 16
"""Number of nearby border edge parts that are tested for a crack at each edge: a bound on time and memory."""
_ALONG = 0.5
"""Cosine of the largest angle between an edge and the sides of a chain along it."""
_FOLDED = 0.5
"""Cosine of the smallest angle between the two faces of a crack: a smaller one is the mouth of a pocket."""
_LONGEST_CHAIN = 10_000


def stitch_junctions(vertices: FloatArray, faces: IntArray) -> tuple[IntArray, IntArray, int]:
    """Insert border vertices into the border edges that contain them.

    Args:
        vertices: (n, 3), of a mesh of size 1.
        faces: (m, 3), three distinct corners each, no duplicates; in any orientation.

    Returns:
        (k, 3) faces; (k,) the old face that contains each; the number of vertices inserted into edges.

    Cost: one sort of the edges without a border, else 10 µs a border edge.
    """
    owner = np.arange(len(faces))
    count = 0
    border = _Border.of(vertices, faces)
    finds = (_along_edges, partial(_on_edges, within=ON_EDGE), partial(_on_edges, within=ROUNDED))
    for find in finds:  # chains first: they need no search tree
        if border is None:
            break
        edge, vertex = find(border)
        while len(edge):  # until no part of a face folds over, as for a narrow strip stitched to itself
            divided, parent = _divide(vertices, faces, border.sides[edge], vertex)
            before = Mesh(vertices, faces).face_normals[parent]
            after = Mesh(vertices, divided).face_normals
            folded = np.bincount(parent, (before * after).sum(axis=1) <= 0) > 0
            if not folded.any():
                owner = owner[parent]
                faces = divided
                count = count + len(edge)
                border = _Border.of(vertices, faces)
                break
            kept = ~folded[border.sides[edge] // 3]
            edge = edge[kept]
            vertex = vertex[kept]
    return faces, owner, count


def open_cracks(vertices: FloatArray, faces: IntArray) -> tuple[int, float]:
    """Count the border edges along which a second border continues the surface, but is not connected.

    Returns:
        The number of border edges at most ``MOST_OPEN`` of the length of the longer edge from another one that is
        parallel to within 60 degrees and whose face extends to the far side; and the widest distance.

    Cost: like ``stitch_junctions``.
    """
    border = _Border.of(vertices, faces)
    if border is None:
        return 0, 0.0
    start, end = vertices[border.ends].swapaxes(0, 1)
    along = end - start
    lengths = _length(end - start)
    row, points, _ = _parts(vertices[border.ends], lengths, lengths)
    tried = min(_NEAREST_PARTS, len(points))
    nearest = cKDTree(points).query((start + end) / 2, k=np.arange(1, tried + 1))[1]
    edge = row[nearest.ravel()]
    other = np.repeat(np.arange(len(lengths)), tried)
    kept = (edge != other) & (lengths[other] <= lengths[edge])
    edge = edge[kept]
    other = other[kept]
    cosine = np.einsum("kd,kd->k", along[edge], along[other]) / (lengths[edge] * lengths[other])
    kept = (np.abs(cosine) > _ALONG) & _continues(border, edge, other)
    edge = edge[kept]
    other = other[kept]
    arm = (start + end)[other] / 2 - start[edge]
    share = np.einsum("kd,kd->k", arm, along[edge]) / lengths[edge] ** 2
    offset = arm - share[:, None] * along[edge]
    width = _length(offset)
    apex = border.heights(edge, border.apex[edge])[1]
    # The borders of a narrow strip are close as well, but there the face reaches as far as the other border.
    outside = np.einsum("kd,kd->k", offset, apex) < 0.5 * np.einsum("kd,kd->k", apex, apex)
    kept = (share > 0) & (share < 1) & (width <= MOST_OPEN * lengths[edge]) & outside
    edge = edge[kept]
    other = other[kept]
    return len(np.unique(np.concatenate([edge, other]))), float(width[kept].max(initial=0.0))


def _divide(vertices: FloatArray, faces: IntArray, sides: IntArray, added: IntArray) -> tuple[IntArray, IntArray]:
    """Divide faces at the vertices ``added`` (k,) to their rising half-edges ``sides`` (k,), in order along each.

    Returns:
        (m + k, 3) faces and (m + k,) the old face of each: undivided faces in their order, then the others.
    """
    parent = np.unique(sides // 3)
    whole = np.setdiff1d(np.arange(len(faces)), parent)
    done = [faces[whole]]
    owners = [whole]
    corners = faces[parent]
    every = 3 * parent[:, None] + np.arange(3)
    # Half-edges contain the vertices added[low:high].
    low = np.searchsorted(sides, every)
    high = np.searchsorted(sides, every, side="right")
    while len(corners):
        # The longest edge with vertices inside is divided first, at the middle one of these.
        lengths = _length(vertices[corners] - vertices[np.roll(corners, -1, axis=1)])
        turn = (np.where(high > low, lengths, -1.0).argmax(axis=1)[:, None] + np.arange(3)) % 3
        corners, low, high = (np.take_along_axis(rows, turn, axis=1) for rows in (corners, low, high))
        middle = (low[:, 0] + high[:, 0]) // 2
        near = corners.copy()
        far = corners.copy()
        near[:, 1] = far[:, 0] = added[middle]
        none = np.zeros_like(middle)
        near_low = np.stack([low[:, 0], none, low[:, 2]], 1)
        near_high = np.stack([middle, none, high[:, 2]], 1)
        far_low = np.stack([middle + 1, low[:, 1], none], 1)
        far_high = np.stack([high[:, 0], high[:, 1], none], 1)
        corners = np.concatenate([near, far])
        parent = np.concatenate([parent, parent])
        low = np.concatenate([near_low, far_low])
        high = np.concatenate([near_high, far_high])
        ready = (high <= low).all(axis=1)
        done.append(corners[ready])
        owners.append(parent[ready])
        corners = corners[~ready]
        parent = parent[~ready]
        low = low[~ready]
        high = high[~ready]
    return np.concatenate(done), np.concatenate(owners)


@dataclass(frozen=True, eq=False)
class _Border:
    """Border of a mesh: the edges with one face.

    Attributes:
        vertices: (n, 3) of the mesh.
        inner: Keys of the edges with more faces, rising; see ``keys``.
        sides: (b,) half-edges.
        ends: (b, 2) their vertices.
        apex: (b,) the third vertex of the face of each.
    """

    vertices: FloatArray
    inner: IntArray
    sides: IntArray
    ends: IntArray
    apex: IntArray

    @staticmethod
    def of(vertices: FloatArray, faces: IntArray) -> _Border | None:
        """Return the border of a mesh; None if it is closed."""
        table = Connectivity(faces)
        sides = table.boundary_sides
        if not len(sides):
            return None
        low, high = table.edges[table.face_count > 1].T
        apex = faces[sides // 3, (sides + 2) % 3]
        return _Border(vertices, low * len(vertices) + high, sides, table.boundary_edges, apex)

    def keys(self, start: IntArray, end: IntArray) -> IntArray:
        """Return one key for each pair of vertices."""
        return np.minimum(start, end) * len(self.vertices) + np.maximum(start, end)

    def is_inner(self, keys: IntArray) -> BoolArray:
        """Return whether the vertices of each key share an edge with two faces or more."""
        place = np.searchsorted(self.inner, keys)
        return np.asarray(np.append(self.inner, -1)[place] == keys)

    def heights(self, edge: IntArray, vertex: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the share along each edge at which a vertex projects onto it, and its offset (k, 3) from the line."""
        start, end = self.vertices[self.ends[edge]].swapaxes(0, 1)
        along = end - start
        arm = self.vertices[vertex] - start
        share = np.einsum("kd,kd->k", arm, along) / np.einsum("kd,kd->k", along, along)
        return share, arm - share[:, None] * along


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("...d,...d->...", vectors, vectors)))


def _on_edges(border: _Border, within: float) -> tuple[IntArray, IntArray]:
    """Return edges and the vertices to be inserted into each, in order along it."""
    every = np.arange(len(border.ends))
    lengths = _length(border.vertices[border.ends[:, 1]] - border.vertices[border.ends[:, 0]])
    near = np.minimum(within, _ON_EDGE_LENGTHS * lengths)
    # A face this flat is on its edge as a whole: the far border of a thin strip is not a junction.
    tall = _length(border.heights(every, border.apex)[1]) > 4 * near
    edge, vertex = _close_pairs(border.vertices, border.ends, lengths, near, np.flatnonzero(tall))
    kept = (vertex != border.ends[edge, 0]) & (vertex != border.ends[edge, 1]) & (vertex != border.apex[edge])
    edge = edge[kept]
    vertex = vertex[kept]
    share, offset = border.heights(edge, vertex)
    kept = (np.minimum(share, 1 - share) * lengths[edge] > near[edge]) & (_length(offset) <= near[edge])
    edge = edge[kept]
    vertex = vertex[kept]
    share = share[kept]
    order = np.lexsort((vertex, share, edge))
    order = order[run_starts(edge[order], vertex[order])]  # a pair may be found by two balls
    edge = edge[order]
    vertex = vertex[order]
    while len(edge):
        useful = _joins(border, edge, vertex, tall)
        if useful.all():
            break
        edge = edge[useful]
        vertex = vertex[useful]
    return edge, vertex


def _close_pairs(
    vertices: FloatArray, ends: IntArray, lengths: FloatArray, near: FloatArray, chosen: IntArray
) -> tuple[IntArray, IntArray]:
    """Return pairs of ``chosen`` border edges and border vertices.

    All pairs closer than ``near`` (b,) are included, and others; some appear twice.
    """
    if not len(chosen):
        return chosen, chosen
    row, points, half = _parts(vertices[ends[chosen]], lengths[chosen], lengths)
    reach = half + near[chosen[row]]
    used = _sorted_unique(ends[chosen].ravel())
    found = cKDTree(vertices[used]).query_ball_point(points, reach, return_sorted=False)
    sizes = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
    hit = np.fromiter(chain.from_iterable(found), dtype=np.int64, count=int(sizes.sum()))
    return np.repeat(chosen[row], sizes), used[hit]


def _parts(ends: FloatArray, lengths: FloatArray, all_lengths: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Divide edges with ``ends`` (k, 2, 3) into parts about as long as most edges with ``all_lengths``.

    Balls around the parts contain few other vertices, even where one edge is as long as a hundred others.

    Returns:
        (p,) the edge of each part; (p, 3) its midpoint; (p,) half its length.
    """
    spacing = max(float(np.median(all_lengths)), float(all_lengths.mean()) / 2)
    count = np.ceil(lengths / spacing).astype(np.int64)
    row, step = owner_and_rank(count)
    share = (step + 0.5) / count[row]
    start, end = ends[row].swapaxes(0, 1)
    return row, start + share[:, None] * (end - start), 0.5 * lengths[row] / count[row]


def _sorted_unique(values: IntArray) -> IntArray:
    """Return the sorted unique values; several times faster than ``np.unique``, which hashes."""
    ordered = np.sort(values)
    return ordered[run_starts(ordered)]


def _joins(border: _Border, edge: IntArray, vertex: IntArray, tall: BoolArray) -> BoolArray:
    """Return the vertices, sorted along their edges, that create a part of the edge shared with one other face."""
    every = np.arange(len(border.ends))
    order = np.argsort(np.concatenate([every, edge]), kind="stable")
    of = np.concatenate([every, edge])[order]
    start = np.concatenate([border.ends[:, 0], vertex])[order]
    end = np.where(np.roll(run_starts(of), -1), border.ends[of, 1], np.roll(start, -1))
    key = border.keys(start, end)
    by_key = np.argsort(key, kind="stable")
    new = run_starts(key[by_key])
    twice = new & ~np.roll(new, -1) & np.roll(new, -2)  # the first of exactly two rows with one key
    first = by_key[twice]
    second = by_key[np.roll(twice, 1)]
    fits = tall[of[first]] & tall[of[second]] & ~border.is_inner(key[first])
    fits[fits] = _continues(border, of[first[fits]], of[second[fits]])
    shared = np.zeros(len(order), dtype=bool)
    shared[first[fits]] = shared[second[fits]] = True
    result = np.zeros(len(order), dtype=bool)
    result[order] = shared | np.roll(shared, 1)  # the row before a vertex is the part before it
    return result[len(every) :]


def _along_edges(border: _Border) -> tuple[IntArray, IntArray]:
    """Return edges with a crack along them, and the vertices of its far side in order along the edge."""
    reached, walked, visited = _chains(border)
    whole = reached[walked]
    walked = walked[whole]
    visited = visited[whole]
    # A crack has one coarse edge: neither of two edges along one chain is chosen, nor an edge that is part of a chain.
    last = np.roll(run_starts(walked), -1)
    start = np.where(run_starts(walked), border.ends[walked, 0], np.roll(visited, 1))
    key = np.concatenate([border.keys(start, visited), border.keys(visited[last], border.ends[walked[last], 1])])
    order = np.argsort(key, kind="stable")
    new = run_starts(key[order])
    repeated = order[~(new & np.roll(new, -1))]
    bad = np.isin(border.keys(*border.ends.T), key)
    bad[np.concatenate([walked, walked[last]])[repeated]] = True
    return walked[~bad[walked]], visited[~bad[walked]]


def _chains(border: _Border) -> tuple[BoolArray, IntArray, IntArray]:
    """Walk along the border next to each edge, from its start.

    Returns:
        (b,) whether the walk of each edge reaches its end; edges and visited vertices, by edge in order.
    """
    both = np.concatenate([border.ends, border.ends[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    target = both[order, 1]
    via = np.tile(np.arange(len(border.ends)), 2)[order]
    begin = np.searchsorted(both[order, 0], np.arange(len(border.vertices) + 1))
    along = border.vertices[border.ends[:, 1]] - border.vertices[border.ends[:, 0]]
    lengths = _length(along)
    edge = np.arange(len(border.ends))
    here = border.ends[:, 0]
    reached = np.zeros(len(border.ends), dtype=bool)
    edges = []
    visited = []
    for _ in range(_LONGEST_CHAIN):
        row, step = owner_and_rank(begin[here + 1] - begin[here])
        way = begin[here[row]] + step
        other = via[way] != edge[row]
        row = row[other]
        way = way[other]
        of = edge[row]
        there = target[way]
        move = border.vertices[there] - border.vertices[here[row]]
        cosine = np.einsum("kd,kd->k", move, along[of]) / (_length(move) * lengths[of])
        ahead = cosine > _ALONG
        of = of[ahead]
        there = there[ahead]
        by = via[way[ahead]]
        cosine = cosine[ahead]
        share, offset = border.heights(of, there)
        at_end = there == border.ends[of, 1]
        fits = at_end | ((share < 1) & (_length(offset) <= MOST_GAP * lengths[of]))
        fits[fits] = _continues(border, of[fits], by[fits])
        of = of[fits]
        there = there[fits]
        at_end = at_end[fits]
        cosine = cosine[fits]
        best = np.lexsort((-cosine, of))
        best = best[run_starts(of[best])]
        of = of[best]
        there = there[best]
        at_end = at_end[best]
        reached[of[at_end]] = True
        edge = of[~at_end]
        here = there[~at_end]
        if not len(edge):
            break
        edges.append(edge)
        visited.append(here)
    none = np.zeros(0, dtype=np.int64)
    walked = np.concatenate([none, *edges])
    order = np.argsort(walked, kind="stable")
    return reached, walked[order], np.concatenate([none, *visited])[order]


def _continues(border: _Border, edge: IntArray, other: IntArray) -> BoolArray:
    """Return whether the faces of two border edges extend to different sides, not into one pocket."""
    coarse = border.heights(edge, border.apex[edge])[1]
    fine = border.heights(other, border.apex[other])[1]
    return np.asarray(np.einsum("kd,kd->k", fine, coarse) < _FOLDED * _length(coarse) * _length(fine))
