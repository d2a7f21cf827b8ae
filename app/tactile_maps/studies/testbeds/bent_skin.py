"""A piece of skin of given curvature on a link of a robot; only the skin is bent, place and posture stay the same.

The piece is a disc of a surface of revolution: across the link an arc of constant curvature, rotated about an axis so
that the curvature along the link has the other value in the middle. Equal curvatures give a sphere, opposite ones the
inner side of a torus, a single one a cylinder, none a plate.
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
"""Radii of the bodies [m]."""
_DIRECTIONS = {"cylinder": (1.0, 0.0), "sphere": (1.0, 1.0), "saddle": (1.0, -1.0)}
BODIES: Mapping[str, tuple[float, float]] = {
    "plate": (0.0, 0.0),
    **{
        f"{name} of {1e3 * radius:g} mm": (across / radius, along / radius)
        for name, (across, along) in _DIRECTIONS.items()
        for radius in RADII
    },
}
"""Curvature across and along the link [1/m], positive where the body bulges."""
REACH = 0.045
"""Distance from the middle to the border [m]: a path of 30 mm keeps 20 mm from the border."""
HEIGHT = 0.03
"""Height of the middle above the skin of the link [m], so that the curved piece does not touch the link."""
_EDGE = 0.0035
"""Edge length of the triangles [m]: ten triangles for a taxel at 8 mm, as on the robots' own links."""


def with_bent_skin(
    prepared: PreparedScene, taxel: int, curvature: tuple[float, float], *, pitch: float, seed: int = 0
) -> tuple[PreparedScene, int]:
    """Return the same robot with a piece of bent skin as its only skin, and the taxel nearest to its middle.

    Args:
        prepared: Robot and skin.
        taxel: Taxel below the middle; the piece is mounted on its link.
        curvature: Curvature across and along the link [1/m].
        pitch: Spacing of the taxels [m], whose square is the area of a taxel.
        seed: Seed of their places.

    Raises:
        TactileMapsError: The triangles are too coarse for the pitch, or the piece cannot be flattened.

    Cost: 0.2 s.
    """
    at = prepared.skin.taxel_point(taxel)
    original = prepared.skin.patches[at.patch]
    flat = bent_disc(curvature)
    own = original.taxels.normals[taxel - prepared.skin.first[at.patch]]
    frame = _frame(own, original.surface.vertices)
    middle = prepared.skin.position(at) + HEIGHT * own
    surface = Mesh(middle + flat.vertices @ frame, flat.faces)
    taxels = place_evenly(surface, round(surface.area / pitch**2), seed=seed)
    skin = Skin((Patch("bent", original.link, surface, taxels),))
    nearest = int(np.argmin(np.linalg.norm(taxels.positions - middle, axis=1)))
    return replace(prepared, skin=skin, map=build_map(skin)), nearest


def bent_disc(curvature: tuple[float, float]) -> Mesh:
    """Return a disc about the origin with its normal along z there: bent across (x) and along (y)."""
    sheet = square_sheet(2 * round(2 * REACH / _EDGE) ** 2, size=2 * REACH)
    plane = sheet.vertices[:, :2] - REACH
    inside = np.linalg.norm(plane[sheet.faces].mean(axis=1), axis=1) <= REACH
    faces, kept = remove_unreferenced(sheet.faces[inside])
    across, along = plane[kept].T
    x, sunk = _arc(across, curvature[0])
    y, lower = _arc(along, curvature[1])
    # Rotated about an axis, a lower point follows a smaller circle, or a larger one if the axis is above.
    turn = curvature[1] * along
    return Mesh(np.stack([x, y + sunk * np.sin(turn), lower + sunk * np.cos(turn)], axis=1), faces)


def _arc(way: FloatArray, curvature: float) -> tuple[FloatArray, FloatArray]:
    """Distance (n,) and height (n,) along an arc that starts level, after an arc length ``way`` (n,) [m]."""
    half = np.sinc(curvature * way / (2 * np.pi))
    return way * np.sinc(curvature * way / np.pi), -curvature * way**2 / 2 * half**2


def _frame(normal: FloatArray, points: FloatArray) -> FloatArray:
    """(3, 3) rows: across and along the longest extent of a link (n, 3), and the normal (3,)."""
    longest = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along = longest - (longest @ normal) * normal
    along /= np.linalg.norm(along)
    return np.stack([np.cross(along, normal), along, normal])
