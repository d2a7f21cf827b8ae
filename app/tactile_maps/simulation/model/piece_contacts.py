"""Contacts of links that collide in several convex pieces: on the real surface, and without the seams between pieces.

Pieces follow the surface to within a tolerance, and meet in seams that are no edges of the link. A ball near a seam
touches the rim of the next piece as well, along a tilted normal. ``PieceContacts`` therefore moves the points of balls
to the surface itself, and leaves out points that no surface supports:

- A ball touches where the distance from its centre to the surface is a local minimum. A point that another piece comes
  closer to the centre next to it is not one.
- Another body touches along the normal of a face near the point, or at an edge or corner, where the surface around the
  point is behind it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.robots.model.robot import Robot
from tactile_maps.simulation.model.contact_points import centre_on_cap, centre_on_side, correct_normal
from tactile_maps.skin.link_pieces import LinkPieces, link_pieces, piece_number
from tactile_maps.skin.model.skin import Skin

_SAME = 1e-5
"""Distance below which two places are one [m]."""
_NEARER = 1e-9
_BORDER = 5e-3
"""Distance below which what is bare is next to the skin [m]."""
_ALONG = math.cos(math.radians(15.0))
"""Cosine between the normal of a contact and that of a face from which on they agree."""
_AROUND = 3e-3
_BEHIND = 5e-4
"""Radius about an edge in which the surface must be behind it, and by how much it may be before [m]."""


class _PieceSurface:
    """The faces of one link by piece."""

    def __init__(self, pieces: LinkPieces, first: int) -> None:
        corners = pieces.surface.vertices[pieces.surface.faces]
        self._first = first
        self._skinned = pieces.skinned
        self._faces = [np.flatnonzero(pieces.piece == piece) for piece in range(len(pieces.hulls))]
        self._corners = corners
        self._sides = np.roll(corners, -1, axis=1) - corners
        self._lengths = np.maximum(np.vecdot(self._sides, self._sides), 1e-30)
        self.normals = pieces.surface.face_normals
        self._inward = np.cross(self.normals[:, None], self._sides)

    def faces(self, geom: int) -> IntArray:
        """Return the faces of the piece that a geom is."""
        return self._faces[geom - self._first]

    def joins(self, face: int, others: IntArray) -> FloatArray:
        """Return how close to a place in a face others must be to be next to it [m]; bare ones keep off the skin."""
        return np.where((face < self._skinned) == (others < self._skinned), _SAME, _BORDER)

    def closest(self, faces: IntArray, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the point (k, 3) of each face that is closest to a point, and its distance (k,)."""
        corners = self._corners[faces]
        sides = self._sides[faces]
        offsets = point - corners
        shares = np.clip(np.vecdot(offsets, sides) / self._lengths[faces], 0.0, 1.0)
        on_sides = corners + shares[..., None] * sides
        away = np.linalg.norm(on_sides - point, axis=2)
        best = away.argmin(axis=1)
        rows = np.arange(len(faces))
        places = on_sides[rows, best]
        distances = away[rows, best]
        above = (np.vecdot(offsets, self._inward[faces]) > 0).all(axis=1)
        heights = np.vecdot(offsets[above, 0], self.normals[faces[above]])
        places[above] = point - heights[:, None] * self.normals[faces[above]]
        distances[above] = np.abs(heights)
        return places, distances

    def vertices(self, faces: IntArray) -> FloatArray:
        """Return the corners of faces (3 k, 3)."""
        return self._corners[faces].reshape(-1, 3)


class PieceContacts:
    """Corrects the contacts of one model's links that collide in pieces. Built once for a model.

    Args:
        model: The compiled model.
        robot: The robot.
        skin: Its skin.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot, skin: Skin) -> None:
        self._model = model
        self._surfaces: dict[int, _PieceSurface] = {}
        groups = piece_groups(model)
        for first in sorted({group for geom, group in enumerate(groups) if piece_number(model.geom(geom).name) == 0}):
            link = model.body(int(model.geom_bodyid[first])).name
            if (pieces := link_pieces(robot, skin, link)) is not None:
                self._surfaces[first] = _PieceSurface(pieces, first)
        self._groups = groups

    def correct(self, data: mujoco.MjData, pair: int, numbers: Sequence[int]) -> None:
        """Correct the contacts ``numbers`` of a pair, and give them its parameters.

        Args:
            data: Between its collisions and its constraints, which the caller then makes again.
            pair: Number of the pair; its geoms may be the first pieces of their links.
            numbers: The contacts.
        """
        model = self._model
        contact = data.contact
        own = np.asarray(numbers)
        contact.friction[own] = model.pair_friction[pair]
        contact.solref[own] = model.pair_solref[pair]
        contact.solimp[own] = model.pair_solimp[pair]
        contact.solreffriction[own] = model.pair_solreffriction[pair]
        kept = set(numbers)
        for side in (0, 1):
            surface = self._surfaces.get(self._groups[int(contact.geom[own[0], side])])
            if surface is None:
                continue
            other = int(contact.geom[own[0], 1 - side])
            if model.geom_type[other] == mujoco.mjtGeom.mjGEOM_SPHERE:
                kept = self._on_surface(data, surface, own, side)
            elif model.geom_type[other] != mujoco.mjtGeom.mjGEOM_PLANE:
                self._correct_points(data, own)
                kept &= self._supported(data, surface, own, side)
        left_out = [number for number in numbers if number not in kept]
        contact.exclude[left_out] = 1
        contact.efc_address[left_out] = -1

    def _on_surface(self, data: mujoco.MjData, surface: _PieceSurface, own: IntArray, side: int) -> set[int]:
        """Move a ball's contacts to the surface and return those that are local minima of the distance."""
        model = self._model
        contact = data.contact
        geoms = contact.geom[own]
        body = int(model.geom_bodyid[geoms[0, side]])
        ball = int(geoms[0, 1 - side])
        turn = data.xmat[body].reshape(3, 3)
        origin = data.xpos[body]
        radius = float(model.geom_size[ball, 0])
        centre = (data.geom_xpos[ball] - origin) @ turn
        faces = [surface.faces(geom) for geom in geoms[:, side].tolist()]
        near = np.concatenate(faces)
        owner = np.repeat(np.arange(len(own)), [len(each) for each in faces])
        places, distances = surface.closest(near, centre)
        kept: list[FloatArray] = []
        found = set()
        for row in np.argsort([distances[owner == k].min() for k in range(len(own))], kind="stable").tolist():
            mine = np.flatnonzero(owner == row)
            best = mine[distances[mine].argmin()]
            place = places[best]
            away = float(distances[best])
            others = near[(owner != row) & (distances < away - _NEARER)]
            if len(others) and (surface.closest(others, place)[1] < surface.joins(int(near[best]), others)).any():
                continue
            if any(math.dist(place, known) < _SAME for known in kept):
                continue
            kept.append(place)
            number = int(own[row])
            pushed = (1 - 2 * side) * contact.frame[number, :3] @ turn
            inside = (centre - place) @ pushed < 0
            outward = (place - centre if inside else centre - place) / away if away > _SAME else pushed
            distance = (-away if inside else away) - radius
            if distance < 0:
                found.add(number)
                contact.dist[number] = distance
                contact.frame[number] = _frame_along(*((1 - 2 * side) * (turn @ outward)).tolist())
                contact.pos[number] = turn @ (centre - (radius + 0.5 * distance) * outward) + origin
        return found

    def _correct_points(self, data: mujoco.MjData, own: IntArray) -> None:
        """Correct the points that MuJoCo finds between each piece and a body with faces."""
        geoms = data.contact.geom[own]
        for pair in np.unique(geoms, axis=0):
            numbers = own[(geoms == pair).all(axis=1)].tolist()
            for correct in (correct_normal, centre_on_cap, centre_on_side):
                correct(self._model, data, numbers)

    def _supported(self, data: mujoco.MjData, surface: _PieceSurface, own: IntArray, side: int) -> set[int]:
        """Return the contacts whose normal a face near them has, or at which the surface ends as at an edge."""
        model = self._model
        contact = data.contact
        geoms = contact.geom[own, side]
        body = int(model.geom_bodyid[geoms[0]])
        turn = data.xmat[body].reshape(3, 3)
        origin = data.xpos[body]
        points = (contact.pos[own] - origin) @ turn
        outward = (1 - 2 * side) * contact.frame[own, :3] @ turn
        near = np.concatenate([surface.faces(geom) for geom in np.unique(geoms).tolist()])
        vertices = surface.vertices(near)
        found = set()
        agreements = np.zeros(len(own))
        for row, (number, geom) in enumerate(zip(own.tolist(), geoms.tolist(), strict=True)):
            faces = surface.faces(geom)
            distances = surface.closest(faces, points[row])[1]
            close = faces[distances < distances.min() + _BEHIND]
            agreements[row] = (surface.normals[close] @ outward[row]).max()
            rise = (vertices[np.linalg.norm(vertices - points[row], axis=1) < _AROUND] - points[row]) @ outward[row]
            if agreements[row] > _ALONG or (agreements[row] > 0 and rise.max(initial=-1.0) < _BEHIND):
                found.add(number)
        # A body that only seams hold is held by the one that faces it most: contact is never lost.
        return found or {int(own[agreements.argmax()])}


def _frame_along(x: float, y: float, z: float) -> tuple[float, ...]:
    """Return a right-handed frame (9,) whose first row is the unit vector given."""
    if abs(x) < 0.9:
        scale = 1 / math.hypot(y, z)
        first = (0.0, z * scale, -y * scale)
    else:
        scale = 1 / math.hypot(x, z)
        first = (-z * scale, 0.0, x * scale)
    a, b, c = first
    return x, y, z, *first, y * c - z * b, z * a - x * c, x * b - y * a


def piece_groups(model: mujoco.MjModel) -> list[int]:
    """Return the geom that represents each geom: the first piece of its link, or the geom itself."""
    groups = []
    for geom in range(model.ngeom):
        number = piece_number(model.geom(geom).name)
        groups.append(geom if number is None else geom - number)
    return groups


def shared_counts(depths: Iterable[float], normals: FloatArray) -> FloatArray:
    """Return for each point how many points as deep as the deepest are as stiff along its normal as these together.

    Points whose normals are perpendicular are separate springs. Of two with equal depths and an angle of 2 a between
    their normals each counts  1 + cos 2 a = 2 cos² a,  so that together they are as stiff as one.
    """
    deep = np.maximum(np.fromiter(depths, dtype=np.float64), 0.0)
    along = np.maximum(normals @ normals.T, 0.0)
    return np.asarray(along @ (deep / deep.max())) if deep.max() > 0 else along.sum(axis=1)
