"""Convex pieces with which a link collides where its convex hull would span hollows of its skin.

The surface that can be touched is the skin and, where the link is bare, a wrap of its mesh. Its faces are gathered into
regions that are convex to within a tolerance; the hull of a region and of its copy a little below the surface is one
piece. The pieces therefore follow the sensitive surface even if the mesh below it is open or has holes.

Decision: regions of the surface instead of a decomposition of the solid. CoACD (1.0.14) needs a closed solid and cuts
it by planes. For a bowl of 100 mm it took 29 s for 155 pieces that protrude by at most 0.46 mm, and minutes for a
saddle.
"""

from __future__ import annotations

import platform
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import blake2b
from importlib.metadata import version
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.disk_cache import read_entry, store_entry
from tactile_maps.core.errors import Finding, MeshError, SkinError
from tactile_maps.core.files import MAX_UNPACKED_BYTES, cache_folder, pack_arrays, read_bounded_file, unpack_arrays
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.geometry.surface.points import sums_by_label
from tactile_maps.geometry.surface.raycast import RayCaster, ray_caster
from tactile_maps.robots.model.mujoco_spec import OWN_NAMES
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.link_hulls import add_convex, carries_mesh, corners_with_faces, hull_points
from tactile_maps.skin.model.skin import Skin

PIECES_SUFFIX = ".pieces"
"""Ending of the files in which pieces are kept."""
PROUD = 1e-3
PROUD_SHARE = 0.01
"""Distances of the hull from the skin that are accepted: this many metres, or this share of the link's size."""
PROUD_AREA = 0.02
"""Share of the skin's area above which a larger distance is not accepted."""
BARE_AREA = 0.10
BARE_NEAR = 0.02
"""Bare area within ``BARE_NEAR`` [m] of the skin, over that of the skin, above which it is not accepted."""
_NOTED = 0.01
"""Share of the skin's area above which a shape that is too high is reported; a hull is where pieces would be lower."""
_TOLERANCE = 3e-4
_TOLERANCE_SHARE = 0.003
"""Distance of a piece from the surface that is accepted [m], or as a share of the link's size; the larger counts."""
_BARE = 4.0
"""Tolerance where a link is bare whose mesh is wrapped, over that of its skin."""
_BARE_EDGE = 0.04
"""Length of edges of a bare surface that is not wrapped, over the size of the link."""
PIECE_DEPTH = 0.010
"""Thickness of pieces [m], at most half of the wall."""
_THINNEST = 2e-4
_SAMPLES = 300
"""Faces near a piece at which its height is measured while it grows."""
_GAP = 1e-3
"""Distance between the skin's border and what is bare [m]; a wrap is not exact at edges."""
_COVERED = 0.010
"""Distance below the skin [m] up to which the link's mesh is under it."""
_STEEPEST = 0.3
"""Cosine between the normals of a region's first face and of any other."""


@dataclass(frozen=True, eq=False)
class LinkPieces:
    """The convex pieces of one link.

    Attributes:
        surface: Touchable surface in the link's frame, faces oriented outward.
        piece: (m,) the piece of each face; negative for faces too small for one.
        skinned: Number of faces with skin; they come first.
        hulls: (k, 3) vertices of each piece [m].
    """

    surface: Mesh
    piece: IntArray
    skinned: int
    hulls: tuple[FloatArray, ...]


_PIECE = f"{OWN_NAMES}piece "
"""Prefix of the names of pieces."""


def piece_name(link: str, number: int) -> str:
    """Return the name of a piece of a link: its geom and its mesh."""
    return f"{_PIECE}{number} {link}"


def piece_number(name: str) -> int | None:
    """Return the number of a piece in its link from the name of its geom or mesh; None for other names."""
    return int(name.removeprefix(_PIECE).split(" ", 1)[0]) if name.startswith(_PIECE) else None


def piece_link(name: str) -> str:
    """Return the link's name from the name of a piece, and any other name unchanged."""
    return name.removeprefix(_PIECE).split(" ", 1)[1] if name.startswith(_PIECE) else name


def add_pieces(spec: mujoco.MjSpec, pieces: LinkPieces, link: str) -> list[mujoco.MjsGeom]:
    """Add the pieces of a link to its body, without weight; nothing collides with them yet."""
    return [add_convex(spec, link, piece_name(link, number), hull) for number, hull in enumerate(pieces.hulls)]


@dataclass(frozen=True)
class HullFit:
    """Protrusion of a shape beyond a link's skin, along the skin's normals.

    Attributes:
        largest: Largest protrusion [m].
        usual: 95th percentile over the skin's area [m].
        angle: 95th percentile of the angle between the normals of shape and skin [rad].
        share: Share of the skin's area where the protrusion exceeds the limit for a hull.
        bare: Largest distance along the normals of the link's mesh within ``BARE_NEAR`` of the skin [m].
        bare_share: Area of that mesh where the protrusion exceeds the limit, over the skin's area.
        noted: Area of skin and mesh where the protrusion is large enough to be reported, over the skin's area.
    """

    largest: float
    usual: float
    angle: float
    share: float
    bare: float
    bare_share: float
    noted: float


_MADE: dict[str, LinkPieces] = {}
"""The latest pieces by digest, where no cache folder is used."""
_MOST_MADE = 64
_MOST_KEPT = 200_000_000
"""Size of all pieces in the cache folder [bytes]; those longest unused are removed first."""


@weak_cache
def link_pieces(robot: Robot, skin: Skin, link: str) -> LinkPieces | None:
    """Return the pieces of a link with skin; None where its hull follows the skin.

    Pieces are kept on disk next to prepared scenes (see ``cache_folder``).

    Cost: 0.1 to 0.5 s where the hull does; else 1 s for 4,000 faces and 6 s for 17,000, or 20 ms where they are kept.
    """
    if not spans_hollows(robot, skin, link):
        return None
    digest = _digest(robot, skin, link)
    folder = cache_folder()
    if folder is None:
        if digest not in _MADE:
            while len(_MADE) >= _MOST_MADE:
                del _MADE[next(iter(_MADE))]
            _MADE[digest] = _divided(robot, skin, link)
        return _MADE[digest]
    path = folder / f"{digest}{PIECES_SUFFIX}"
    pieces = read_entry(path, lambda: _from_bytes(read_bounded_file(path, error=SkinError, most=MAX_UNPACKED_BYTES)))
    if pieces is None:
        pieces = _divided(robot, skin, link)
        store_entry(path, lambda: _to_bytes(pieces), suffixes=(PIECES_SUFFIX,), most=_MOST_KEPT)
    return pieces


def _digest(robot: Robot, skin: Skin, link: str) -> str:
    """Return a digest of all that the pieces of a link depend on, the program that makes them included."""
    digest = blake2b(_program(), digest_size=16)
    mesh = robot.link(link).mesh if carries_mesh(robot, skin, link) else None
    surfaces = [patch.surface for patch in skin.patches if patch.link == link]
    for surface in surfaces if mesh is None else [*surfaces, mesh]:
        digest.update(np.array([len(surface.vertices), len(surface.faces)]).tobytes())
        digest.update(np.ascontiguousarray(surface.vertices).tobytes())
        digest.update(np.ascontiguousarray(surface.faces).tobytes())
    return digest.hexdigest()


@cache
def _program() -> bytes:
    root = Path(__file__).parents[1]
    own = Path(__file__)
    sources = [own, own.with_name("link_hulls.py"), *sorted((root / "geometry").rglob("*.py"))]
    versions = (sys.version, platform.machine(), *map(version, ("numpy", "scipy", "libigl")))
    return blake2b(b"".join([*(word.encode() for word in versions), *map(Path.read_bytes, sources)])).digest()


def _to_bytes(pieces: LinkPieces) -> bytes:
    counts = np.array([len(hull) for hull in pieces.hulls])
    arrays = {"vertices": pieces.surface.vertices, "faces": pieces.surface.faces, "piece": pieces.piece}
    return pack_arrays({"skinned": pieces.skinned}, {**arrays, "hulls": np.concatenate(pieces.hulls), "counts": counts})


def _from_bytes(data: bytes) -> LinkPieces:
    header, arrays = unpack_arrays(data, error=SkinError)
    surface = Mesh(arrays["vertices"], arrays["faces"])
    hulls = np.split(arrays["hulls"], np.cumsum(arrays["counts"])[:-1])
    if arrays["piece"].shape != (len(surface.faces),):
        raise SkinError("the pieces are not those of the faces", value=arrays["piece"].shape)
    return LinkPieces(surface, arrays["piece"], int(header["skinned"]), tuple(hulls))


def _divided(robot: Robot, skin: Skin, link: str) -> LinkPieces:
    surface, walls, factor = _touchable(robot, skin, link)
    skinned = sum(len(patch.surface.faces) for patch in skin.patches if patch.link == link)
    size = float(np.ptp(surface.vertices, axis=0).max())
    tolerance = _tolerance(size)
    piece, hulls = _Regions(surface, walls, skinned, tolerance, factor * tolerance).divide()
    return LinkPieces(surface, piece, skinned, tuple(map(corners_with_faces, hulls)))


def _tolerance(size: float) -> float:
    """Return the distance of pieces from the skin that is accepted on a link of this size [m]."""
    return max(_TOLERANCE, _TOLERANCE_SHARE * size)


def spans_hollows(robot: Robot, skin: Skin, link: str) -> bool:
    """Return whether the hull of a link protrudes beyond more of its skin, or of the mesh next to it, than is accepted.

    The mesh next to the skin is lower than the hull where the skin is raised above the link.
    """
    fit = hull_fit(robot, skin, link)
    return fit.share > PROUD_AREA or fit.bare_share > BARE_AREA


@weak_cache
def hull_fit(robot: Robot, skin: Skin, link: str) -> HullFit:
    """Return how far the convex hull of a link and its skin protrudes beyond the skin and the mesh next to it."""
    points = hull_points(robot, skin, link)
    size = float(np.ptp(points, axis=0).max())
    return _fit((points,), robot, skin, link, max(PROUD, PROUD_SHARE * size), _tolerance(size))


def pieces_fit(pieces: LinkPieces, robot: Robot, skin: Skin, link: str) -> HullFit:
    """Return how far the pieces of a link protrude beyond its skin and the mesh next to it."""
    return _fit(pieces.hulls, robot, skin, link, PROUD, PROUD)


def shape_finding(robot: Robot, skin: Skin, link: str) -> Finding | None:
    """Return the finding about the shape with which a link collides, see ``collision_finding``."""
    pieces = link_pieces(robot, skin, link)
    fit = hull_fit(robot, skin, link) if pieces is None else pieces_fit(pieces, robot, skin, link)
    return collision_finding(robot, link, fit, pieces)


def collision_finding(robot: Robot, link: str, fit: HullFit, pieces: LinkPieces | None) -> Finding | None:
    """Return the finding of a link whose shape is too far above what can be touched, or leaves parts of it out.

    Args:
        robot: The robot.
        link: The link.
        fit: Distances of its shape.
        pieces: The shape; None for the hull.
    """
    if pieces is not None and pieces.skinned == len(pieces.surface.faces) and robot.link(link).mesh is not None:
        return Finding("bare-part-open", link, "its bare parts touch nothing, because its mesh cannot be wrapped")
    if fit.noted <= _NOTED:
        return None
    shape = "convex hull" if pieces is None else "convex pieces"
    off, place = max((fit.largest, "its skin"), (fit.bare, "the bare link next to its skin"))
    return Finding("collision-shape", link, f"it collides as its {shape}, up to {1e3 * off:.1f} mm above {place}")


def _fit(
    hulls: tuple[FloatArray, ...], robot: Robot, skin: Skin, link: str, accepted: float, unnoted: float
) -> HullFit:
    covered = join_meshes([patch.surface for patch in skin.patches if patch.link == link])
    places, normals, areas = _sampled(covered, _MEASURED)
    height, facing = _heights(hulls, places, normals)
    angles = np.arccos(np.clip(facing, -1, 1))
    bare = np.zeros(0)
    bare_areas = np.zeros(0)
    mesh = robot.link(link).mesh if carries_mesh(robot, skin, link) else None
    if mesh is not None:
        places, normals, bare_areas = _bare_next_to(covered, mesh, link)
        bare, _ = _heights(hulls, places, normals)
    whole = float(areas.sum())
    return HullFit(
        largest=float(height.max()),
        usual=_percentile(height, areas),
        angle=_percentile(angles, areas),
        share=float(areas[height > accepted].sum()) / whole,
        bare=float(bare.max(initial=0.0)),
        bare_share=float(bare_areas[bare > accepted].sum()) / whole,
        noted=float(areas[height > unnoted].sum() + bare_areas[bare > unnoted].sum()) / whole,
    )


def _bare_next_to(covered: Mesh, mesh: Mesh, link: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middles (n, 3), outward normals (n, 3) and areas (n,) of bare faces of a link within ``BARE_NEAR`` of it.

    A mesh that is not one closed solid may have inner faces and faces that are turned inward. Of such a mesh, faces
    count whose normal meets no other face in one of both directions; that direction is outward.
    """
    solid = _solid(mesh, link)
    if solid is not None:
        return _sampled(_next_to_skin(solid, covered), _MEASURED // 4)
    try:
        clean, _ = clean_mesh(mesh, where=link)
    except MeshError:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    places, normals, areas = _sampled(_next_to_skin(clean, covered), _MEASURED // 4)
    front, back = (_leaves(clean, places, side * normals) for side in (1, -1))
    _, under, _ = _uncovered(places, covered, _COVERED)
    turned = back & (~front | (np.vecdot(normals, covered.face_normals[under]) < 0))  # of a sheet both sides are free
    free = front | back
    return places[free], np.where(turned[:, None], -normals, normals)[free], areas[free]


def _leaves(mesh: Mesh, places: FloatArray, directions: FloatArray) -> BoolArray:
    """Return whether each ray from a place (n, 3) on a mesh along a direction (n, 3) meets the mesh nowhere else."""
    rays = ray_caster(mesh)
    step = 1e-5 * mesh.size
    starts = zip(places + step * directions, directions, strict=True)
    return np.array([rays.first_hit(start, direction) is None for start, direction in starts], dtype=bool)


def _sampled(surface: Mesh, most: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middles (n, 3), normals (n, 3) and the area of every so many faces, at most ``most``."""
    every = max(-(-len(surface.faces) // most), 1)
    return surface.face_centres[::every], surface.face_normals[::every], every * surface.face_areas[::every]


def _heights(hulls: tuple[FloatArray, ...], places: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far hulls protrude beyond points (n, 3) along normals (n, 3) [m], and the cosine of both normals."""
    height = np.zeros(len(places))
    facing = np.ones(len(places))
    for hull in hulls if len(places) else ():
        facets = ConvexHull(hull).equations
        inside, leaves, facet = _leaving(facets, places, normals)
        higher = inside & (leaves >= height)
        height[higher] = leaves[higher]
        facing[higher] = np.vecdot(facets[facet[higher], :3], normals[higher])
    return height, facing


def _percentile(values: FloatArray, areas: FloatArray) -> float:
    """Return the value below which 95 % of the area is."""
    order = values.argsort(kind="stable")
    return float(values[order][np.searchsorted(areas[order].cumsum(), 0.95 * areas.sum())])


_MEASURED = 2000
"""Faces of a link's skin at which the distance of a shape is measured, at most; a quarter of it next to the skin."""
_INSIDE = 1e-6
"""Distance outside a hull [m] up to which a point counts as in it."""
_BLOCK = 65_536
"""Pairs of points and facets that fit in the processor's cache."""


def _leaving(facets: FloatArray, points: FloatArray, directions: FloatArray) -> tuple[BoolArray, FloatArray, IntArray]:
    """Return where lines from ``points`` (n, 3) along ``directions`` leave a convex hull.

    Returns:
        (n,) whether the point is in the hull, (n,) the distance to the exit [m], (n,) the facet of the exit.
    """
    inside = np.empty(len(points), dtype=bool)
    ways = np.empty(len(points))
    facet = np.empty(len(points), dtype=np.int64)
    step = max(_BLOCK // len(facets), 1)
    for start in range(0, len(points), step):
        part = slice(start, start + step)
        slopes = directions[part] @ facets[:, :3].T
        heights = points[part] @ facets[:, :3].T + facets[:, 3]
        exits = np.divide(-heights, slopes, out=np.full_like(slopes, np.inf), where=slopes > 1e-9)
        inside[part] = heights.max(axis=1) <= _INSIDE
        facet[part] = exits.argmin(axis=1)
        ways[part] = exits.min(axis=1)
    return inside, ways, facet


def _touchable(robot: Robot, skin: Skin, link: str) -> tuple[Mesh, FloatArray, float]:
    """Return the skin of a link and what is bare of the link's mesh, in one mesh that is not connected between them.

    Below hollow skin the link is wrapped. Below skin that is raised above a solid link the bare part is exact.

    Returns:
        The mesh, (m,) the wall below each face where the mesh itself does not show it, else infinite [m], and the
        tolerance of its bare part over that of its skin.
    """
    parts = [patch.surface for patch in skin.patches if patch.link == link]
    covered = join_meshes(parts)
    mesh = robot.link(link).mesh
    walls = [np.full(len(covered.faces), np.inf)]
    factor = 1.0
    if mesh is not None and carries_mesh(robot, skin, link):
        solid = _solid(mesh, link) if hull_fit(robot, skin, link).share <= PROUD_AREA else None
        if solid is not None:  # the skin is raised, not hollow
            parts.append(_bare_of_solid(solid, covered))
            walls.append(np.full(len(parts[-1].faces), np.inf))
        else:
            with suppress(MeshError):  # nothing of it can be wrapped; the skin alone collides
                bare, below = _bare_of_wrap(mesh, covered, link)
                parts.append(bare)
                walls.append(below)
                factor = _BARE
    return join_meshes(parts), np.concatenate(walls), factor


def _solid(mesh: Mesh, link: str) -> Mesh | None:
    """Return the mesh of a link, cleaned and turned outward, where it is one closed solid; None for any other."""
    try:
        clean, _ = clean_mesh(mesh, where=link)
    except MeshError:
        return None
    if not clean.connectivity.is_closed_manifold or clean.connectivity.components.max() > 0:
        return None
    volume = np.linalg.det(clean.corners).sum()
    return clean if volume >= 0 else Mesh(clean.vertices, clean.faces[:, ::-1])


def _next_to_skin(mesh: Mesh, covered: Mesh) -> Mesh:
    """Return the faces of a mesh whose middles are bare and within ``BARE_NEAR`` of the skin."""
    fine = subdivide(mesh, longest=_BARE_EDGE * mesh.size).mesh
    centres = fine.face_centres
    bare, _, distances = _uncovered(centres, covered, _COVERED)
    return Mesh(fine.vertices, fine.faces[bare & (distances <= BARE_NEAR)])


def _bare_of_solid(solid: Mesh, covered: Mesh) -> Mesh:
    """Return the faces of a solid that are not under the skin, those across its border included."""
    fine = subdivide(solid, longest=_BARE_EDGE * solid.size).mesh
    bare, under, _ = _uncovered(fine.face_centres, covered, _COVERED)
    bare |= _uncovered(fine.vertices, covered, _COVERED)[0][fine.faces].any(axis=1)
    bare |= np.vecdot(fine.face_normals, covered.face_normals[under]) < 0  # the other side of a wall
    return Mesh(fine.vertices, fine.faces[bare])


def _bare_of_wrap(mesh: Mesh, covered: Mesh, link: str) -> tuple[Mesh, FloatArray]:
    """Return the part of a wrap of ``mesh`` that is not under the skin, and (m,) the wall below each of its faces [m].

    Both sides of a sheet without thickness are at the same place, so that walls are measured before the wrap is shrunk.
    """
    clean, _ = clean_mesh(mesh, where=link)
    step = max(2e-3, 0.015 * clean.size)
    wide = wrap_mesh(clean, thickness=step, voxel=2 * step, where=link).surface
    wrap = Mesh(wide.vertices - step * wide.vertex_normals, wide.faces)
    bare, under, _ = _uncovered(wrap.face_centres, covered, max(_COVERED, 2 * step))
    bare |= np.vecdot(wrap.face_normals, covered.face_normals[under]) < 0  # the other side of a wall
    return Mesh(wrap.vertices, wrap.faces[bare]), np.maximum(_walls(wide) - 2 * step, 0.0)[bare]


def _uncovered(points: FloatArray, covered: Mesh, deepest: float) -> tuple[BoolArray, IntArray, FloatArray]:
    """Return whether each of the points (n, 3) of a link is bare, the skin's face closest to it, and its distance [m].

    Bare are points whose closest place on the skin is on its border, and those ``deepest`` [m] away.
    """
    faces, weights, distances = ClosestPoint(covered).query(points)
    border = np.zeros(len(covered.vertices), dtype=bool)
    border[covered.connectivity.boundary_edges] = True
    at_border = (border[covered.faces[faces]] & (weights > 1e-6)).sum(axis=1) == (weights > 1e-6).sum(axis=1)
    return (at_border & (distances > _GAP)) | (distances > deepest), faces, distances


def _volume(points: FloatArray) -> float:
    """Return the volume of a convex hull [m³]; 0 of points in a plane."""
    try:
        return float(ConvexHull(points).volume)
    except QhullError:
        return 0.0


_OPEN = -1
_NO_PIECE = -2
"""Marks of faces that are in no region yet, and of those too small for a piece."""
_SMALLEST = 1e-13
"""Smallest volume of a piece [m³]."""


class _Regions:
    """Divides the faces of a surface into regions that are convex to within a tolerance.

    Args:
        surface: Its faces look outward.
        walls: (m,) bounds of the wall below each face [m].
        skinned: Number of faces with skin; they come first.
        tolerance: Height of a piece above the skin that is accepted [m].
        bare_tolerance: Height above the other faces that is accepted [m].
    """

    def __init__(self, surface: Mesh, walls: FloatArray, skinned: int, tolerance: float, bare_tolerance: float) -> None:
        self._surface = surface
        self._skinned = skinned
        self._normals = surface.face_normals
        self._corners = surface.corners
        self._centres = self._corners.mean(axis=1)
        self._columns = np.ascontiguousarray(self._centres.T)
        self._accepted = np.full(len(surface.faces), tolerance)
        self._accepted[skinned:] = bare_tolerance
        self._neighbours: list[list[int]] = [[] for _ in surface.faces]
        for one, other in surface.connectivity.face_pairs.tolist():
            self._neighbours[one].append(other)
            self._neighbours[other].append(one)
        self._depths = np.clip(0.5 * np.minimum(_walls(surface), walls), _THINNEST, PIECE_DEPTH)

    def divide(self) -> tuple[IntArray, tuple[FloatArray, ...]]:
        """Return the region of each face, and the vertices of each region's piece."""
        region = np.where(self._surface.face_areas > 0, _OPEN, _NO_PIECE)
        hulls: list[FloatArray] = []
        for seed in range(len(region)):
            if region[seed] == _OPEN:
                faces = self._grown(seed, region)
                hull = self._thinned(np.array(faces))
                solid = _volume(hull) > _SMALLEST
                region[faces] = len(hulls) if solid else _NO_PIECE
                hulls += [hull] * solid
        return region, tuple(hulls)

    def _grown(self, seed: int, region: IntArray) -> list[int]:
        """Return the faces of a region about ``seed``, added ring by ring."""
        inside = [seed]
        seen = {seed}
        added = inside
        while True:
            ring = {other for face in added for other in self._neighbours[face] if region[other] == _OPEN} - seen
            seen |= ring
            added = []
            waiting = [self._likely(inside, np.array(sorted(ring), dtype=np.int64))]
            smallest = max(len(ring) // 6, 1)
            while waiting:
                group = waiting.pop()
                if len(group) and self._fits(np.array(inside + added + group)):
                    added = added + group
                elif len(group) > smallest:
                    waiting += [group[len(group) // 2 :], group[: len(group) // 2]]
            if not added:
                return inside
            inside = inside + added

    def _likely(self, inside: list[int], ring: IntArray) -> list[int]:
        """Return the faces of a ring that do not rise far above the region, nor the region above them.

        The ends of an arc are four times as high above each other's tangents as their chord is above the arc.
        """
        if not len(ring):
            return []
        most = 4 * self._accepted[inside[0]]
        region = np.array(inside)
        # Matrix products: a ring and its region may be thousands of faces.
        rise = self._corners[ring].reshape(-1, 3) @ self._normals[region].T
        rise -= np.vecdot(self._centres[region], self._normals[region])
        back = self._corners[region].reshape(-1, 3) @ self._normals[ring].T
        back -= np.vecdot(self._centres[ring], self._normals[ring])
        likely = (rise.max(axis=1).reshape(-1, 3).max(axis=1) <= most) & (back.max(axis=0) <= most)
        likely &= self._normals[ring] @ self._normals[inside[0]] > _STEEPEST
        return ring[likely].tolist()

    def _fits(self, faces: IntArray) -> bool:
        """Return whether the piece of the faces protrudes from the surface by no more than is accepted."""
        return not self._comes_out(self._piece(faces, 1.0), int(faces[0]))

    def _thinned(self, faces: IntArray) -> FloatArray:
        """Return the vertices of a region's piece, thinner where it would come out on another side."""
        share = 1.0
        while True:
            hull = self._piece(faces, share)
            if share < _THINNEST / PIECE_DEPTH or not self._comes_out(hull, int(faces[0])):
                return hull
            share *= 0.5

    def _piece(self, faces: IntArray, share: float) -> FloatArray:
        """Return the corners of faces and, below them by a share of the wall's depth, their copies."""
        points, corner = np.unique(self._surface.faces[faces], return_inverse=True)
        vertices = self._surface.vertices[points]
        corner = corner.ravel()
        weighted = np.repeat(self._normals[faces] * self._surface.face_areas[faces][:, None], 3, axis=0)
        outward = sums_by_label(corner, weighted)
        outward = outward / np.linalg.norm(outward, axis=1, keepdims=True)
        depth = np.full(len(points), np.inf)
        np.minimum.at(depth, corner, np.repeat(self._depths[faces], 3))
        depth = np.maximum(share * depth, _THINNEST)
        return np.concatenate([vertices, vertices - depth[:, None] * outward])

    def _comes_out(self, hull: FloatArray, first: int) -> bool:
        """Return whether a piece whose first face is ``first`` protrudes too far beyond the surface."""
        near = self._within(hull.min(axis=0), hull.max(axis=0), self._skinned if first < self._skinned else None)
        try:
            facets = ConvexHull(hull).equations
        except QhullError:
            return True
        near = near[:: -(-len(near) // _SAMPLES) or 1]
        # In a convex hull, a place that is raised by what is accepted is still inside where the hull is higher.
        raised = self._centres[near] + self._accepted[near, None] * self._normals[near]
        near = near[(raised @ facets[:, :3].T + facets[:, 3]).max(axis=1) < 0]
        heights = self._centres[near] @ facets[:, :3].T + facets[:, 3]
        return bool((heights.max(axis=1) <= _INSIDE).any())

    def _within(self, low: FloatArray, high: FloatArray, count: int | None) -> IntArray:
        """Return the first faces, ``count`` or all, whose centres are in a box."""
        x, y, z = self._columns[:, :count]
        found = np.flatnonzero((x >= low[0]) & (x <= high[0]))
        found = found[(y[found] >= low[1]) & (y[found] <= high[1])]
        return found[(z[found] >= low[2]) & (z[found] <= high[2])]


def _walls(surface: Mesh) -> FloatArray:
    """Return (m,) the distance from each face inward to the next one [m]; infinite where there is none."""
    rays = RayCaster(surface)
    step = 1e-5 * surface.size
    centres = surface.face_centres
    walls = np.full(len(surface.faces), np.inf)
    for face, (centre, normal) in enumerate(zip(centres, surface.face_normals, strict=True)):
        if normal.any() and (hit := rays.first_hit(centre - step * normal, -normal)) is not None:
            walls[face] = hit.distance + step
    return walls
