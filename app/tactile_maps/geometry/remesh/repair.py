"""What a mesh from a file needs: cleaned before native code may see it, or repaired so that it can be flattened.

``clean_mesh`` welds equal vertices and drops empty, zero-area and duplicate faces: enough for what only looks at a
surface (a wrap, rays, closest points).

``repair_mesh`` makes any mesh fit to be flattened, with every change told and traceable to the file's own vertices and
faces. The user's triangles stay where they are; only their numbering changes. In order: vertices at one place become
one; faces that are a line, a point or a copy go; faces are divided at vertices of their neighbours that lie inside
their edges (``stitch``); neighbours turn to agree about the outside; what meets in more than a surface is taken apart;
whole components turn outward; degenerate faces are flipped away.

``flip_degenerate_faces`` takes faces without area out of a surface without leaving a slit. A face whose three corners
lie on a line has its middle corner on its longest side. Turning that side towards the face behind it (an edge flip)
splits the face behind at the middle corner: the same points, no face without area, no hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import Finding, MeshError
from tactile_maps.geometry.remesh.stitch import open_cracks, stitch_junctions
from tactile_maps.geometry.surface.connectivity import (
    Connectivity,
    components_of,
    flip_faces,
    manifold_twins,
    orient_faces,
    remove_unreferenced,
    split_nonmanifold,
)
from tactile_maps.geometry.surface.mesh import Mesh

RELATIVE_WELD = 1e-7
"""Vertices closer than this share of the mesh's size are one; float32 files round at about this level."""
_ROUNDING = 4 * np.finfo(np.float64).eps


def clean_mesh(mesh: Mesh, *, where: str = "mesh") -> tuple[Mesh, tuple[Finding, ...]]:
    """Weld equal vertices, drop faces that enclose no area or stand twice, drop unused vertices.

    Enough for what only looks at a surface (a wrap, rays, closest points); what is flattened needs ``repair_mesh``.

    Args:
        mesh: Any finite mesh.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left.
    """
    vertices = mesh.vertices
    faces = mesh.faces
    notes = []
    if len(faces) and mesh.size > 0:
        tolerance = weld_tolerance(mesh.vertices)
        same = weld_vertices(mesh.vertices, tolerance)
        flat = Mesh(vertices, same[faces]).face_areas <= tolerance**2
        whole = same[faces][~flat]
        kept = unique_faces(whole)
        notes = [
            Finding("duplicate-vertex", where, "welded", int((same != np.arange(len(same))).sum())),
            Finding("zero-area-face", where, "dropped", int(flat.sum())),
            Finding("duplicate-face", where, "dropped", len(whole) - len(kept)),
        ]
        faces = whole[kept]
    if not len(faces) or mesh.size == 0:
        raise _no_area_error(mesh, where)
    faces, used = remove_unreferenced(faces)
    return Mesh(vertices[used], faces), tuple(note for note in notes if note.count)


def _no_area_error(mesh: Mesh, where: str) -> MeshError:
    """The error for a mesh of which nothing can be used."""
    value = f"{len(mesh.faces)} faces"
    remedy = "Export it again with triangles"
    return MeshError("the mesh has no face with an area", file=where, value=value, remedy=remedy)


def weld_tolerance(vertices: FloatArray) -> float:
    """Distance [m] below which two of ``vertices`` (n, 3) are one: a share of their extent, or rounding far away."""
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    return max(RELATIVE_WELD * extent, _ROUNDING * float(np.abs(vertices).max()))


def weld_vertices(vertices: FloatArray, tolerance: float) -> IntArray:
    """(n,) the first of all vertices that are one with each, for vertices (n, 3) and ``tolerance`` > 0.

    All within the tolerance are one, chains of them too; some up to twice as far apart may be.
    """
    # A fine grid first, so that the search tree has few points even where a file repeats each of them many times.
    # Centred, so that a far offset does not eat the digits.
    cell = tolerance / 4
    first, kind = _distinct_rows(np.rint((vertices - vertices.mean(axis=0)) / cell))
    reach = tolerance + 2 * np.sqrt(3) * cell  # each vertex is up to a cell's diagonal from its cell's first
    pairs = cKDTree(vertices[first]).query_pairs(reach, output_type="ndarray")
    if len(pairs):
        graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(first),) * 2)
        count, group = connected_components(graph, directed=False)
        lowest = np.full(count, len(vertices))
        np.minimum.at(lowest, group, first)
        first = lowest[group]
    return np.asarray(first[kind], dtype=np.int64)


def unique_faces(faces: IntArray) -> IntArray:
    """Numbers, rising, of the first face on each set of three corners, whichever way it turns."""
    return np.sort(_distinct_rows(np.sort(faces, axis=1))[0])


def _distinct_rows(rows: FloatArray | IntArray) -> tuple[IntArray, IntArray]:
    """The first row of each kind, and the kind of each row; kinds in sorted order."""
    order = np.lexsort(rows.T[::-1])
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind


_ROUNDS = 1000  # a fan of flat faces along one edge is unfolded one a round


def is_degenerate(corners: FloatArray, tolerance: float) -> BoolArray:
    """(m,) whether the height over the longest side of triangles ``corners`` (m, 3, 3) is at most ``tolerance``."""
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(doubled <= tolerance * longest)


def flip_degenerate_faces(
    vertices: FloatArray, faces: IntArray, tolerance: float
) -> tuple[IntArray, IntArray, BoolArray]:
    """Flip flat faces away.

    Args:
        vertices: (n, 3).
        faces: (m, 3), at most two beside an edge, oriented alike.
        tolerance: Height below which a face is flat, in the unit of ``vertices``.

    Returns:
        (m, 3) faces; (m,) which of the old faces each lies in; (m,) those still flat: on the border, where they may
        simply go, or folded so that no flip helps.
    """
    faces, owner = faces.copy(), np.arange(len(faces))
    flat = is_degenerate(vertices[faces], tolerance)
    for _ in range(_ROUNDS if flat.any() else 0):
        face, behind, corners = _candidate_flips(vertices, faces, flat)
        first = corners[:, [0, 1, 3]]
        second = corners[:, [1, 2, 3]]
        helps = ~(is_degenerate(vertices[first], tolerance) | is_degenerate(vertices[second], tolerance))
        chosen = np.flatnonzero(helps)[_independent_flips(face[helps], behind[helps], corners[helps][:, [1, 3]])]
        if not len(chosen):
            break
        faces[behind[chosen]] = first[chosen]
        faces[face[chosen]] = second[chosen]
        owner[face[chosen]] = owner[behind[chosen]]
        flat[face[chosen]] = False
    return faces, owner, flat


def _candidate_flips(vertices: FloatArray, faces: IntArray, flat: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Flat faces that could be flipped, the faces behind their longest sides, and corners a, b, c, d of the two.

    Corner b lies on side c-a of the flat face, d is the far corner of the face behind.
    """
    touched = np.zeros(int(faces.max()) + 1, dtype=bool)
    touched[faces[flat]] = True
    near = np.flatnonzero(touched[faces].any(axis=1))  # all that meets a flat face, and nothing else
    local = faces[near]
    sides = Connectivity(local).twins
    sides = np.concatenate([sides, sides[:, ::-1]])
    lengths = np.linalg.norm(vertices[local] - vertices[local[:, [1, 2, 0]]], axis=2)
    longest = lengths.argmax(axis=1)[sides[:, 0] // 3] == sides[:, 0] % 3
    sides = sides[longest & flat[near[sides[:, 0] // 3]] & ~flat[near[sides[:, 1] // 3]]]
    corner = local.ravel()
    c, a, b = (corner[sides[:, 0] - sides[:, 0] % 3 + (sides[:, 0] + k) % 3] for k in range(3))
    d = corner[sides[:, 1] - sides[:, 1] % 3 + (sides[:, 1] + 2) % 3]
    base = int(faces.max()) + 1
    taken = np.unique(np.minimum(local, local[:, [1, 2, 0]]) * base + np.maximum(local, local[:, [1, 2, 0]]))
    free = (b != d) & ~np.isin(np.minimum(b, d) * base + np.maximum(b, d), taken)
    return near[sides[free, 0] // 3], near[sides[free, 1] // 3], np.stack([a, b, c, d], axis=1)[free]


def _independent_flips(face: IntArray, behind: IntArray, edge: IntArray) -> IntArray:
    """Numbers of flips that touch no face twice and make no edge twice, so that all may be done at once."""
    number = np.arange(len(face))
    claim = np.full(int(max(face.max(initial=0), behind.max(initial=0))) + 1, len(face))
    np.minimum.at(claim, face, number)
    np.minimum.at(claim, behind, number)
    alone = np.flatnonzero((claim[face] == number) & (claim[behind] == number))
    low = edge[alone].min(axis=1)
    high = edge[alone].max(axis=1)
    return alone[np.unique(low * (int(edge.max(initial=0)) + 1) + high, return_index=True)[1]]


SMALLEST = 1e-12
LARGEST = 1e12
"""Sizes and coordinates [m] beyond which products of lengths would leave the range of numbers."""
_REMEDY = "Export it again in metres"


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """A mesh fit to be flattened, and the way back.

    Attributes:
        mesh: Every edge has one or two faces that agree about the outside, every vertex one fan, every face area; in
            the coordinates and the order of the file.
        vertex_of: (k,) the file's vertex behind each vertex.
        face_of: (m,) the file's face in whose plane each face lies.
        component: (m,) the connected component of each face, numbered from zero.
        welded: (w, 2) vertices of the file, and those at the same place that stand for them now.
        dropped: Faces of the file, rising, that are there no more: lines, points and copies.
        turned: Faces of the file, rising, whose corners run the other way now.
        findings: Each kind of repair, with its count.
    """

    mesh: Mesh
    vertex_of: IntArray
    face_of: IntArray
    component: IntArray
    welded: IntArray
    dropped: IntArray
    turned: IntArray
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "vertex_of", "face_of", "component", "welded", "dropped", "turned", dtype=np.int64)


def repair_mesh(mesh: Mesh, *, where: str = "mesh") -> RepairedMesh:
    """Make ``mesh`` manifold, oriented and free of faces without area.

    Args:
        mesh: Any finite mesh, in any unit and at any offset.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left, or it is too large or too small for its areas to be numbers.

    Cost: about 5 µs a face, in however many components.
    """
    if not len(mesh.faces):
        raise _no_area_error(mesh, where)
    work = _Repair(mesh, where)
    work.weld()
    work.drop_duplicates()
    work.stitch()
    work.orient()
    work.split_nonmanifold()
    work.orient_outward()
    work.flip_degenerate_faces()
    return work.result()


class _Repair:
    """A repair under way: ``faces`` (m, 3) into unit-sized ``vertices``, which stand for the file's ``vertex_of``.

    ``face_of``, ``component`` and ``turned`` go with the faces: their numbers in the file, labels of connected
        components, and
    whether their corners run the other way now. ``closed`` (components,) says which have no border.
    """

    def __init__(self, mesh: Mesh, where: str) -> None:
        self._file = mesh
        self._where = where
        self._notes = list[Finding]()
        self.vertex_of, local = np.unique(mesh.faces, return_inverse=True)
        self.vertices, self.tolerance = _unit_sized(mesh, self.vertex_of, where)
        self.faces = local.reshape(-1, 3)
        self.face_of = np.arange(len(mesh.faces))
        self.component = np.zeros(len(mesh.faces), dtype=np.int64)
        self.turned = np.zeros(len(mesh.faces), dtype=bool)
        self.closed = np.zeros(1, dtype=bool)
        self.welded = np.zeros((0, 2), dtype=np.int64)

    def weld(self) -> None:
        same = weld_vertices(self.vertices, self.tolerance)
        away = np.flatnonzero(same != np.arange(len(same)))
        self.welded = self.vertex_of[np.stack([away, same[away]], axis=1)]
        self.faces = same[self.faces]
        self._tell("duplicate-vertex", "welded", len(away))

    def drop_duplicates(self) -> None:
        a, b, c = self.faces.T
        whole = np.flatnonzero((a != b) & (b != c) & (c != a))
        first = whole[unique_faces(self.faces[whole])]
        self._tell("zero-area-face", "removed: two corners coincide", len(self.faces) - len(whole))
        self._tell("duplicate-face", "dropped", len(whole) - len(first))
        self._keep(first)

    def stitch(self) -> None:
        self.faces, owner, count = stitch_junctions(self.vertices, self.faces)
        self.face_of = self.face_of[owner]
        self.component = self.component[owner]
        self.turned = self.turned[owner]
        self._tell("t-junction", "stitched: vertices inside an edge were inserted into it", count)
        count, widest = open_cracks(self.vertices, self.faces)
        extent = float(np.linalg.norm(np.ptp(self._file.vertices[self.vertex_of], axis=0)))
        self._tell(
            "open-crack",
            f"left open: borders that continue each other up to {1e3 * extent * widest:.2g} mm apart; if they should "
            "be connected, merge their vertices, or export with more digits",
            count,
        )

    def orient(self) -> None:
        oriented = orient_faces(self.faces, self._mesh().face_areas)
        self.faces = flip_faces(self.faces, oriented.turned)
        self.component = oriented.component
        self.turned = oriented.turned
        self._tell("one-sided", "cut at edges where its two sides meet", oriented.clashes)

    def split_nonmanifold(self) -> None:
        table = Connectivity(self.faces)
        twins = manifold_twins(self.faces, self.component)
        apart = (table.face_count > 1)[table.edge_of.ravel()]
        apart[twins.ravel()] = False
        ends = np.unique(table.edges[table.edge_of.ravel()[apart]])
        fans = np.bincount(self._split(twins), minlength=len(self.vertices))
        fans[ends] = 1  # those came apart with their edge
        held = np.bincount(self.component[twins[:, 0] // 3], minlength=int(self.component.max()) + 1)
        self.closed = 2 * held == 3 * np.bincount(self.component)
        crowded = int((table.face_count > 2).sum())
        self._tell("non-manifold-edge", "split: non-manifold edge with more than two faces", crowded)
        self._tell(
            "non-manifold-vertex", "split: non-manifold vertex with several fans of faces", int((fans > 1).sum())
        )

    def orient_outward(self) -> None:
        mesh = self._mesh()
        area = np.bincount(self.component, mesh.face_areas)
        kept = np.bincount(self.component, np.where(self.turned, 0.0, mesh.face_areas)) / np.where(area > 0, area, 1.0)
        inverted = inside_out(mesh, self.component, self.closed, kept)[self.component]
        self.faces = flip_faces(self.faces, inverted)
        self.turned = self.turned ^ inverted
        self._tell("turned-face", "reoriented consistently", int(self.turned.sum()))

    def flip_degenerate_faces(self) -> None:
        self.faces, owner, flat = flip_degenerate_faces(self.vertices, self.faces, self.tolerance)
        self._tell(
            "flat-face",
            "removed by an edge flip: the face behind it was split",
            int((owner != np.arange(len(owner))).sum()),
        )
        self._tell("flat-face", "dropped", int(flat.sum()))
        self.face_of = self.face_of[owner]
        self.turned = self.turned[owner]
        if flat.any():
            self._keep(np.flatnonzero(~flat))
            twins = manifold_twins(self.faces, self.component)
            self._split(twins)
            self.component = components_of(twins, len(self.faces))

    def result(self) -> RepairedMesh:
        return RepairedMesh(
            mesh=Mesh(self._file.vertices[self.vertex_of], self.faces),
            vertex_of=self.vertex_of,
            face_of=self.face_of,
            component=self.component,
            welded=self.welded,
            dropped=np.setdiff1d(np.arange(len(self._file.faces)), self.face_of),
            turned=np.unique(self.face_of[self.turned]),
            findings=tuple(self._notes),
        )

    def _mesh(self) -> Mesh:
        return Mesh(self.vertices, self.faces)

    def _keep(self, numbers: IntArray) -> None:
        """Keep the faces with these numbers only."""
        if not len(numbers):
            raise _no_area_error(self._file, self._where)
        self.faces = self.faces[numbers]
        self.face_of = self.face_of[numbers]
        self.component = self.component[numbers]
        self.turned = self.turned[numbers]

    def _split(self, twins: IntArray) -> IntArray:
        """Give each fan its own vertices; returns which of the vertices before each is a copy of."""
        self.faces, copy_of = split_nonmanifold(self.faces, twins)
        self.vertices = self.vertices[copy_of]
        self.vertex_of = self.vertex_of[copy_of]
        return copy_of

    def _tell(self, kind: str, action: str, count: int) -> None:
        if count:
            self._notes.append(Finding(kind, self._where, action, count))


def _unit_sized(mesh: Mesh, used: IntArray, where: str) -> tuple[FloatArray, float]:
    """The ``used`` vertices centred and divided by their extent, and the distance at which two of them are one."""
    vertices = mesh.vertices[used]
    largest = float(np.abs(vertices).max())
    if largest > LARGEST:
        raise MeshError("the mesh is implausibly large", file=where, value=f"{largest:.3g} m", remedy=_REMEDY)
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if extent == 0:
        raise _no_area_error(mesh, where)
    if extent < SMALLEST:
        raise MeshError("the mesh is implausibly small", file=where, value=f"{extent:.3g} m", remedy=_REMEDY)
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return (vertices - middle) / extent, weld_tolerance(vertices) / extent


CLEAR_MAJORITY = 0.75
"""An open component keeps its side if this share of its area agrees on it; else it is turned from its middle."""


def inside_out(mesh: Mesh, component: IntArray, closed: BoolArray, kept: FloatArray) -> BoolArray:
    """(components,) whether each must be turned as a whole to look outward.

    A closed component is judged by the sign of its volume. An open one keeps the file's side if that was clear, and
    otherwise looks away from its own middle.

    Args:
        mesh: Faces of a component agree.
        component: (m,) labels.
        closed: (components,) without boundary.
        kept: (components,) share of the area that looks to the side it had in the file.
    """
    corners = mesh.vertices[mesh.faces]
    area = np.bincount(component, mesh.face_areas)
    weighted = corners.mean(axis=1) * mesh.face_areas[:, None]
    middle = (
        np.stack([np.bincount(component, weighted[:, k]) for k in range(3)], axis=1) / np.where(area, area, 1)[:, None]
    )
    a, b, c = (corners[:, k] - middle[component] for k in range(3))
    volume = np.bincount(component, (a * np.cross(b, c)).sum(axis=1))
    return np.asarray((volume < 0) & (closed | (kept < CLEAR_MAJORITY)))
