"""Regular patterns of taxels on a surface: a hexagonal lattice, and triangular modules of ten.

Both grow by steps of a given length along the surface, with directions carried along by parallel transport.

Lattice: from each taxel, steps of one pitch in six directions find its neighbours, which continue in the transported
directions. On a developable surface the lattice is exact until its front meets itself; on others it has gaps, which
are filled. A few rounds of Lloyd relaxation then distribute the error.

Modules, as on the skins of iCub and CySkin: a module is a rigid triangle. Its pads form a fixed pattern in the tangent
plane at its middle, and are projected onto the surface. Modules are placed side by side as tiles. Where the tiling
meets itself or an obstacle, the remaining gaps are searched for places of further modules.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.skin.model.skin import TaxelIdentity, Taxels
from tactile_maps.skin.taxel_placement.sampling import (
    distinct_faces,
    face_graph,
    farthest_point_sampling,
    geodesic_voronoi,
    lloyd_relaxation,
    straighten_cells,
    taxels_at_barycentric,
)

_MAX_STEP_OFFSET = 0.2
"""Distance from the surface to the end of a step, as a share of its length, above which the step crosses the border."""
_MIN_STEP_FACING = 0.3
"""Cosine between the normals at both ends of a step, below which it passes through a thin wall."""


def step_along_surface(
    surface: Mesh,
    closest: ClosestPoint,
    points: FloatArray,
    faces: IntArray,
    steps: FloatArray,
    length: float | FloatArray,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Step ``length`` [m] from ``points`` (s, 3) in ``faces`` (s,) along unit tangents ``steps`` (s, 3).

    Returns:
        The ends (s, 3) on the surface, at about that straight distance; their faces (s,); and (s,) whether each is on
        the same side of the surface and within its border.
    """
    length = np.broadcast_to(length, len(points))[:, None]
    at, weights, _ = closest.query(points + length * steps)
    toward = surface.points(at, weights) - points
    gone = np.linalg.norm(toward, axis=1, keepdims=True)
    # On a curved surface a step in the tangent plane is too short; the second step corrects the length.
    at, weights, away = closest.query(points + length * toward / np.where(gone > 0, gone, 1.0))
    facing = (surface.face_normals[at] * surface.face_normals[faces]).sum(axis=1) > _MIN_STEP_FACING
    return (
        surface.points(at, weights),
        at,
        facing & (away < _MAX_STEP_OFFSET * length[:, 0]) & (gone[:, 0] > length[:, 0] / 2),
    )


def parallel_transport(directions: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return unit tangents (s, 3) rotated by the smallest rotation from the normals ``before`` to those ``after``.

    This is parallel transport for small steps; a projection onto the new plane would change the direction of a straight
    path.
    """
    lean = (directions * after).sum(axis=1) / (1 + (before * after).sum(axis=1))
    turned = directions - lean[:, None] * (before + after)
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)  # rounding adds up over thousands of steps


def tangent_directions(normals: FloatArray, turns: FloatArray) -> FloatArray:
    """Return unit directions (s, 3) perpendicular to ``normals`` (s, 3), at the angles ``turns`` (s,) [rad]."""
    first = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * np.cross(normals, first)


LATTICE_LLOYD_ROUNDS = 3
"""Rounds of Lloyd relaxation; more of them break the lattice into grains."""
_MERGE_DISTANCE = 0.75
"""Distance from the end of a step to a taxel, in pitches, below which both are the same taxel."""


def place_lattice(surface: Mesh, count: int, pitch: float, *, allowed: BoolArray, seed: int) -> Taxels:
    """Return exactly ``count`` taxels, as far as possible on a hexagonal lattice.

    Args:
        surface: Connected surface with edges shorter than half a pitch.
        count: Number of taxels.
        pitch: Pitch that fits the count [m].
        allowed: (m,) faces that may have taxels.
        seed: Seed for the start and the direction of the lattice.

    Cost: 0.6 s for 1000 taxels on 26,000 faces.
    """
    points, faces = grow_lattice(surface, pitch, np.random.default_rng(seed), allowed)
    kept = _thin_to_count(points[allowed[faces]], count)
    centres = surface.face_centres
    candidates = np.flatnonzero(allowed)
    starts = candidates[np.unique(cKDTree(centres[candidates]).query(kept)[1])]
    seeds = farthest_point_sampling(surface, count, starts, allowed=allowed)
    return lloyd_relaxation(surface, seeds, allowed=allowed, rounds=LATTICE_LLOYD_ROUNDS)


def grow_lattice(
    surface: Mesh, pitch: float, random: np.random.Generator, allowed: BoolArray
) -> tuple[FloatArray, IntArray]:
    """Return points (k, 3) of a lattice that grows from an allowed face over the whole surface, and their faces."""
    closest = ClosestPoint(surface)
    face = random.choice(np.flatnonzero(allowed))
    turn = random.uniform(0, np.pi / 3, 1)
    points = surface.face_centres[[face]]
    faces = np.array([face])
    front = np.zeros(1, dtype=np.int64)
    ahead = tangent_directions(surface.face_normals[[face]], turn)
    while len(front):
        steps = _hexagonal_directions(ahead, surface.face_normals[faces[front]])
        start = np.repeat(front, 6)
        ends, at, sound = step_along_surface(surface, closest, points[start], faces[start], steps, pitch)
        new = np.flatnonzero(sound)
        new = new[_apart_from_known(points, ends[new], _MERGE_DISTANCE * pitch)]
        front = len(points) + np.arange(len(new))
        points = np.concatenate([points, ends[new]])
        faces = np.concatenate([faces, at[new]])
        ahead = parallel_transport(steps[new], surface.face_normals[faces[start[new]]], surface.face_normals[at[new]])
    return points, faces


def _hexagonal_directions(ahead: FloatArray, normals: FloatArray) -> FloatArray:
    """Return (6 f, 3) six unit directions in each tangent plane, the first of them ``ahead`` (f, 3)."""
    side = np.cross(normals, ahead)
    turn = np.arange(6) * np.pi / 3
    return (np.cos(turn)[:, None] * ahead[:, None] + np.sin(turn)[:, None] * side[:, None]).reshape(-1, 3)


def _apart_from_known(known: FloatArray, found: FloatArray, apart: float) -> IntArray:
    """Return the indices of ``found`` (s, 3) at a distance of ``apart`` from ``known`` and from the ones before."""
    free = np.flatnonzero(cKDTree(known).query(found)[0] >= apart)
    pairs = cKDTree(found[free]).query_pairs(apart, output_type="ndarray")
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    taken = np.zeros(len(free), dtype=bool)
    for one, other in pairs.tolist():  # in ascending order: whether ``one`` stays is decided before
        taken[other] |= not taken[one]
    return free[~taken]


def _thin_to_count(points: FloatArray, count: int) -> FloatArray:
    """Return at most ``count`` of the points, without the ones closest to another."""
    while len(points) > count:
        closest = np.argsort(nearest_others(points, 1)[0][:, 0], kind="stable")
        points = np.delete(points, closest[: max(1, (len(points) - count) // 4)], axis=0)
    return points


MODULE_PADS = np.array([[2, 0], [3, -1], [1, -1], [0, 0], [-1, -1], [-3, -1], [-2, 0], [-1, 1], [0, 2], [1, 1]]) * (
    0.5,
    np.sqrt(3) / 2,
)
"""(10, 2) pads in pitches, in the order of iCub without its two thermal pads; the tip points along y."""
TILE_SIDE = 4.6
"""Side of a tile in pitches: 30 mm on iCub, whose pads are 6.5 mm apart."""
CELL_RADIUS = 1.0
"""Largest radius of the cell of a taxel, in pitches."""
BOARD_MARGIN = 0.38
"""Width of a board outside the triangle of its outer pads, in pitches; boards do not overlap."""
_MAX_PAD_SHIFT = 0.3
_MAX_PAD_DROP = 1.0
_MIN_PAD_FACING = 0.5
"""Bounds of the shifts of a pad along and across the plane, in pitches, and of the cosine between the normals."""
_MAX_OVERHANG = 0.05  # in pitches; less is due to curvature and rounding
_OUTER = MODULE_PADS[[8, 9, 0, 1, 2, 4, 5, 6, 7]]  # once around
_OUTLINE = np.concatenate([_OUTER, (_OUTER + np.roll(_OUTER, -1, axis=0)) / 2])
_OUTLINE_CLEARANCE = float(
    np.hypot(2 * BOARD_MARGIN, 0.25)
)  # between the points of outlines; a place between two of them is closer than both
_BOARD_CORNERS = _OUTER * (1 + BOARD_MARGIN / np.linalg.norm(_OUTER, axis=1, keepdims=True))
_STARTS = 3
_FIRST = 20
_TRIED = 200
_TURNS = 12
_BATCH = 60
_MAX_TOUCHING_DISTANCE = 2 * np.sqrt(3) + _OUTLINE_CLEARANCE  # boards whose middles are farther apart cannot touch
_STRETCH = 1.0, 1.05, 1.1
"""Distances at which a tile next to another is tried; on doubly curved surfaces the nearest one often does not fit."""


def place_modules(surface: Mesh, pitch: float, *, allowed: BoolArray, seed: int) -> Taxels:
    """Return as many modules as fit; taxels 10 k to 10 k + 9 are module k, and their channels the order of its pads.

    Args:
        surface: Connected surface with edges shorter than half a pitch.
        pitch: Distance between pads [m].
        allowed: (m,) faces that may have pads.
        seed: Seed for the start and the direction of the tiling.

    Raises:
        SkinError: No module fits.

    Cost: 1 s for 100 modules.
    """
    random = np.random.default_rng(seed)
    tilings = [_Tiling(surface, pitch, allowed, random) for _ in range(_STARTS)]
    best = max(tilings, key=lambda tiling: len(tiling.boards))  # the first of equals
    if not len(best.boards):
        raise SkinError(
            "no module fits on the surface",
            place="pitch",
            value=f"modules with sides of {1e3 * TILE_SIDE * pitch:.0f} mm",
            remedy="Choose a smaller pitch, fewer excluded zones, or the even pattern",
        )
    faces, weights = best.pads()
    points = surface.points(faces, weights)
    centres = surface.face_centres
    candidates = np.flatnonzero(allowed)
    seeds = candidates[distinct_faces(centres[candidates], points)]
    owner = np.where(allowed, geodesic_voronoi(face_graph(surface), seeds, reach=CELL_RADIUS * pitch), -1)
    taxels = taxels_at_barycentric(surface, faces, weights, straighten_cells(surface, points, owner, seeds))
    modules, pads = np.divmod(np.arange(len(faces)), len(MODULE_PADS))
    return replace(taxels, identity=TaxelIdentity(modules=modules, channels=pads))


@dataclass(frozen=True, eq=False)
class _Boards:
    """Placed or candidate boards: middles (k, 3), faces (k,), unit normals (k, 3), directions of the tips (k, 3)."""

    middle: FloatArray
    face: IntArray
    normal: FloatArray
    tip: FloatArray

    def __len__(self) -> int:
        return len(self.face)

    def points(self, pattern: FloatArray, pitch: float) -> FloatArray:
        """Return (k, j, 3) the points ``pattern`` (j, 2), in pitches, in the plane of each board."""
        across = np.cross(self.tip, self.normal)
        flat = pattern[:, 0, None] * across[:, None] + pattern[:, 1, None] * self.tip[:, None]
        return self.middle[:, None] + pitch * flat

    def select(self, which: BoolArray | IntArray | slice) -> _Boards:
        return _Boards(self.middle[which], self.face[which], self.normal[which], self.tip[which])

    def joined(self, other: _Boards) -> _Boards:
        both = (np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.__dataclass_fields__)
        return _Boards(*both)


class _Tiling:
    """Tiling of a surface with boards, extended until there is no room for another one."""

    def __init__(self, surface: Mesh, pitch: float, allowed: BoolArray, random: np.random.Generator) -> None:
        self.boards = _Boards(np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)))
        self._surface = surface
        self._pitch = pitch
        self._allowed = allowed
        self._outlines = np.zeros((0, len(_OUTLINE), 3))
        self._closest = ClosestPoint(surface)
        smooth = surface.vertex_normals[surface.faces].sum(axis=1)
        self._normals = smooth / np.linalg.norm(smooth, axis=1, keepdims=True)
        table = surface.connectivity
        # The side opposite to corner k starts at the next corner.
        self._border_behind = np.roll(table.face_count[table.edge_of] == 1, -1, axis=1)
        before = -1
        while len(self.boards) > before:
            before = len(self.boards)
            tried = self._tried(random, _TRIED if before else _FIRST)
            for start in range(0, len(tried), _BATCH):
                self._grow(self._usable(tried.select(slice(start, start + _BATCH))))

    def pads(self) -> tuple[IntArray, FloatArray]:
        """Return faces (10 k,) and weights (10 k, 3) of the pads on the surface."""
        return self._closest.query(self.boards.points(MODULE_PADS, self._pitch).reshape(-1, 3))[:2]

    def _grow(self, waiting: _Boards) -> None:
        """Place the candidates ``waiting``, which fit and are clear, in order, and others that fit next to them."""
        while len(waiting):
            board = waiting.select(slice(1))
            waiting = waiting.select(slice(1, None))
            self.boards = self.boards.joined(board)
            self._outlines = np.concatenate([self._outlines, board.points(_OUTLINE, self._pitch)])
            waiting = waiting.select(self._clear(waiting, since=len(self.boards) - 1))
            waiting = waiting.joined(self._usable(self._adjacent(board)))

    def _usable(self, boards: _Boards) -> _Boards:
        boards = boards.select(self._clear(boards))
        return boards.select(self._fits(boards))

    def _tried(self, random: np.random.Generator, count: int) -> _Boards:
        """Return candidates at random places with room for a board, each in several directions."""
        centres = self._surface.face_centres
        free = np.flatnonzero(self._allowed)
        if len(self.boards):
            room = cKDTree(self._outlines.reshape(-1, 3)).query(centres[free])[0]
            free = free[
                room > (np.sqrt(3) / 2 + _OUTLINE_CLEARANCE) * self._pitch
            ]  # a board's sides are that far from its middle
        face = np.repeat(random.permutation(free)[:count], _TURNS)
        turn = np.tile(np.arange(_TURNS) / _TURNS * 2 * np.pi / 3, len(face) // _TURNS)
        normal = self._normals[face]
        return _Boards(centres[face], face, normal, tangent_directions(normal, turn))

    def _adjacent(self, board: _Boards) -> _Boards:
        """Return the three tiles that share a side with a board, each at a few distances, nearest first."""
        turn = np.pi + np.array([0.0, 2 * np.pi / 3, -2 * np.pi / 3])
        side = np.cross(board.normal, board.tip)
        steps = np.tile(np.cos(turn)[:, None] * board.tip + np.sin(turn)[:, None] * side, (len(_STRETCH), 1))
        lengths = np.repeat(_STRETCH, 3) * TILE_SIDE / np.sqrt(3) * self._pitch
        starts = np.repeat(board.middle, len(steps), axis=0)
        faces = np.repeat(board.face, len(steps))
        middle, face, sound = step_along_surface(self._surface, self._closest, starts, faces, steps, lengths)
        middle = middle[sound]
        face = face[sound]
        normal = self._normals[face]
        return _Boards(middle, face, normal, parallel_transport(steps[sound], board.normal, normal))

    def _fits(self, boards: _Boards) -> BoolArray:
        """Return (k,) whether each board with its margin is within the border, its pads on allowed and flat faces."""
        pitch = self._pitch
        normal = boards.normal[:, None]
        faces, aside, down, over = self._projected(boards.points(MODULE_PADS, pitch), normal)
        good = self._allowed[faces] & ~over & (aside < _MAX_PAD_SHIFT * pitch) & (down < _MAX_PAD_DROP * pitch)
        good &= (self._normals[faces] * normal).sum(axis=2) > _MIN_PAD_FACING
        over = self._projected(boards.points(_BOARD_CORNERS, pitch), normal)[3]
        return np.asarray(good.all(axis=1) & ~over.any(axis=1))

    def _projected(self, points: FloatArray, normal: FloatArray) -> tuple[IntArray, FloatArray, FloatArray, BoolArray]:
        """Project points (k, j, 3): faces, shifts along and across the plane [m], whether they are over the border."""
        faces, weights, _ = self._closest.query(points.reshape(-1, 3))
        move = self._surface.points(faces, weights).reshape(points.shape) - points
        down = (move * normal).sum(axis=2)
        aside = np.linalg.norm(move - down[:, :, None] * normal, axis=2)
        on_border = ((weights < 1e-9) & self._border_behind[faces]).any(axis=1).reshape(aside.shape)
        return faces.reshape(aside.shape), aside, np.abs(down), on_border & (aside > _MAX_OVERHANG * self._pitch)

    def _clear(self, boards: _Boards, *, since: int = 0) -> BoolArray:
        """Return (k,) whether each board overlaps none placed since number ``since`` on its side of the surface."""
        laid = self.boards.select(slice(since, None))
        away = ((boards.middle[:, None] - laid.middle) ** 2).sum(axis=2)
        one, other = np.nonzero(
            (away < (_MAX_TOUCHING_DISTANCE * self._pitch) ** 2) & (boards.normal @ laid.normal.T > 0)
        )
        gaps = boards.points(_OUTLINE, self._pitch)[one][:, :, None] - self._outlines[since + other][:, None]
        overlap = (gaps**2).sum(axis=3).min(axis=(1, 2)) < (_OUTLINE_CLEARANCE * self._pitch) ** 2
        clear = np.ones(len(boards), dtype=bool)
        clear[one[overlap]] = False
        return clear
