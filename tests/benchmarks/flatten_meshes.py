"""Sixteen meshes of four kinds for comparing flattening methods, at a given resolution, and a disk of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactile_maps.flattening.cut import cut_to_disk, far_points, farthest_from_border
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.library import load_robot
from tests.support.surfaces import cap, frustum, sheet, torus


def _side(faces: int) -> int:
    return round(np.sqrt(faces / 2))


def _tube(faces: int, *, radius: Callable, bend: float = 0.0, length: float = 0.25) -> Mesh:
    """Return a tube, open at both ends, with ``radius`` of angle and height (0 to 1), bent by ``bend`` [rad]."""
    n = _side(faces)
    straight = frustum(1.0, 1.0, length=1.0, around=n, along=n)
    angle = np.arctan2(straight.vertices[:, 1], straight.vertices[:, 0])
    up = straight.vertices[:, 2]
    r = radius(angle, up)
    turn = bend * up
    out = length / bend if bend else 0.0
    x = r * np.cos(angle)
    if not bend:
        return Mesh(np.stack([x, r * np.sin(angle), length * up], axis=1), straight.faces)
    vertices = np.stack([(out + x) * np.cos(turn) - out, r * np.sin(angle), (out + x) * np.sin(turn)], axis=1)
    return Mesh(vertices, straight.faces)


def _shell(faces: int, height: Callable) -> Mesh:
    n = _side(faces)
    return sheet(n, n, width=0.2, height=0.2, shape=lambda x, y: height(x / 0.2, y / 0.2))


def _body(faces: int, radius: Callable, *, opening: float = 0.25) -> Mesh:
    """Return a ball with a hole at the bottom and a radius that depends on the direction."""
    n = round(np.sqrt(faces / 6))
    ball = cap(np.pi - opening, rings=n, radius=1.0)
    return Mesh(ball.vertices * radius(ball.vertices)[:, None], ball.faces)


def _noise(seed: int, waves: int, height: float) -> Callable:
    generator = np.random.default_rng(seed)
    directions = generator.normal(size=(waves, 3))
    phases = generator.uniform(0, 2 * np.pi, waves)
    return lambda v: height * np.cos(3 * v @ directions.T + phases).mean(axis=1)


def _link(robot: str, link: str, faces: int) -> Mesh:
    """Return the closed cover of a robot's link."""
    mesh = load_robot(robot).link(link).mesh
    voxel = float(np.sqrt(mesh.area / faces * 2.6))
    return wrap_mesh(mesh, thickness=0.004, voxel=voxel, closing=0.012).surface


def _limb(v: np.ndarray) -> np.ndarray:
    """Return a shoulder with an arm stump and a neck."""
    bumps = ((0.9, [1, 0, 0.2], 6.0), (0.6, [-0.3, 0.2, 1], 8.0), (0.5, [-0.6, -0.7, -0.2], 7.0))
    units = [np.asarray(d) / np.linalg.norm(d) for _, d, _ in bumps]
    return 0.08 * (1 + sum(h * np.exp(s * (v @ u - 1)) for (h, _, s), u in zip(bumps, units, strict=True)))


MESHES: dict[str, tuple[str, Callable[[int], Mesh]]] = {
    "cylinder": ("tube", lambda n: _tube(n, radius=lambda a, u: 0.04 + 0 * u)),
    "tapered, bent forearm": ("tube", lambda n: _tube(n, radius=lambda a, u: 0.05 - 0.02 * u, bend=0.9)),
    "waved tube": ("tube", lambda n: _tube(n, radius=lambda a, u: 0.04 * (1 + 0.25 * np.sin(3 * a) * np.sin(9 * u)))),
    "hourglass": ("tube", lambda n: _tube(n, radius=lambda a, u: 0.02 + 0.12 * (u - 0.5) ** 2)),
    "hemisphere": ("shell", lambda n: cap(np.pi / 2, rings=round(np.sqrt(n / 6)), radius=0.08)),
    "saddle": ("shell", lambda n: _shell(n, lambda x, y: 0.15 * (x - 0.5) ** 2 - 0.15 * (y - 0.5) ** 2)),
    "bump": ("shell", lambda n: _shell(n, lambda x, y: 0.12 * np.exp(-((x - 0.5) ** 2 + (y - 0.5) ** 2) / 0.02))),
    "egg crate": ("shell", lambda n: _shell(n, lambda x, y: 0.02 * np.sin(12 * x) * np.cos(12 * y))),
    "arm forearm": ("closed link", lambda n: _link("arm", load_robot("arm").links[-3].name, n)),
    "UR5e upper arm": ("closed link", lambda n: _link("ur5e", "upper_arm_link", n)),
    "iCub forearm": ("closed link", lambda n: _link("icub", "l_forearm", n)),
    "torus": ("closed link", lambda n: torus(around=round(np.sqrt(n)), across=round(np.sqrt(n) / 2))),
    "torso": ("organic", lambda n: _body(n, lambda v: 0.1 * (1 + 0.3 * np.abs(v[:, 0]) + _noise(1, 9, 0.4)(v)))),
    "head": ("organic", lambda n: _body(n, lambda v: 0.09 * (1 + _noise(2, 25, 0.5)(1.6 * v)), opening=0.5)),
    "shoulder": ("organic", lambda n: _body(n, _limb)),
    "lumpy": ("organic", lambda n: _body(n, lambda v: 0.08 * (1 + _noise(3, 12, 0.9)(2 * v)))),
}


def disk_of(surface: Mesh) -> Disk:
    """Cut a surface to the disk that all methods flatten, with one more seam if it is closed."""
    if surface.connectivity.boundary_loops:
        return Disk.of(surface, cut_to_disk(surface))
    ends = far_points(surface)
    first = cut_to_disk(surface, terminals=ends)
    return Disk.of(surface, cut_to_disk(surface, terminals=[*ends, farthest_from_border(surface, first)]))
