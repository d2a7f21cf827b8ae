"""Triangular modules of ten taxels, as on the skins of iCub and CySkin.

A module is a stiff triangle: its pads keep their pattern in the plane that touches the surface at its middle, and come
down onto the surface from there. Modules are laid side by side, as tiles; where the tiling meets itself or an obstacle,
gaps are searched for room for more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import BoolArray, FloatArray, IntArray
from app.errors import SkinError
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.topology import edge_table
from app.skin.place import cells, own_faces, straight_cells, surface_graph, taxels_in
from app.skin.placing.walking import carried, some_directions, walk
from app.skin.taxels import Taxels

PADS = np.array([[2, 0], [3, -1], [1, -1], [0, 0], [-1, -1], [-3, -1], [-2, 0], [-1, 1], [0, 2], [1, 1]]) * (
    0.5,
    np.sqrt(3) / 2,
)
"""(10, 2) the pads in pitches, in iCub's order without its two thermal ones; the tip looks along y."""
SIDE = 4.6
"""Side of a tile in pitches: 30 mm on iCub, whose pads are 6.5 mm apart."""
REACH = 1.0
"""A taxel feels this many pitches around itself, where no other taxel is nearer."""
MARGIN = 0.38
"""A board ends this many pitches outside its outer pads' triangle; boards do not overlap."""
_ASIDE, _DOWN, _FACING = 0.3, 1.0, 0.5
"""Pads move this far sideways and down at most, in pitches, and turn by 60 degrees, or the place is too bent."""
_OVERHANG = 0.05  # in pitches; less is the bend of the surface and rounding
_OUTER = PADS[[8, 9, 0, 1, 2, 4, 5, 6, 7]]  # once around
_OUTLINE = np.concatenate([_OUTER, (_OUTER + np.roll(_OUTER, -1, axis=0)) / 2])
_APART = float(np.hypot(2 * MARGIN, 0.25))  # of outlines' points: what lies between two of them is nearer than both
_RIM = _OUTER * (1 + MARGIN / np.linalg.norm(_OUTER, axis=1, keepdims=True))
_STARTS, _FIRST, _TRIED, _TURNS, _BATCH = 3, 20, 200, 12, 60
_NEAR = 2 * np.sqrt(3) + _APART  # boards whose middles are farther apart cannot touch
_STRETCH = 1.0, 1.05, 1.1
"""Tiles that do not fit right beside another are tried a little farther away: the surface bends in two ways."""


def place_modules(surface: Mesh, pitch: float, *, allowed: BoolArray, seed: int) -> Taxels:
    """As many modules as are found to fit; taxels 10 k to 10 k + 9 are module k, in the order of its pads.

    Args:
        surface: Connected; its edges shorter than half a pitch.
        pitch: Of the pads [m].
        allowed: (m,) faces that pads may lie on.
        seed: Chooses where the tiling starts, and which way it lies.

    Raises:
        SkinError: Not one module fits.

    Cost: 1 s for 100 modules.
    """
    random = np.random.default_rng(seed)
    tilings = [_Tiling(surface, pitch, allowed, random) for _ in range(_STARTS)]
    best = max(tilings, key=lambda tiling: len(tiling.boards))  # the first of equals
    if not len(best.boards):
        raise SkinError(
            "not one module fits on the surface",
            place="pitch",
            value=f"modules with sides of {1e3 * SIDE * pitch:.0f} mm",
            remedy="Choose a smaller pitch, fewer zones to keep out of, or the even pattern",
        )
    faces, weights = best.pads()
    points, centres = surface.points(faces, weights), surface.vertices[surface.faces].mean(axis=1)
    ground = np.flatnonzero(allowed)
    seeds = ground[own_faces(centres[ground], points)]
    owner = np.where(allowed, cells(surface_graph(surface, centres), seeds, reach=REACH * pitch), -1)
    return taxels_in(surface, faces, weights, straight_cells(surface, points, owner, seeds))


@dataclass(frozen=True, eq=False)
class _Boards:
    """Boards that lie or might lie: middles (k, 3), their faces (k,), unit normals and tips' directions (k, 3)."""

    middle: FloatArray
    face: IntArray
    normal: FloatArray
    tip: FloatArray

    def __len__(self) -> int:
        return len(self.face)

    def points(self, pattern: FloatArray, pitch: float) -> FloatArray:
        """(k, j, 3) the points ``pattern`` (j, 2), in pitches, in each board's plane."""
        across = np.cross(self.tip, self.normal)
        flat = pattern[:, 0, None] * across[:, None] + pattern[:, 1, None] * self.tip[:, None]
        return self.middle[:, None] + pitch * flat

    def select(self, which: BoolArray | IntArray | slice) -> _Boards:
        return _Boards(self.middle[which], self.face[which], self.normal[which], self.tip[which])

    def joined(self, other: _Boards) -> _Boards:
        both = (np.concatenate([getattr(self, name), getattr(other, name)]) for name in self.__dataclass_fields__)
        return _Boards(*both)


class _Tiling:
    """One attempt: ``boards`` grow until no room for another is found."""

    def __init__(self, surface: Mesh, pitch: float, allowed: BoolArray, random: np.random.Generator) -> None:
        self.boards = _Boards(np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)))
        self._surface, self._pitch, self._allowed = surface, pitch, allowed
        self._outlines = np.zeros((0, len(_OUTLINE), 3))
        self._closest = ClosestPoint(surface)
        smooth = surface.vertex_normals[surface.faces].sum(axis=1)
        self._normals = smooth / np.linalg.norm(smooth, axis=1, keepdims=True)
        table = edge_table(surface.faces)
        # The side opposite to corner k starts at the corner after it.
        self._border_behind = np.roll(table.face_count[table.edge_of] == 1, -1, axis=1)
        before = -1
        while len(self.boards) > before:
            before = len(self.boards)
            tried = self._tried(random, _TRIED if before else _FIRST)
            for start in range(0, len(tried), _BATCH):
                self._grow(self._usable(tried.select(slice(start, start + _BATCH))))

    def pads(self) -> tuple[IntArray, FloatArray]:
        """(10 k,) faces and (10 k, 3) weights of the places where the pads come down."""
        return self._closest.query(self.boards.points(PADS, self._pitch).reshape(-1, 3))[:2]

    def _grow(self, waiting: _Boards) -> None:
        """Lay ``waiting``, which fit and are clear, and whatever fits beside those laid; the first come first."""
        while len(waiting):
            board, waiting = waiting.select(slice(1)), waiting.select(slice(1, None))
            self.boards = self.boards.joined(board)
            self._outlines = np.concatenate([self._outlines, board.points(_OUTLINE, self._pitch)])
            waiting = waiting.select(self._clear(waiting, since=len(self.boards) - 1))
            beside = self._beside(board)
            waiting = waiting.joined(self._usable(beside))

    def _usable(self, boards: _Boards) -> _Boards:
        boards = boards.select(self._clear(boards))
        return boards.select(self._fits(boards))

    def _tried(self, random: np.random.Generator, count: int) -> _Boards:
        """Boards at random places with room for one, each turned a few ways."""
        centres, free = self._surface.vertices[self._surface.faces].mean(axis=1), np.flatnonzero(self._allowed)
        if len(self.boards):
            room = cKDTree(self._outlines.reshape(-1, 3)).query(centres[free])[0]
            free = free[room > (np.sqrt(3) / 2 + _APART) * self._pitch]  # a board's sides are that far from its middle
        face = np.repeat(random.permutation(free)[:count], _TURNS)
        turn = np.tile(np.arange(_TURNS) / _TURNS * 2 * np.pi / 3, len(face) // _TURNS)
        normal = self._normals[face]
        return _Boards(centres[face], face, normal, some_directions(normal, turn))

    def _beside(self, board: _Boards) -> _Boards:
        """The three tiles that share a side with one, each at a few distances, nearest first."""
        turn = np.pi + np.array([0.0, 2 * np.pi / 3, -2 * np.pi / 3])
        side = np.cross(board.normal, board.tip)
        steps = np.tile(np.cos(turn)[:, None] * board.tip + np.sin(turn)[:, None] * side, (len(_STRETCH), 1))
        lengths = np.repeat(_STRETCH, 3) * SIDE / np.sqrt(3) * self._pitch
        starts, faces = np.repeat(board.middle, len(steps), axis=0), np.repeat(board.face, len(steps))
        middle, face, sound = walk(self._surface, self._closest, starts, faces, steps, lengths)
        middle, face = middle[sound], face[sound]
        normal = self._normals[face]
        return _Boards(middle, face, normal, carried(steps[sound], board.normal, normal))

    def _fits(self, boards: _Boards) -> BoolArray:
        """(k,) boards on the surface with all pads and their margin, not too bent, pads outside all zones."""
        pitch, normal = self._pitch, boards.normal[:, None]
        faces, aside, down, over = self._landed(boards.points(PADS, pitch), normal)
        good = self._allowed[faces] & ~over & (aside < _ASIDE * pitch) & (down < _DOWN * pitch)
        good &= (self._normals[faces] * normal).sum(axis=2) > _FACING
        over = self._landed(boards.points(_RIM, pitch), normal)[3]
        return np.asarray(good.all(axis=1) & ~over.any(axis=1))

    def _landed(self, points: FloatArray, normal: FloatArray) -> tuple[IntArray, FloatArray, FloatArray, BoolArray]:
        """Where points (k, j, 3) come down: faces, how far sideways and down [m], and whether over the border."""
        faces, weights, _ = self._closest.query(points.reshape(-1, 3))
        move = self._surface.points(faces, weights).reshape(points.shape) - points
        down = (move * normal).sum(axis=2)
        aside = np.linalg.norm(move - down[:, :, None] * normal, axis=2)
        on_border = ((weights < 1e-9) & self._border_behind[faces]).any(axis=1).reshape(aside.shape)
        return faces.reshape(aside.shape), aside, np.abs(down), on_border & (aside > _OVERHANG * self._pitch)

    def _clear(self, boards: _Boards, *, since: int = 0) -> BoolArray:
        """(k,) boards that overlap none that lie already, from number ``since``, on the same side of the surface."""
        laid = self.boards.select(slice(since, None))
        away = ((boards.middle[:, None] - laid.middle) ** 2).sum(axis=2)
        one, other = np.nonzero((away < (_NEAR * self._pitch) ** 2) & (boards.normal @ laid.normal.T > 0))
        gaps = boards.points(_OUTLINE, self._pitch)[one][:, :, None] - self._outlines[since + other][:, None]
        overlap = (gaps**2).sum(axis=3).min(axis=(1, 2)) < (_APART * self._pitch) ** 2
        clear = np.ones(len(boards), dtype=bool)
        clear[one[overlap]] = False
        return clear
