"""Catalogue of difficult meshes in named groups; each is made on request.

``HARD_MESHES`` are links as real files contain them. ``hard_mesh(name)`` makes a mesh that must be flattened without
repair, ``GROUPS`` has the names by group, and ``HOPELESS`` has the meshes that must be rejected with a named error.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import igl
import numpy as np
import trimesh

from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.surface.connectivity import remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.robots.model.robot import Link, Robot
from tests.support.surfaces import blocks, cap, eight, frustum, sheet, sieve, solid, sphere, spiral, torus


def _sphere(radius: float = 0.1) -> Mesh:
    return solid(trimesh.creation.icosphere(subdivisions=3, radius=radius))


def _cube() -> Mesh:
    return solid(trimesh.creation.box((0.2, 0.15, 0.1)))


def joined(*meshes: Mesh) -> Mesh:
    return join_meshes(meshes)


def moved(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    return Mesh(mesh.vertices + by, mesh.faces)


def _tube(length: float = 0.3, radius: float = 0.05, around: int = 40, along: int = 16) -> Mesh:
    """Open at both ends."""
    angle, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, length, along + 1))
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a = (i * around + j).ravel()
    b = (i * around + (j + 1) % around).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]))


def _soup() -> Mesh:
    """Every triangle on its own, some turned over, some missing."""
    rng = np.random.default_rng(7)
    sphere = _sphere()
    kept = sphere.faces[rng.random(len(sphere.faces)) > 0.05]
    faces = np.arange(3 * len(kept)).reshape(-1, 3)
    turned = rng.random(len(faces)) < 0.4
    faces[turned] = faces[turned][:, ::-1]
    return Mesh(sphere.vertices[kept].reshape(-1, 3), faces)


def _inner_shell() -> Mesh:
    inner = _sphere(0.06)
    return joined(_sphere(), Mesh(inner.vertices, inner.faces[:, ::-1]))


def _slivers() -> Mesh:
    """A cube with its faces cut into needles."""
    cube = _cube()
    corners = cube.vertices[cube.faces]
    cut = corners[:, 0] + 1e-7 * (corners[:, 1] - corners[:, 0])
    first = np.stack([corners[:, 0], cut, corners[:, 2]], axis=1)
    second = np.stack([cut, corners[:, 1], corners[:, 2]], axis=1)
    vertices = np.concatenate([first, second]).reshape(-1, 3)
    return Mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))


def _zero_area_faces() -> Mesh:
    cube = _cube()
    flat = np.array([[0, 0, 1], [2, 2, 2], [3, 4, 3]])
    return Mesh(cube.vertices, np.concatenate([cube.faces, flat]))


def _duplicates() -> Mesh:
    cube = _cube()
    return Mesh(np.concatenate([cube.vertices] * 2), np.concatenate([cube.faces, cube.faces + len(cube.vertices)]))


def _plate() -> Mesh:
    return Mesh([[0, 0, 0], [0.3, 0, 0], [0.3, 0.2, 0], [0, 0.2, 0]], [[0, 1, 2], [0, 2, 3]])


def _spike() -> Mesh:
    """A ball with a thin long needle."""
    return joined(_sphere(), moved(solid(trimesh.creation.cone(radius=0.008, height=0.25)), (0, 0, 0.09)))


def _moebius(around: int = 60) -> Mesh:
    """A band with one side."""
    angle = np.arange(around) * 2 * np.pi / around
    across = np.array([-0.03, 0.0, 0.03])
    radius = 0.12 + across * np.cos(angle / 2)[:, None]
    height = across * np.sin(angle / 2)[:, None]
    vertices = np.stack([radius * np.cos(angle)[:, None], radius * np.sin(angle)[:, None], height], axis=-1)
    index = np.arange(around * 3).reshape(around, 3)
    index = np.concatenate([index, index[:1, ::-1]])
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Mesh(vertices.reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def _fin() -> Mesh:
    """Three faces on one edge."""
    cube = _cube()
    edge = cube.faces[0][:2]
    return Mesh(np.concatenate([cube.vertices, [[0.2, 0.2, 0.2]]]), np.concatenate([cube.faces, [[*edge, 8]]]))


def _holed() -> Mesh:
    sphere = _sphere()
    keep = np.linalg.norm(sphere.vertices[sphere.faces].mean(axis=1) - [0, 0, 0.1], axis=1) > 0.04
    return Mesh(sphere.vertices, sphere.faces[keep])


HARD_MESHES: dict[str, Mesh] = {
    "cube": _cube(),
    "sphere": _sphere(),
    "torus": solid(trimesh.creation.torus(0.1, 0.04)),
    "open tube": _tube(),
    "soup": _soup(),
    "two components": joined(_sphere(), moved(_sphere(0.03), (0.3, 0, 0))),
    "overlapping parts": joined(_cube(), moved(_sphere(0.08), (0.08, 0.02, 0.03))),
    "inner shell": _inner_shell(),
    "slivers": _slivers(),
    "zero-area faces": _zero_area_faces(),
    "duplicates": _duplicates(),
    "inside out": Mesh(_cube().vertices, _cube().faces[:, ::-1]),
    "hole": _holed(),
    "fin": _fin(),
    "huge offset": moved(_cube(), (1e3, -1e3, 1e3)),
    "tiny": Mesh(_cube().vertices / 200, _cube().faces),
    "large": Mesh(_cube().vertices * 50, _cube().faces),
    "flat plate": _plate(),
    "thin spike": _spike(),
    "moebius": _moebius(),
    "one triangle": Mesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]),
}
"""Meshes with some area: each can be wrapped."""

HOPELESS_MESHES: dict[str, Mesh] = {
    "empty": Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
    "no faces": Mesh(np.eye(3), np.zeros((0, 3), dtype=np.int64)),
    "one point": Mesh(np.zeros((3, 3)), [[0, 1, 2]]),
    "one line": Mesh([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]]),
}
"""Meshes with no area: each must be refused by name, not crash."""


def one_link(mesh: Mesh, *, name: str = "part") -> Robot:
    """A robot of one fixed link that looks like ``mesh``."""
    mjcf = f'<mujoco><worldbody><body name="{name}"/></worldbody></mujoco>'
    return Robot(name, name, mjcf, {}, (Link(name, mesh),), (), np.zeros(0))


def scaled(mesh: Mesh, scale: float) -> Mesh:
    return Mesh(scale * mesh.vertices, mesh.faces)


def loose(mesh: Mesh) -> Mesh:
    """Every triangle with corners of its own."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))


def turned_at_random(mesh: Mesh, *, share=0.5) -> Mesh:
    turned = np.random.default_rng(5).random(len(mesh.faces)) < share
    return Mesh(mesh.vertices, np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces))


def jittered(mesh: Mesh, by: float) -> Mesh:
    """Loose triangles whose corners do not quite meet."""
    soup = loose(mesh)
    return Mesh(soup.vertices + by * np.random.default_rng(6).uniform(-1, 1, soup.vertices.shape), soup.faces)


def with_slivers(aspect: float) -> Mesh:
    """A saddle in which faces were cut at ``aspect`` of a side from a corner; neighbours know the new corners."""
    whole = sheet(shape=lambda x, y: 6 * x * y)
    vertices = whole.vertices.tolist()
    faces = whole.faces.tolist()
    for number in range(0, len(whole.faces), 5):
        a, b, c = faces[number]
        start = np.array(vertices[a])
        end = np.array(vertices[b])
        vertices.append((start + aspect * (end - start)).tolist())
        new = len(vertices) - 1
        neighbours = [k for k, face in enumerate(faces) if k != number and a in face and b in face]
        faces[number] = [new, b, c]
        faces.append([a, new, c])
        for k in neighbours:
            d = next(v for v in faces[k] if v not in (a, b))
            faces[k] = [b, new, d]
            faces.append([new, a, d])
    return Mesh(np.array(vertices), np.array(faces))


def with_flat_fans(count=8) -> Mesh:
    """A sheet with ``count`` more corners along one side of a face, filled with faces that have no area."""
    whole = sheet(6, 4)
    a, b, c = whole.faces[9]
    share = np.linspace(0, 1, count + 2)[1:-1, None]
    extra = whole.vertices[a] + share * (whole.vertices[b] - whole.vertices[a])
    line = [a, *(len(whole.vertices) + np.arange(count)), b]
    fan = [[c, u, v] for u, v in pairwise(line)]
    flat = [[a, v, u] for u, v in pairwise(line[1:])]
    faces = np.delete(whole.faces, 9, axis=0)
    return Mesh(np.concatenate([whole.vertices, extra]), np.concatenate([faces, fan, flat]))


def book(pages=5) -> Mesh:
    """Sheets that share one edge."""
    angle = np.linspace(0, np.pi, pages)
    out = 0.1 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    back = np.array([[0, 0, 0], [0, 0, 0.15]])
    ends = 2 + 2 * np.arange(pages)
    faces = [[[0, 1, k + 1], [0, k + 1, k]] for k in ends]
    rim = np.stack([out, out + [0, 0, 0.15]], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate([back, rim]), np.array(faces).reshape(-1, 3))


def bow_ties(count=4) -> Mesh:
    """Disks that hang together in single vertices."""
    disk = cap(0.5, rings=4)
    far = int(disk.vertices[:, 0].argmax()), int(disk.vertices[:, 0].argmin())
    step = disk.vertices[far[0]] - disk.vertices[far[1]]
    return joined(*(Mesh(disk.vertices + k * step, disk.faces) for k in range(count)))


def comb(fingers=12, *, length=0.08, width=0.004) -> Mesh:
    """A flat comb: many long fingers and gaps of the same width."""
    whole = sheet(2 * fingers - 1, 20, width=width * (2 * fingers - 1), height=length)
    middle = whole.vertices[whole.faces].mean(axis=1)
    keep = ((middle[:, 0] / width).astype(int) % 2 == 0) | (middle[:, 1] < 0.2 * length)
    faces, used = remove_unreferenced(whole.faces[keep])
    return Mesh(whole.vertices[used], faces)


def closed_tube(ratio: float, *, around=12) -> Mesh:
    """A tube with pointed ends, with a length of ``ratio`` diameters."""
    along = int(ratio * around / np.pi)
    tube = frustum(0.01, 0.01, length=0.02 * ratio, around=around, along=along)
    tips = len(tube.vertices)
    ring = np.arange(around)
    last = along * around + np.arange(around)
    low = np.stack([np.roll(ring, -1), ring, np.full(around, tips)], axis=1)
    high = np.stack([last, np.roll(last, -1), np.full(around, tips + 1)], axis=1)
    ends = [[0, 0, -0.01], [0, 0, 0.02 * ratio + 0.01]]
    return Mesh(np.concatenate([tube.vertices, ends]), np.concatenate([tube.faces, low, high]))


def klein_bottle(around=24, across=16) -> Mesh:
    """A closed one-sided surface that intersects itself."""
    turn = (np.arange(across) + 0.5) * 2 * np.pi / across  # no two vertices at one place where it passes through itself
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, turn, indexing="ij")
    r = 0.1 + 0.04 * (np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v))
    z = 0.04 * (np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v))
    vertices = np.stack([r * np.cos(u), r * np.sin(u), z], axis=-1).reshape(-1, 3)
    row = np.arange(around * across).reshape(around, across)
    row = np.concatenate([row, row[:1, ::-1]])  # glued with its sides exchanged
    a = row[:-1]
    b = row[1:]
    c = np.roll(b, -1, axis=1)
    d = np.roll(a, -1, axis=1)
    quads = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
    return Mesh(vertices, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))


def tiny_hole() -> Mesh:
    ball = sphere()
    return Mesh(ball.vertices, ball.faces[1:])


def spiked(radii: float, *, where: tuple[int, ...] = (0,), subdivisions: int = 3) -> Mesh:
    """A ball some of whose vertices are drawn out to ``radii``: nearly all of its area is on needles."""
    ball = sphere(radius=0.01, subdivisions=subdivisions)
    vertices = ball.vertices.copy()
    vertices[list(where)] *= radii
    return Mesh(vertices, ball.faces)


def star(points=24) -> Mesh:
    """A flat star with thin rays."""
    angle = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2, 0.01, 0.1)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    number = 1 + np.arange(2 * points)
    faces = np.stack([0 * number, number, np.roll(number, -1)], axis=1)
    return Mesh(np.concatenate([[[0, 0, 0]], rim]), faces)


def loose_pieces(count=2000) -> Mesh:
    """Many triangles that do not touch, around a ball."""
    rng = np.random.default_rng(8)
    corners = rng.normal(size=(count, 1, 3)) + 0.02 * rng.normal(size=(count, 3, 3))
    return joined(sphere(radius=1.0), Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)))


def random_soup(count=60) -> Mesh:
    """Faces between points at random: edges and vertices with any number of faces."""
    rng = np.random.default_rng(9)
    return Mesh(rng.normal(size=(20, 3)), rng.integers(20, size=(count, 3)))


def scan(around=400, along=250) -> Mesh:
    """A noisy torso as a scanner leaves it, 200,000 faces."""
    turn, up = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, 1, along + 1))
    radius = 0.14 + 0.02 * np.sin(2 * turn + 3 * up) + 0.015 * np.cos(7 * up) * np.sin(3 * turn)
    radius = radius * (1 - 0.3 * (up - 0.5) ** 2) + 2e-4 * np.random.default_rng(3).normal(size=turn.shape)
    vertices = np.stack([1.4 * radius * np.cos(turn), radius * np.sin(turn), 0.5 * up], axis=-1).reshape(-1, 3)
    return Mesh(vertices, frustum(around=around, along=along).faces)


def limbed(limbs: int, *, radius: float = 0.02, seed: int = 2, nodes: int = 80) -> Mesh:
    """A ball with long, bent limbs of one radius, as marching cubes extract it from a grid of ``nodes`` a side."""
    rng = np.random.default_rng(seed)
    axis = np.linspace(-0.75, 0.75, nodes)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    places = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    distance = np.linalg.norm(places, axis=1) - 0.12
    for angle in 2 * np.pi * np.arange(limbs) / limbs:
        along = np.array([np.cos(angle), np.sin(angle), 0.3 * rng.normal()])
        start = 0.1 * along
        for _ in range(5):
            along = along / np.linalg.norm(along) + 0.6 * rng.normal(size=3)
            along = along / np.linalg.norm(along)
            share = np.clip((places - start) @ along / 0.1, 0, 1)
            distance = np.minimum(
                distance, np.linalg.norm(places - start - 0.1 * share[:, None] * along, axis=1) - radius
            )
            start = start + 0.1 * along
    vertices, faces = igl.marching_cubes(distance, places, nodes, nodes, nodes, 0.0)[:2]
    return _largest_piece(Mesh(vertices, faces))


def _largest_piece(mesh: Mesh) -> Mesh:
    piece = mesh.connectivity.components
    faces, used = remove_unreferenced(mesh.faces[piece == np.bincount(piece).argmax()])
    return Mesh(mesh.vertices[used], faces)


def refined_at_random(mesh: Mesh, rounds: int = 3, *, share: float = 0.3, radius: float | None = None) -> Mesh:
    """Faces chosen at random are divided into four, round after round; their neighbours do not get the new corners.

    Args:
        mesh: Any.
        rounds: Number of rounds.
        share: Share of the faces that is divided in each.
        radius: Of a ball around the origin onto which new corners are moved [m]; by default they stay on the edges.
    """
    rng = np.random.default_rng(1)
    vertices = mesh.vertices
    faces = mesh.faces
    for _ in range(rounds):
        chosen = rng.random(len(faces)) < share
        divided = Mesh(vertices, faces[chosen]).connectivity
        middles = vertices[divided.edges].mean(axis=1)
        if radius is not None:
            middles *= radius / np.linalg.norm(middles, axis=1, keepdims=True)
        (a, b, c), (x, y, z) = faces[chosen].T, len(vertices) + divided.edge_of.T
        parts = [np.stack(part, axis=1) for part in ((a, x, z), (x, b, y), (z, y, c), (x, y, z))]
        vertices = np.concatenate([vertices, middles])
        faces = np.concatenate([faces[~chosen], *parts])
    return Mesh(vertices, faces)


def revolved(profile: np.ndarray, *, around: int = 40) -> Mesh:
    """The surface of a ring with the closed ``profile`` (p, 2) of radii and heights, counter-clockwise."""
    turn = np.arange(around) * 2 * np.pi / around
    count = len(profile)
    radius, height = np.broadcast_to(profile, (around, count, 2)).transpose(2, 0, 1)
    vertices = np.stack([radius * np.cos(turn)[:, None], radius * np.sin(turn)[:, None], height], axis=-1)
    row = np.arange(around * count).reshape(around, count)
    after = np.roll(row, -1, axis=0)
    quads = np.stack([row, after, np.roll(after, -1, axis=1), np.roll(row, -1, axis=1)], axis=-1).reshape(-1, 4)
    return clean_mesh(Mesh(vertices.reshape(-1, 3), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])))[0]


def bowl(half_angle: float = np.pi / 2, *, wall: float = 0.003, rounded: bool = False, radius: float = 0.05) -> Mesh:
    """A spherical bowl with an outer and an inner wall, joined at a sharp or a rounded rim."""
    angle = np.linspace(0, half_angle, 20)
    out = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    rim = np.zeros((0, 2))
    if rounded:
        around = np.linspace(0, np.pi, 9)[1:-1, None]
        along = np.array([np.cos(half_angle), np.sin(half_angle)])
        rim = (radius - wall / 2) * out[-1] + wall / 2 * (np.cos(around) * out[-1] + np.sin(around) * along)
    return revolved(np.concatenate([radius * out, rim, (radius - wall) * out[::-1]]))


def walled_tube(radius: float = 0.03, *, wall: float = 0.003, length: float = 0.1) -> Mesh:
    """A tube with an outer and an inner wall, joined at both ends."""
    height = np.linspace(0, length, 16)
    outer, inner = (np.stack([np.full(16, r), height], axis=1) for r in (radius, radius - wall))
    return revolved(np.concatenate([outer, inner[::-1]]))


def half_refined() -> Mesh:
    """A ball whose upper half is finer, with T-junctions on the equator."""
    ball = sphere()
    upper = ball.vertices[ball.faces].mean(axis=1)[:, 2] > 0
    fine = refined_at_random(Mesh(ball.vertices, ball.faces[upper]), 1, share=1.0)
    return joined(fine, Mesh(ball.vertices, ball.faces[~upper]))


def bricks(columns: int = 5, rows: int = 4) -> Mesh:
    """A wall of rectangles, each row offset by half a brick, so that corners of one row meet edges of the next."""
    x, y = np.meshgrid(0.02 * np.arange(columns), 0.01 * np.arange(rows))
    x = x + 0.01 * (np.arange(rows) % 2)[:, None]
    corners = np.array([[0, 0, 0], [0.02, 0, 0], [0.02, 0.01, 0], [0, 0.01, 0]])
    places = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 1, 3) + corners
    first = 4 * np.arange(len(places))[:, None, None]
    return Mesh(places.reshape(-1, 3), (first + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3))


def two_cubes() -> Mesh:
    """Two cubes that share one edge, welded."""
    return blocks([(0, 0, 0), (1, 1, 0)], size=0.1)


def _bumpy() -> Mesh:
    return frustum(0.05, 0.03, bump=0.2)


_GROUPS = {
    "faces": {
        "slivers 1e-12": lambda: with_slivers(1e-12),
        "slivers 1e-6": lambda: with_slivers(1e-6),
        "slivers 1e-3": lambda: with_slivers(1e-3),
        "flat fans": with_flat_fans,
        "zero-area faces": lambda: HARD_MESHES["zero-area faces"],
        "both sides": lambda: joined(_bumpy(), Mesh(_bumpy().vertices, _bumpy().faces[:, ::-1])),
        "needles": lambda: sheet(6, 30, width=0.3, height=0.03),
    },
    "vertices": {
        "soup": lambda: HARD_MESHES["soup"],
        "loose triangles": lambda: loose(_bumpy()),
        "nearly touching": lambda: jittered(_bumpy(), 2e-9),
        "duplicates": lambda: HARD_MESHES["duplicates"],
        "bow-ties": bow_ties,
        "unused vertices": lambda: Mesh(np.vstack([_bumpy().vertices, np.full((3, 3), 9e9)]), _bumpy().faces),
    },
    "edges": {
        "fin": lambda: HARD_MESHES["fin"],
        "book": book,
        "two cubes": two_cubes,
        "random faces": random_soup,
    },
    "junctions": {
        "half refined": half_refined,
        "refined at random": lambda: refined_at_random(sphere()),
        "round, refined at random": lambda: refined_at_random(sphere(), radius=0.05),
        "cube refined at random": lambda: refined_at_random(HARD_MESHES["cube"], 5, share=0.5),
        "bricks": bricks,
    },
    "sides": {
        "moebius": lambda: HARD_MESHES["moebius"],
        "klein bottle": klein_bottle,
        "turned at random": lambda: turned_at_random(_bumpy()),
        "inside out": lambda: Mesh(sphere().vertices, sphere().faces[:, ::-1]),
    },
    "handles": {
        "torus": torus,
        "genus 2": eight,
        "genus 4": lambda: blocks(
            {(x, y, 0) for x in range(9) for y in range(3)} - {(x, 1, 0) for x in (1, 3, 5, 7)}
        ),
    },
    "shells": {
        "inner shell": lambda: HARD_MESHES["inner shell"],
        "nested shells": lambda: joined(*(sphere(radius=r) for r in (0.02, 0.04, 0.06))),
        "overlapping parts": lambda: HARD_MESHES["overlapping parts"],
        "loose pieces": loose_pieces,
        "bowl with walls": bowl,
        "tube with walls": walled_tube,
        "nested open tubes": lambda: joined(_tube(0.2, 0.05), _tube(0.2, 0.046)),
    },
    "holes": {
        "hole": lambda: HARD_MESHES["hole"],
        "tiny hole": tiny_hole,
        "three holes": lambda: sieve(3),
        "nearly closed": lambda: cap(2.8),
        "flat with holes": lambda: Mesh(eight().vertices * [1, 1, 1e-9], eight().faces),
    },
    "scales": {
        "scale 1e-6": lambda: scaled(_bumpy(), 1e-6),
        "scale 1e6": lambda: scaled(_bumpy(), 1e6),
        "offset 1e6": lambda: moved(_bumpy(), (1e6, -1e6, 1e6)),
        "small and far": lambda: moved(scaled(_bumpy(), 1e-3), (1.0, 2.0, 3.0)),
    },
    "few": {
        "one triangle": lambda: HARD_MESHES["one triangle"],
        "two triangles": lambda: HARD_MESHES["flat plate"],
        "tetrahedron": lambda: Mesh(0.1 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
                                    [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]),
        "one wide": lambda: sheet(20, 1),
        "cube": lambda: HARD_MESHES["cube"],
    },
    "shapes": {
        "tube 50": lambda: closed_tube(50),
        "tube 300": lambda: closed_tube(300),
        "open tube 50": lambda: frustum(0.01, 0.01, length=1.0, around=16, along=250),
        "strip 1000": lambda: Mesh(sheet(6, 5).vertices * [700, 1, 1], sheet(6, 5).faces),
        "strip 100,000": lambda: Mesh(sheet(6, 5).vertices * [7e4, 1, 1], sheet(6, 5).faces),
        "needle 300": lambda: spiked(300),
        "needle 1000": lambda: spiked(1000),
        "two needles": lambda: spiked(1000, where=(0, 3)),
        "comb": comb,
        "comb 50": lambda: comb(50, length=0.8),
        "spike": lambda: HARD_MESHES["thin spike"],
        "star": star,
        "spiral": spiral,
        "limbs": lambda: limbed(6, radius=0.025, nodes=70),
        "limbs and handles": lambda: limbed(6, radius=0.025, seed=1, nodes=60),
        "rod": lambda: solid(trimesh.creation.cylinder(0.02, 0.3, sections=24)),
    },
}  # fmt: skip


GROUPS = {group: tuple(meshes) for group, meshes in _GROUPS.items()}
_MAKERS = {name: maker for meshes in _GROUPS.values() for name, maker in meshes.items()}

HOPELESS = {
    **HOPELESS_MESHES,
    "one line twice": Mesh([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3]], [[0, 1, 2], [1, 2, 3]]),
    "scale 1e100": scaled(HARD_MESHES["cube"], 1e100),
    "scale 1e-100": scaled(HARD_MESHES["cube"], 1e-100),
    "1e-9 thin": Mesh([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]], [[0, 1, 2]]),
}
"""Meshes of which no map can be made."""


@cache
def hard_mesh(name: str) -> Mesh:
    """Return a mesh of the catalogue."""
    return _MAKERS[name]()
