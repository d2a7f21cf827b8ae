"""A hexagonal lattice carried over a surface.

From one taxel, the six directions to its neighbours are walked a pitch each, and handed on to the taxels found there,
turned no more than the surface bends (parallel transport). On a surface that can be unrolled the lattice stays perfect
until its front meets itself; on others it must tear somewhere. What it leaves open is filled, and a few Lloyd rounds
spread the misfit.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.skin.place import farthest_faces, settled
from app.skin.placing.walking import carried, some_directions, walk
from app.skin.taxels import Taxels

ROUNDS = 3
"""Of Lloyd; more let the lattice crumble into grains."""
_APART = 0.75
"""Steps that end closer than this many pitches to a taxel found that taxel."""


def place_lattice(surface: Mesh, count: int, pitch: float, *, allowed: BoolArray, seed: int) -> Taxels:
    """Exactly ``count`` taxels, as far as possible on a hexagonal lattice.

    Args:
        surface: Connected; its edges shorter than half a pitch.
        count: How many.
        pitch: That fits the count [m].
        allowed: (m,) faces that taxels may lie on.
        seed: Chooses where the lattice starts, and which way it lies.

    Cost: 0.6 s for 1000 taxels on 26,000 faces.
    """
    points, faces = carried_lattice(surface, pitch, np.random.default_rng(seed), allowed)
    kept = _least_crowded(points[allowed[faces]], count)
    centres = surface.vertices[surface.faces].mean(axis=1)
    ground = np.flatnonzero(allowed)
    starts = ground[np.unique(cKDTree(centres[ground]).query(kept)[1])]
    seeds = farthest_faces(surface, count, starts, allowed=allowed)
    return settled(surface, seeds, allowed=allowed, rounds=ROUNDS)


def carried_lattice(
    surface: Mesh, pitch: float, random: np.random.Generator, allowed: BoolArray
) -> tuple[FloatArray, IntArray]:
    """Points (k, 3) of a lattice that starts on an allowed face and grows over all of the surface, and their faces."""
    closest = ClosestPoint(surface)
    face = random.choice(np.flatnonzero(allowed))
    turn = random.uniform(0, np.pi / 3, 1)
    points, faces = surface.vertices[surface.faces[[face]]].mean(axis=1), np.array([face])
    front, ahead = np.zeros(1, dtype=np.int64), some_directions(surface.face_normals[[face]], turn)
    while len(front):
        steps = _six(ahead, surface.face_normals[faces[front]])
        start = np.repeat(front, 6)
        ends, at, sound = walk(surface, closest, points[start], faces[start], steps, pitch)
        new = np.flatnonzero(sound)
        new = new[_first_of_each(points, ends[new], _APART * pitch)]
        front = len(points) + np.arange(len(new))
        points, faces = np.concatenate([points, ends[new]]), np.concatenate([faces, at[new]])
        ahead = carried(steps[new], surface.face_normals[faces[start[new]]], surface.face_normals[at[new]])
    return points, faces


def _six(ahead: FloatArray, normals: FloatArray) -> FloatArray:
    """(6 f, 3) six unit directions in each tangent plane, the first of them ``ahead`` (f, 3)."""
    side, turn = np.cross(normals, ahead), np.arange(6) * np.pi / 3
    return (np.cos(turn)[:, None] * ahead[:, None] + np.sin(turn)[:, None] * side[:, None]).reshape(-1, 3)


def _first_of_each(known: FloatArray, found: FloatArray, apart: float) -> IntArray:
    """Those of ``found`` (s, 3) that keep ``apart`` from ``known`` and from those before them."""
    free = np.flatnonzero(cKDTree(known).query(found)[0] >= apart)
    pairs = cKDTree(found[free]).query_pairs(apart, output_type="ndarray")
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    taken = np.zeros(len(free), dtype=bool)
    for one, other in pairs.tolist():  # smaller number first: by then it is known whether that one stays
        taken[other] |= not taken[one]
    return free[~taken]


def _least_crowded(points: FloatArray, count: int) -> FloatArray:
    """At most ``count`` of the points; those closest to another go first, one after the other."""
    while len(points) > count:
        away = cKDTree(points).query(points, k=2)[0][:, 1]
        crowd = np.argsort(away, kind="stable")
        points = np.delete(points, crowd[: max(1, (len(points) - count) // 4)], axis=0)
    return points
