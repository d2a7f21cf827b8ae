"""Meshes without volume: MuJoCo refuses them unless told how to weigh them and not to collide with them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from app.errors import Finding
from app.geometry.mesh import Mesh
from app.robots.mesh_file import parse_mesh

_FLAT = 1e-5  # thickness over size below which there is no convex hull
_MARGIN = 3e-5  # by which the triangle inequality of inertias must hold
_HOLLOW = 1e-6  # enclosed volume over that of the bounding box below which it carries no mass


def settle_thin_meshes(spec: mujoco.MjSpec, assets: Mapping[str, bytes]) -> list[Finding]:
    """Weigh open sheets as shells, and stop flat ones, which have no convex hull, from colliding (a Finding)."""
    flat = set()
    for element in spec.meshes:
        if element.file not in assets:
            continue
        mesh = parse_mesh(assets[element.file], Path(element.file))
        if _is_flat(mesh):
            flat.add(element.name)
        if element.name in flat or _is_hollow(mesh):
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    stopped = [geom for geom in spec.geoms if geom.meshname in flat and (geom.contype or geom.conaffinity)]
    for geom in stopped:
        geom.contype = geom.conaffinity = 0
    names = ", ".join(sorted({geom.meshname for geom in stopped}))
    return [Finding("flat-mesh", names, "drawn, but nothing collides with it", len(stopped))] if stopped else []


def keep_inertias_valid(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """State the inertia of sheet-like bodies so that it survives being written with six digits.

    Principal moments must obey A + B >= C. A sheet has A + B = C, and rounding may tip it over; so C gives way by a
    few parts in 100,000, less than anyone knows a robot's inertia.
    """
    for body in range(1, model.nbody):
        inertia = np.array(model.body_inertia[body])
        largest = int(inertia.argmax())
        bound = (1 - _MARGIN) * (inertia.sum() - inertia[largest])
        if 0 < bound < inertia[largest]:
            inertia[largest] = bound
            element = spec.body(model.body(body).name)
            element.explicitinertial, element.mass = True, float(model.body_mass[body])
            element.ipos, element.iquat, element.inertia = model.body_ipos[body], model.body_iquat[body], inertia
            element.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
            element.fullinertia = np.full(6, np.nan)  # MuJoCo's mark for "not given"


def _is_flat(mesh: Mesh) -> bool:
    centred = mesh.vertices - mesh.vertices.mean(axis=0)
    spread = np.linalg.eigvalsh(centred.T @ centred)  # squared, so this resolves thickness down to about 1e-8
    return len(mesh.vertices) < 4 or bool(spread[0] < _FLAT**2 * spread[-1])


def _is_hollow(mesh: Mesh) -> bool:
    corners = (mesh.vertices - mesh.vertices.mean(axis=0))[mesh.faces]
    volume = abs(float(np.linalg.det(corners).sum())) / 6
    return volume < _HOLLOW * float(np.prod(np.ptp(mesh.vertices, axis=0)))
