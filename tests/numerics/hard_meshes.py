"""A named catalogue of meshes as they come from files: sound ones, and every defect that real ones have.

``HARD_MESHES[name]`` are those that robots' links come as, ``one_link`` makes a robot of one. ``hard_groups`` has the
wider catalogue of meshes to be laid flat as they are.
"""

from __future__ import annotations

import numpy as np
import trimesh

from app.geometry.mesh import Mesh
from app.robots.robot import Link, Robot


def _mesh(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(shape.vertices), np.asarray(shape.faces))


def _sphere(radius: float = 0.1) -> Mesh:
    return _mesh(trimesh.creation.icosphere(subdivisions=3, radius=radius))


def _cube() -> Mesh:
    return _mesh(trimesh.creation.box((0.2, 0.15, 0.1)))


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])[:-1]
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def moved(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    return Mesh(mesh.vertices + by, mesh.faces)


def _tube(length: float = 0.3, radius: float = 0.05, around: int = 40, along: int = 16) -> Mesh:
    """Open at both ends."""
    angle, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, length, along + 1))
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = (i * around + j).ravel(), (i * around + (j + 1) % around).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]))


def _soup() -> Mesh:
    """Every triangle on its own, some turned over, some missing."""
    rng, sphere = np.random.default_rng(7), _sphere()
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
    return joined(_sphere(), moved(_mesh(trimesh.creation.cone(radius=0.008, height=0.25)), (0, 0, 0.09)))


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
    "torus": _mesh(trimesh.creation.torus(0.1, 0.04)),
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
