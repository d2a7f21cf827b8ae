"""Straight walks over a surface, and the grid of points that they span between two of its points.

A straight walk (a straightest geodesic, Polthier and Schmies 1998) crosses an edge as if the next triangle were
unfolded into the plane of the last one. On a developable surface it is a straight line of the unrolled surface. The
grid has a middle row, and from each point of that row a column perpendicular to it. Rows and columns therefore keep
their distances on a developable surface and deviate symmetrically elsewhere. Centre, direction and pitch are chosen so
that two opposite corners are at the requested points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh

_MAX_CROSSINGS = 20_000
_ROUNDS = 60
_CLOSE = 1e-4
"""Tolerance of the corners, in pitches."""
_EDGE_COSINE = float(np.cos(np.radians(60)))
"""Adjacent points whose normals differ by more are on two sides of an edge, or of a thin wall."""


@dataclass(frozen=True, eq=False)
class Walkers:
    """State of k straight walks.

    Attributes:
        faces: (k,) the face under each.
        points: (k, 3) on that face [m].
        ahead: (k, 3) unit direction in the plane of the face.
        on: (k,) False for a walk that has left the surface and continues in the plane of its last face.
    """

    faces: IntArray
    points: FloatArray
    ahead: FloatArray
    on: BoolArray

    def select(self, which: IntArray) -> Walkers:
        """Return the walkers ``which`` (j,), in that order."""
        return Walkers(self.faces[which], self.points[which], self.ahead[which], self.on[which])


class StraightWalks:
    """Walks straight over one surface.

    Args:
        surface: Consistently oriented mesh without zero-area faces.
    """

    def __init__(self, surface: Mesh) -> None:
        self._surface = surface
        self._twin = np.full(3 * len(surface.faces), -1)
        pairs = surface.connectivity.twins
        self._twin[pairs[:, 0]] = pairs[:, 1]
        self._twin[pairs[:, 1]] = pairs[:, 0]

    def start(self, faces: IntArray, points: FloatArray, directions: FloatArray) -> Walkers:
        """Return walkers at ``points`` (k, 3) of ``faces`` (k,), heading along projected ``directions`` (k, 3)."""
        normals = self._surface.face_normals[faces]
        level = directions - (directions * normals).sum(axis=1, keepdims=True) * normals
        length = np.linalg.norm(level, axis=1, keepdims=True)
        aside = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
        level = np.where(length > 0, level, aside)  # a direction along the normal: any heading will do
        level = level / np.linalg.norm(level, axis=1, keepdims=True)
        return Walkers(faces, points, level, np.ones(len(faces), dtype=bool))

    def turned(self, walkers: Walkers, turns: FloatArray) -> Walkers:
        """Return the walkers turned left by ``turns`` (k,) [rad], seen from outside."""
        left = np.cross(self._surface.face_normals[walkers.faces], walkers.ahead)
        ahead = np.cos(turns)[:, None] * walkers.ahead + np.sin(turns)[:, None] * left
        return replace(walkers, ahead=ahead)

    def go(self, walkers: Walkers, lengths: FloatArray) -> Walkers:
        """Return the walkers after another ``lengths`` (k,) [m], not negative.

        Raises:
            MeshError: A walk crosses more than 20,000 edges.
        """
        faces = walkers.faces.copy()
        on = walkers.on.copy()
        points = walkers.points.copy()
        ahead = walkers.ahead.copy()
        left = np.array(lengths, dtype=np.float64)
        came = np.full(len(faces), -1)
        points[~on] += left[~on, None] * ahead[~on]
        moving = np.flatnonzero(on & (left > 0))
        for _ in range(_MAX_CROSSINGS):
            if not len(moving):
                return Walkers(faces, points, ahead, on)
            side, until = self._exit(faces[moving], points[moving], ahead[moving], came[moving])
            step = np.minimum(until, left[moving])
            points[moving] += step[:, None] * ahead[moving]
            left[moving] -= step
            leaving = until <= step
            moving, side = moving[leaving & (left[moving] > 0)], side[leaving & (left[moving] > 0)]
            beyond = self._twin[side]
            over = moving[beyond < 0]
            on[over] = False
            points[over] += left[over, None] * ahead[over]
            moving = moving[beyond >= 0]
            side = side[beyond >= 0]
            beyond = beyond[beyond >= 0]
            ahead[moving] = self._across(side, beyond, ahead[moving])
            faces[moving] = beyond // 3
            came[moving] = beyond
        raise MeshError("a straight walk crosses too many edges", remedy="Choose points closer together")

    def _exit(
        self, faces: IntArray, points: FloatArray, ahead: FloatArray, came: IntArray
    ) -> tuple[IntArray, FloatArray]:
        """Return the half-edge (k,), not ``came``, by which each walk leaves its face, and its distance (k,) [m]."""
        corners = self._surface.vertices[self._surface.faces[faces]]
        normals = self._surface.face_normals[faces]
        outward = np.cross(np.roll(corners, -1, axis=1) - corners, normals[:, None])
        speed = np.einsum("kcd,kd->kc", outward, ahead)
        gap = np.einsum("kcd,kcd->kc", outward, corners - points[:, None])
        sides = 3 * faces[:, None] + np.arange(3)
        forward = (speed > 1e-12 * np.abs(outward).max(axis=2)) & (sides != came[:, None])
        until = np.where(forward, np.maximum(gap, 0.0) / np.where(forward, speed, 1.0), np.inf)
        side = until.argmin(axis=1)
        return sides[np.arange(len(faces)), side], until[np.arange(len(faces)), side]

    def _across(self, side: IntArray, beyond: IntArray, ahead: FloatArray) -> FloatArray:
        """Return the directions (k, 3) in the faces beyond the half-edges."""
        surface = self._surface
        face, corner = np.divmod(side, 3)
        start = surface.faces[face, corner]
        end = surface.faces[face, (corner + 1) % 3]
        along = surface.vertices[end] - surface.vertices[start]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        out = (ahead * np.cross(along, surface.face_normals[face])).sum(axis=1, keepdims=True)
        onward = np.cross(along, surface.face_normals[beyond // 3])
        turned = (ahead * along).sum(axis=1, keepdims=True) * along + out * onward
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))


@dataclass(frozen=True, eq=False)
class SurfaceGrid(ArrayFields):
    """Grid of points on a surface.

    Attributes:
        points: (rows, columns, 3) [m]; row 0, column 0 is the first corner.
        faces: (rows, columns) the face under each.
        on: (rows, columns) True for points on the surface with no sharp edge between them and the middle of the grid.
        pitch: (2,) between rows and between columns, along the surface [m].
    """

    points: FloatArray
    faces: IntArray
    on: BoolArray
    pitch: FloatArray


def surface_grid(
    surface: Mesh,
    first: FloatArray,
    last: FloatArray,
    rows: int,
    columns: int,
    *,
    aspect: float = 1.0,
    mirrored: bool = False,
) -> SurfaceGrid:
    """Return the grid whose opposite corners are the points of ``surface`` closest to ``first`` and ``last``.

    Seen from outside and starting at the first corner, columns run to the right and rows upward, in a frame rotated so
    that the last corner is at its point. With ``mirrored``, rows run downward.

    Args:
        surface: Consistently oriented mesh without zero-area faces.
        first: (3,) near the point of row 0, column 0 [m].
        last: (3,) near the point of the last row and column [m].
        rows: Number of rows, at least 1.
        columns: Number of columns, at least 1; the grid has at least two points.
        aspect: Distance between columns as a multiple of the distance between rows.
        mirrored: Selects one of the two grids with these corners.

    Raises:
        MeshError: The corners coincide, or no grid between them was found.

    Cost: 20 ms for 16 x 16 points on 20,000 faces.
    """
    faces, weights, _ = ClosestPoint(surface).query(np.stack([first, last]))
    corners = surface.points(faces, weights)
    half = complex((columns - 1) * aspect, (1 - rows if mirrored else rows - 1)) / 2
    chord = corners[1] - corners[0]
    if not (abs(half) > 0 and np.linalg.norm(chord) > 0):
        value = f"{rows} x {columns} points, {1e3 * float(np.linalg.norm(chord)):.3g} mm apart"
        raise MeshError("a grid needs two different corners and at least two points", value=value)
    walks = StraightWalks(surface)
    centre, pitch = _fitted_centre(surface, walks, corners, chord, half)
    return _spread(surface, walks, centre, pitch, (rows, columns), aspect, mirrored)


def _fitted_centre(
    surface: Mesh, walks: StraightWalks, corners: FloatArray, chord: FloatArray, half: complex
) -> tuple[Walkers, float]:
    """Return a walker in the middle of the grid, heading along its rows, and the pitch.

    A few rounds move, turn and scale the grid by the two corner errors, each measured in the frame of its own corner.
    """
    face, weight, _ = ClosestPoint(surface).query(corners.mean(axis=0)[None])
    centre = walks.start(face, surface.points(face, weight), chord[None])
    centre = walks.turned(centre, np.array([-np.angle(half)]))
    pitch = float(np.linalg.norm(chord)) / (2 * abs(half))
    for _ in range(_ROUNDS):
        ends = [_corner(walks, centre, pitch * half * sign) for sign in (-1, 1)]
        errors = [_corner_error(surface, end, corners[k], half * (-1, 1)[k]) for k, end in enumerate(ends)]
        if max(map(abs, errors)) < _CLOSE * pitch:
            return centre, pitch
        needed = 2 * pitch * half + errors[1] - errors[0]
        shift = (errors[0] + errors[1]) / 2
        turn = np.angle(needed) - np.angle(half)
        centre = walks.turned(centre, np.array([np.angle(shift)]))
        centre = walks.turned(walks.go(centre, np.array([abs(shift)])), np.array([turn - np.angle(shift)]))
        pitch = abs(needed) / (2 * abs(half))
    raise MeshError(
        "no grid between the two corners is found on the surface",
        value=f"{1e3 * float(np.linalg.norm(chord)):.0f} mm apart",
        remedy="Choose corners closer together, on one side of the link",
    )


def _corner(walks: StraightWalks, centre: Walkers, offset: complex) -> Walkers:
    """Return the walker at ``offset`` [m] from the centre: along the row, then perpendicular, facing outward."""
    aside = walks.turned(centre, np.array([0.0 if offset.real >= 0 else np.pi]))
    aside = walks.go(aside, np.array([abs(offset.real)]))
    back = 0.0 if offset.real >= 0 else np.pi
    up = walks.turned(aside, np.array([back + (np.pi / 2 if offset.imag >= 0 else -np.pi / 2)]))
    return walks.go(up, np.array([abs(offset.imag)]))


def _corner_error(surface: Mesh, end: Walkers, corner: FloatArray, side: complex) -> complex:
    """Return the error of a corner along the rows and perpendicular to them [m]."""
    up = end.ahead[0] if side.imag >= 0 else -end.ahead[0]
    right = np.cross(up, surface.face_normals[end.faces[0]])
    away = corner - end.points[0]
    return complex(float(away @ right), float(away @ up))


def _spread(
    surface: Mesh,
    walks: StraightWalks,
    centre: Walkers,
    pitch: float,
    shape: tuple[int, int],
    aspect: float,
    mirrored: bool,
) -> SurfaceGrid:
    rows, columns = shape
    right = aspect * pitch * (np.arange(columns) - (columns - 1) / 2)
    up = pitch * (np.arange(rows) - (rows - 1) / 2) * (-1 if mirrored else 1)
    row = centre.select(np.zeros(columns, dtype=np.int64))
    row = walks.go(walks.turned(row, np.where(right < 0, np.pi, 0.0)), np.abs(right))
    row = walks.turned(row, np.where(right < 0, np.pi, 0.0))
    every = row.select(np.tile(np.arange(columns), rows))
    upward = np.repeat(up, columns)
    every = walks.go(walks.turned(every, np.where(upward < 0, -np.pi / 2, np.pi / 2)), np.abs(upward))
    normals = surface.face_normals[every.faces]
    on = _before_edges(normals.reshape(rows, columns, 3), every.on.reshape(rows, columns))
    return SurfaceGrid(
        every.points.reshape(rows, columns, 3),
        every.faces.reshape(rows, columns),
        on,
        np.array([pitch, aspect * pitch]),
    )


def _before_edges(normals: FloatArray, on: BoolArray) -> BoolArray:
    """Return ``on`` (r, c) without the points beyond a sharp edge, seen from the middle."""
    result = np.array(on)
    rows, columns = on.shape
    middle = slice((rows - 1) // 2, rows // 2 + 1)
    for half in (range((columns - 1) // 2 - 1, -1, -1), range(columns // 2 + 1, columns)):
        for j in half:
            before = j + 1 if j < columns // 2 else j - 1
            bent = (normals[middle, j] * normals[middle, before]).sum(axis=1) < _EDGE_COSINE
            result[:, j] &= not (bent.any() or not result[middle, before].all())
    for half in (range((rows - 1) // 2 - 1, -1, -1), range(rows // 2 + 1, rows)):
        for i in half:
            before = i + 1 if i < rows // 2 else i - 1
            result[i] &= result[before] & ((normals[i] * normals[before]).sum(axis=1) >= _EDGE_COSINE)
    return result
