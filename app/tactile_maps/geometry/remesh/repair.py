"""Mesh repair: cleaning for native code, and repair for flattening.

``clean_mesh`` welds equal vertices and drops empty, zero-area and duplicate faces. This is enough for queries on a
surface (a wrap, rays, closest points).

``repair_mesh`` makes any mesh suitable for flattening. Every change is reported and traceable to the vertices and faces
of the file. The triangles do not move; only their numbering changes. The steps: weld vertices at one position; drop
faces that are a line, a point or a duplicate; divide faces at vertices of their neighbours inside their edges
(``stitch``); orient neighbours consistently; separate non-manifold parts; orient whole components outward; flip
degenerate faces away.

``flip_degenerate_faces`` removes faces without area from a surface without opening a slit. A face with three collinear
corners has its middle corner on its longest side. Flipping that edge splits the face on its other side at the middle
corner: the same points, no face without area, no hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, MeshError
from tactile_maps.geometry.remesh.stitch import open_cracks, stitch_junctions
from tactile_maps.geometry.surface.connectivity import (
    Connectivity,
    components_of,
    connected_labels,
    flip_faces,
    manifold_twins,
    orient_faces,
    remove_unreferenced,
    run_starts,
    split_nonmanifold,
)
from tactile_maps.geometry.surface.mesh import Mesh

RELATIVE_WELD = 1e-7
"""Distance, as a share of the mesh's size, below which vertices are welded; float32 files round at about this level."""
_ROUNDING = 4 * np.finfo(np.float64).eps


def clean_mesh(mesh: Mesh, *, where: str = "mesh") -> tuple[Mesh, tuple[Finding, ...]]:
    """Weld equal vertices, drop faces without area and duplicate faces, and drop unused vertices.

    This is enough for queries on a surface (a wrap, rays, closest points); flattening requires ``repair_mesh``.

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
    value = f"{len(mesh.faces)} faces"
    remedy = "Export it again with triangles"
    return MeshError("the mesh has no face with an area", file=where, value=value, remedy=remedy)


def weld_tolerance(vertices: FloatArray) -> float:
    """Return the distance [m] below which two of ``vertices`` (n, 3) are welded, never below the rounding error."""
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    return max(RELATIVE_WELD * extent, _ROUNDING * float(np.abs(vertices).max()))


def weld_vertices(vertices: FloatArray, tolerance: float) -> IntArray:
    """Return the first of the vertices welded with each (n,), for vertices (n, 3) and ``tolerance`` > 0."""
    # A fine grid first, so that the search tree has few points even if a file repeats each of them many times.
    # Centred, so that a large offset does not consume the digits.
    cell = tolerance / 4
    first, kind = _distinct_rows(np.rint((vertices - vertices.mean(axis=0)) / cell))
    reach = tolerance + 2 * np.sqrt(3) * cell  # each vertex is up to a cell diagonal from the first of its cell
    pairs = cKDTree(vertices[first]).query_pairs(reach, output_type="ndarray")
    if len(pairs):
        group = connected_labels(pairs, len(first))
        lowest = np.full(int(group.max()) + 1, len(vertices))
        np.minimum.at(lowest, group, first)
        first = lowest[group]
    return np.asarray(first[kind], dtype=np.int64)


def unique_faces(faces: IntArray) -> IntArray:
    """Return the numbers, rising, of the first face on each set of three corners, regardless of orientation."""
    return np.sort(_distinct_rows(np.sort(faces, axis=1))[0])


def _distinct_rows(rows: FloatArray | IntArray) -> tuple[IntArray, IntArray]:
    """Return the first row of each kind and the kind of each row; kinds are in sorted order."""
    order = np.lexsort(rows.T[::-1])
    new = run_starts(*rows[order].T)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind


_ROUNDS = 1000  # a fan of flat faces along one edge loses one face a round


def is_degenerate(corners: FloatArray, tolerance: float) -> BoolArray:
    """Return whether the height over the longest side of triangles (m, 3, 3) is at most ``tolerance``."""
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(doubled <= tolerance * longest)


def flip_degenerate_faces(
    vertices: FloatArray, faces: IntArray, tolerance: float
) -> tuple[IntArray, IntArray, BoolArray]:
    """Remove flat faces by edge flips.

    Args:
        vertices: (n, 3).
        faces: (m, 3), at most two at an edge, consistently oriented.
        tolerance: Height below which a face is flat, in the unit of ``vertices``.

    Returns:
        (m, 3) faces; (m,) the old face that contains each; (m,) mask of faces that are still flat: on the border, where
        they can be dropped, or folded so that no flip helps.
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
    """Return flat faces that could be flipped, the faces across their longest sides, and corners a, b, c, d of the two.

    Corner b is on side c-a of the flat face, d is the far corner of the other face.
    """
    touched = np.zeros(int(faces.max()) + 1, dtype=bool)
    touched[faces[flat]] = True
    near = np.flatnonzero(touched[faces].any(axis=1))  # all faces at the vertices of flat ones
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
    """Return the numbers of flips that share no face and create no edge twice, so that all can be applied at once."""
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
"""Sizes and coordinates [m] beyond which products of lengths overflow or underflow."""
_REMEDY = "Export it again in metres"


@dataclass(frozen=True, eq=False)
class RepairedMesh(ArrayFields):
    """Repaired mesh with its relation to the file.

    Attributes:
        mesh: Manifold, consistently oriented, without faces of zero area; in the coordinates and the order of the file.
        vertex_of: (k,) vertex of the file of each vertex.
        face_of: (m,) face of the file that contains each face.
        component: (m,) component label of each face, from zero.
        welded: (w, 2) removed vertices of the file, and the vertices that replace them.
        dropped: Removed faces of the file, rising: lines, points and duplicates.
        turned: Faces of the file, rising, whose orientation was reversed.
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


def repair_mesh(mesh: Mesh, *, where: str = "mesh") -> RepairedMesh:
    """Make ``mesh`` manifold, oriented and free of faces without area.

    Args:
        mesh: Any finite mesh, in any unit and at any offset.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left, or the mesh is too large or too small for its areas to be computed.

    Cost: about 5 µs a face for any number of components.
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
    """Repair in progress: ``faces`` (m, 3) over unit-sized ``vertices`` of the file's vertices ``vertex_of``.

    Per face: ``face_of`` is its number in the file, ``component`` a component label, and ``turned`` whether its
    orientation was reversed. ``closed`` (components,) marks components without a border.
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
        self._note("duplicate-vertex", "welded", len(away))

    def drop_duplicates(self) -> None:
        a, b, c = self.faces.T
        whole = np.flatnonzero((a != b) & (b != c) & (c != a))
        first = whole[unique_faces(self.faces[whole])]
        self._note("zero-area-face", "removed: two corners coincide", len(self.faces) - len(whole))
        self._note("duplicate-face", "dropped", len(whole) - len(first))
        self._keep(first)

    def stitch(self) -> None:
        self.faces, owner, count = stitch_junctions(self.vertices, self.faces)
        self.face_of = self.face_of[owner]
        self.component = self.component[owner]
        self.turned = self.turned[owner]
        self._note("t-junction", "stitched: vertices inside an edge were inserted into it", count)
        count, widest = open_cracks(self.vertices, self.faces)
        extent = float(np.linalg.norm(np.ptp(self._file.vertices[self.vertex_of], axis=0)))
        self._note(
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
        self._note("one-sided", "cut at edges where its two sides meet", oriented.clashes)

    def split_nonmanifold(self) -> None:
        table = Connectivity(self.faces)
        twins = manifold_twins(self.faces, self.component)
        apart = (table.face_count > 1)[table.edge_of.ravel()]
        apart[twins.ravel()] = False
        ends = np.unique(table.edges[table.edge_of.ravel()[apart]])
        fans = np.bincount(self._split(twins), minlength=len(self.vertices))
        fans[ends] = 1  # these were separated with their edge
        held = np.bincount(self.component[twins[:, 0] // 3], minlength=int(self.component.max()) + 1)
        self.closed = 2 * held == 3 * np.bincount(self.component)
        crowded = int((table.face_count > 2).sum())
        self._note("non-manifold-edge", "split: non-manifold edge with more than two faces", crowded)
        self._note(
            "non-manifold-vertex", "split: non-manifold vertex with several fans of faces", int((fans > 1).sum())
        )

    def orient_outward(self) -> None:
        mesh = self._mesh()
        area = np.bincount(self.component, mesh.face_areas)
        kept = np.bincount(self.component, np.where(self.turned, 0.0, mesh.face_areas)) / np.where(area > 0, area, 1.0)
        inverted = inside_out(mesh, self.component, self.closed, kept)[self.component]
        self.faces = flip_faces(self.faces, inverted)
        self.turned = self.turned ^ inverted
        self._note("turned-face", "reoriented consistently", int(self.turned.sum()))

    def flip_degenerate_faces(self) -> None:
        self.faces, owner, flat = flip_degenerate_faces(self.vertices, self.faces, self.tolerance)
        self._note(
            "flat-face",
            "removed by an edge flip: the face behind it was split",
            int((owner != np.arange(len(owner))).sum()),
        )
        self._note("flat-face", "dropped", int(flat.sum()))
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
        """Keep only the faces with these numbers."""
        if not len(numbers):
            raise _no_area_error(self._file, self._where)
        self.faces = self.faces[numbers]
        self.face_of = self.face_of[numbers]
        self.component = self.component[numbers]
        self.turned = self.turned[numbers]

    def _split(self, twins: IntArray) -> IntArray:
        """Give each fan its own vertices; return the previous vertex of each."""
        self.faces, copy_of = split_nonmanifold(self.faces, twins)
        self.vertices = self.vertices[copy_of]
        self.vertex_of = self.vertex_of[copy_of]
        return copy_of

    def _note(self, kind: str, action: str, count: int) -> None:
        if count:
            self._notes.append(Finding(kind, self._where, action, count))


def _unit_sized(mesh: Mesh, used: IntArray, where: str) -> tuple[FloatArray, float]:
    """Return the ``used`` vertices centred and divided by their extent, and the welding distance in that unit."""
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
"""Share of the area that must agree for an open component to keep its orientation; else it faces away from its
centre."""


def inside_out(mesh: Mesh, component: IntArray, closed: BoolArray, kept: FloatArray) -> BoolArray:
    """Return whether each component (components,) must be turned as a whole to face outward.

    A closed component is judged by the sign of its volume. An open one keeps the orientation of the file if that was
    clear, and otherwise faces away from its own centre.

    Args:
        mesh: Faces of a component agree.
        component: (m,) labels.
        closed: (components,) without boundary.
        kept: (components,) share of the area with the orientation of the file.
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
