"""Covers around open surfaces: links whose mesh is a sheet without thickness, with taxels on both sides."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.connectivity import flip_faces, orient_faces
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Skin

BOTH_SIDES = "both-sides"
"""Kind of the findings about open surfaces that the cover goes around."""
_SECOND_SIDE = 0.2
"""Smallest share of the taxels of a surface on its second side."""
_ACTION = (
    "an open surface: the cover goes around it, so that both sides have taxels. For one side, run tactile-maps map "
    "MESH -o skin.csv, and open skin.csv without a robot"
)


def two_sided_findings(skin: Skin, meshes: Mapping[str, Mesh]) -> list[Finding]:
    """Return a finding for each link that is mostly an open surface with taxels on both sides.

    Args:
        skin: Cover of the links.
        meshes: Cleaned mesh of each link, by name.
    """
    links = dict.fromkeys(patch.link for patch in skin.patches)
    return [Finding(BOTH_SIDES, link, _ACTION) for link in links if _has_both_sides(skin, link, meshes[link])]


def _has_both_sides(skin: Skin, link: str, mesh: Mesh) -> bool:
    """Whether at least half of the link's taxels are on open surfaces that have taxels on both sides."""
    open_faces = mesh.connectivity.boundary_sides // 3
    if not len(open_faces):
        return False
    positions = np.concatenate([patch.taxels.positions for patch in skin.patches if patch.link == link])
    oriented = orient_faces(mesh.faces, mesh.face_areas)
    component = oriented.component
    count = int(component.max()) + 1
    faces, sides = _sides(Mesh(mesh.vertices, flip_faces(mesh.faces, oriented.turned)), positions)
    taxels = np.array([np.bincount(component[faces], side, count) for side in (sides, 1.0 - sides)])
    is_open = np.bincount(component[open_faces], minlength=count) > 0
    both = is_open & (taxels.min(axis=0) >= _SECOND_SIDE * taxels.sum(axis=0))
    return bool(2.0 * taxels[:, both].sum() >= len(positions))


def _sides(mesh: Mesh, positions: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the closest face to each of ``positions`` (k, 3), and 1 on the side of its normal, else 0."""
    faces, weights, _ = ClosestPoint(mesh).query(positions)
    away = positions - mesh.points(faces, weights)
    return faces, (np.vecdot(away, mesh.face_normals[faces]) > 0).astype(np.float64)
