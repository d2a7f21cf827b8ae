"""Surfaces to be flattened, with a known result or a named difficulty, and skins made of them.

``SURFACES[name]()`` returns a surface, ``skin_of(surface, ...)`` a skin.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import trimesh

from tactile_maps.geometry.surface.connectivity import remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly


def sheet(columns=12, rows=8, *, width=0.12, height=0.08, shape=lambda x, y: 0 * x) -> Mesh:
    """Return a rectangle lifted out of the plane by ``shape``."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1), indexing="ij")
    vertices = np.stack([x, y, shape(x, y)], axis=-1).reshape(-1, 3)
    return Mesh(vertices, _grid_faces(columns, rows))


def _grid_faces(columns, rows):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    a = (i * (rows + 1) + j).ravel()
    b = a + rows + 1
    return np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])


def frustum(bottom=0.04, top=0.04, *, length=0.2, around=36, along=20, bump=0.0) -> Mesh:
    """Return a tube or cone, open at both ends, whose radius varies by the share ``bump``."""
    turn, up = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, 1, along + 1))
    radius = bottom + (top - bottom) * up
    radius = radius * (1 + bump * np.sin(3 * turn) * np.sin(2 * np.pi * up))
    vertices = np.stack([radius * np.cos(turn), radius * np.sin(turn), length * up], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a = (i * around + j).ravel()
    b = (i * around + (j + 1) % around).ravel()
    faces = np.concatenate([np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)])
    return Mesh(vertices, faces)


def flat_disk(rings=20) -> tuple[np.ndarray, np.ndarray]:
    """Return polar coordinates (radius 0 to 1, angle) and faces of a disk with rings of 6, 12, 18... vertices."""
    polar = [(0.0, 0.0)]
    starts = [0]
    for ring in range(1, rings + 1):
        starts.append(len(polar))
        polar += [(ring / rings, 2 * np.pi * k / (6 * ring)) for k in range(6 * ring)]
    faces = []
    for ring in range(1, rings + 1):
        outer = 6 * ring
        inner = max(6 * (ring - 1), 1)
        for side in range(6):
            for k in range(ring):
                a = side * ring + k
                b = (side * ring + k + 1) % outer
                c = (side * (ring - 1) + k) % inner
                faces.append((starts[ring - 1] + c, starts[ring] + a, starts[ring] + b))
                if k < ring - 1:
                    d = (side * (ring - 1) + k + 1) % inner
                    faces.append((starts[ring - 1] + c, starts[ring] + b, starts[ring - 1] + d))
    return np.array(polar), np.array(faces)


def cap(angle, *, rings=24, radius=0.05) -> Mesh:
    """Return the part of a sphere within ``angle`` [rad] of its pole; pi / 2 is a hemisphere."""
    polar, faces = flat_disk(rings)
    down = angle * polar[:, 0]
    turn = polar[:, 1]
    vertices = np.stack([np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down)], axis=1)
    return Mesh(radius * vertices, faces)


def cup(depth, *, rings=6, radius=0.02) -> Mesh:
    """Return a tube with a flat bottom and one open end, ``depth`` radii deep."""
    polar, faces = flat_disk(rings)
    bottom = radius * np.stack([polar[:, 0] * np.cos(polar[:, 1]), polar[:, 0] * np.sin(polar[:, 1])], axis=1)
    around = 6 * rings
    layers = int(depth * rings)
    rim = len(bottom) - around + np.arange(around)
    wall = [np.column_stack([bottom[rim], np.full(around, -radius * k / rings)]) for k in range(1, layers + 1)]
    vertices = np.concatenate([np.column_stack([bottom, np.zeros(len(bottom))]), *wall])
    below = np.concatenate([rim, len(bottom) + np.arange(layers * around)]).reshape(-1, around)
    a = below[:-1].ravel()
    b = np.roll(below[:-1], -1, axis=1).ravel()
    c = below[1:].ravel()
    d = np.roll(below[1:], -1, axis=1).ravel()
    return Mesh(vertices, np.concatenate([faces, np.stack([a, c, d], axis=1), np.stack([a, d, b], axis=1)]))


def torus(*, major=0.06, minor=0.02, around=36, across=18) -> Mesh:
    """Return a closed surface with one handle."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    ring = major + minor * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a = (i * across + j).ravel()
    b = ((i + 1) % around * across + j).ravel()
    c = (i * across + (j + 1) % across).ravel()
    d = ((i + 1) % around * across + (j + 1) % across).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]))


def sphere(*, radius=0.05, subdivisions=3) -> Mesh:
    """Return a closed surface without handles."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(np.asarray(ball.vertices), np.asarray(ball.faces))


def solid(shape: trimesh.Trimesh) -> Mesh:
    """A shape of trimesh."""
    return Mesh(np.asarray(shape.vertices), np.asarray(shape.faces))


def box(*sizes, centre=(0.0, 0.0, 0.0)) -> Mesh:
    """A cuboid of twelve triangles."""
    shape = trimesh.creation.box(sizes)
    return Mesh(np.asarray(shape.vertices) + centre, np.asarray(shape.faces))


def sieve(holes=5) -> Mesh:
    """Return a curved sheet with several holes."""
    whole = sheet(40, 30, width=0.2, height=0.15, shape=lambda x, y: 3 * x * y)
    middle = whole.vertices[whole.faces].mean(axis=1)
    centres = np.stack([0.03 + 0.14 * np.linspace(0, 1, holes), 0.04 + 0.07 * (np.arange(holes) % 2)], axis=1)
    apart = np.linalg.norm(middle[:, None, :2] - centres, axis=2).min(axis=1)
    faces, kept = remove_unreferenced(whole.faces[apart > 0.013])
    return Mesh(whole.vertices[kept], faces)


def blocks(cells, *, size=0.01) -> Mesh:
    """Return the surface of joined unit cubes, four squares on each side, from which handles can be built."""
    cells = {tuple(cell) for cell in cells}
    quads = []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                neighbour = list(cell)
                neighbour[axis] += 2 * side - 1
                if tuple(neighbour) in cells:
                    continue
                corner = 2 * np.array(cell)
                corner[axis] += 2 * side
                u = np.roll(np.eye(3, dtype=int), -1, axis=0)[axis]
                v = np.roll(np.eye(3, dtype=int), -2, axis=0)[axis]
                first, second = (u, v) if side else (v, u)
                for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
                    a = corner + i * first + j * second
                    quads.append([a, a + first, a + first + second, a + second])
    points, numbers = np.unique(np.array(quads).reshape(-1, 3), axis=0, return_inverse=True)
    q = numbers.reshape(-1, 4)
    return Mesh(0.5 * size * points, np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]]))


def eight() -> Mesh:
    """Return a closed plate with two square holes, which has two handles."""
    return blocks({(x, y, 0) for x in range(7) for y in range(3)} - {(1, 1, 0), (2, 1, 0), (4, 1, 0), (5, 1, 0)})


def spiral(turns=1.4) -> Mesh:
    """Return a strip around an axis for more than one turn, which overlaps itself if unrolled without distortion."""
    angle, across = np.meshgrid(np.linspace(0, 2 * np.pi * turns, 121), np.linspace(0.03, 0.06, 9), indexing="ij")
    vertices = np.stack([across * np.cos(angle), across * np.sin(angle), 0.002 * angle], axis=-1).reshape(-1, 3)
    return Mesh(vertices, _grid_faces(120, 8)[:, ::-1])


def with_thin_faces(count=6) -> Mesh:
    """Return a saddle in which some faces are split into one of zero area and the rest."""
    whole = sheet(shape=lambda x, y: 4 * x * y)
    vertices = whole.vertices.tolist()
    faces = whole.faces.tolist()
    for number in range(count):
        a, b, c = faces[7 * number]
        vertices.append(np.mean([vertices[b], vertices[c]], axis=0).tolist())
        # The new vertex is on side b-c, which stays because the neighbouring face does not use the new vertex.
        faces[7 * number] = [a, b, len(vertices) - 1]
        faces += [[a, len(vertices) - 1, c], [len(vertices) - 1, b, c]]
    return Mesh(np.array(vertices), np.array(faces))


SURFACES = {
    "sheet": sheet,
    "saddle": lambda: sheet(shape=lambda x, y: 6 * x * y),
    "tube": frustum,
    "cone": lambda: frustum(0.05, 0.02),
    "bumpy tube": lambda: frustum(0.05, 0.03, bump=0.2),
    "cap": lambda: cap(1.0),
    "hemisphere": lambda: cap(np.pi / 2),
    "nearly closed": lambda: cap(2.8),
    "cup": lambda: cup(4),
    "deep cup": lambda: cup(60),
    "sphere": sphere,
    "torus": torus,
    "two handles": eight,
    "sieve": sieve,
    "spiral": spiral,
    "thin faces": with_thin_faces,
    "one triangle": lambda: Mesh(0.01 * np.eye(3), np.array([[0, 1, 2]])),
    "one wide": lambda: sheet(20, 1),
    "needles": lambda: sheet(6, 60, width=0.6, height=0.006),
    "loose vertices": lambda: Mesh(np.concatenate([np.full((3, 3), 9.0), sheet().vertices]), sheet().faces + 3),
}


def taxels_on(surface: Mesh, count: int, *, seed=0):
    """Return taxels placed by the program's own method."""
    return place_evenly(surface, min(count, len(surface.faces)), seed=seed)


def skin_of(*surfaces: Mesh, taxels=40, seed=0) -> Skin:
    """Return a skin with one link and patch for each surface, ``taxels`` on each."""
    return Skin(
        tuple(Patch(f"patch {k}", f"link {k}", s, taxels_on(s, taxels, seed=seed)) for k, s in enumerate(surfaces))
    )


@cache
def named(name: str) -> Mesh:
    """Return a surface of the catalogue, cached."""
    return SURFACES[name]()
