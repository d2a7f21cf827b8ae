"""A piece of skin of stated curvature on a robot's link: what bends is the skin alone, place and posture stay the same.

The piece is a disc of a surface of revolution: across the link an arc of constant curvature, which is turned about an
axis so that along the link the curvature in the middle is the other one. Equal curvatures make a sphere, opposite ones
the inner side of a torus, one alone a cylinder, none a plate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.connectivity import remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.studies.testbeds.reference_bodies import square_sheet

RADII = (0.08, 0.04)
"""Of the bodies [m]."""
_DIRECTIONS = {"cylinder": (1.0, 0.0), "sphere": (1.0, 1.0), "saddle": (1.0, -1.0)}
BODIES: Mapping[str, tuple[float, float]] = {
    "plate": (0.0, 0.0),
    **{
        f"{name} of {1e3 * radius:g} mm": (across / radius, along / radius)
        for name, (across, along) in _DIRECTIONS.items()
        for radius in RADII
    },
}
"""Curvature across and along the link [1/m], above zero where the body bulges."""
REACH = 0.045
"""From the middle to the border [m]: a path of 30 mm keeps 20 mm off it."""
HEIGHT = 0.03
"""Of the middle above the link's own skin [m], so that what curves away does not meet the link."""
_EDGE = 0.0035
"""Of the triangles [m]: ten of them a taxel 8 mm apart, as on the robots' own links."""


def with_bent_skin(
    prepared: PreparedScene, taxel: int, curvature: tuple[float, float], *, pitch: float, seed: int = 0
) -> tuple[PreparedScene, int]:
    """The same robot with nothing but such a piece as its skin, and the taxel nearest to its middle.

    Args:
        prepared: Robot and skin.
        taxel: Over which the middle lies; the piece is mounted on its link.
        curvature: Across and along the link [1/m].
        pitch: Spacing of the taxels [m], the square of which is a taxel's area.
        seed: Of their places.

    Raises:
        TactileMapsError: The triangles are too coarse for such a pitch, or the piece cannot be flattened.

    Cost: 0.2 s.
    """
    at = prepared.skin.taxel_point(taxel)
    worn = prepared.skin.patches[at.patch]
    flat = bent_disc(curvature)
    own = worn.taxels.normals[taxel - prepared.skin.first[at.patch]]
    frame = _frame(own, worn.surface.vertices)
    middle = prepared.skin.position(at) + HEIGHT * own
    surface = Mesh(middle + flat.vertices @ frame, flat.faces)
    taxels = place_evenly(surface, round(surface.area / pitch**2), seed=seed)
    skin = Skin((Patch("bent", worn.link, surface, taxels),))
    nearest = int(np.argmin(np.linalg.norm(taxels.positions - middle, axis=1)))
    return replace(prepared, skin=skin, map=build_map(skin)), nearest


def bent_disc(curvature: tuple[float, float]) -> Mesh:
    """A disc about the origin, its normal there along z: bent across, which is along x, and along y."""
    sheet = square_sheet(2 * round(2 * REACH / _EDGE) ** 2, size=2 * REACH)
    plane = sheet.vertices[:, :2] - REACH
    inside = np.linalg.norm(plane[sheet.faces].mean(axis=1), axis=1) <= REACH
    faces, kept = remove_unreferenced(sheet.faces[inside])
    across, along = plane[kept].T
    x, sunk = _arc(across, curvature[0])
    y, lower = _arc(along, curvature[1])
    # Turned about an axis, what lies lower goes along a smaller circle, or a greater one where the axis is above.
    turn = curvature[1] * along
    return Mesh(np.stack([x, y + sunk * np.sin(turn), lower + sunk * np.cos(turn)], axis=1), faces)


def _arc(way: FloatArray, curvature: float) -> tuple[FloatArray, FloatArray]:
    """Where one comes (n,) and how far up (n,) along an arc that begins level, after ``way`` (n,) [m]."""
    half = np.sinc(curvature * way / (2 * np.pi))
    return way * np.sinc(curvature * way / np.pi), -curvature * way**2 / 2 * half**2


def _frame(normal: FloatArray, points: FloatArray) -> FloatArray:
    """(3, 3) rows: across and along a link's longest way (n, 3), and the normal (3,)."""
    longest = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along = longest - (longest @ normal) * normal
    along /= np.linalg.norm(along)
    return np.stack([np.cross(along, normal), along, normal])
