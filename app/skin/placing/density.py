"""How many taxels per area, relative to other places of the surface."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.geometry.topology import averaging
from app.skin.placement_spec import PlacementSpec

MOST = 4.0
"""At most this many times as many taxels per area where the surface bends, so at half the pitch."""


def face_density(surface: Mesh, spec: PlacementSpec, *, pitch: float) -> FloatArray:
    """(m,) the density that ``spec`` asks for on each face; ones where it asks for none.

    Args:
        surface: To place on.
        spec: What is wanted.
        pitch: Curvature is averaged over about this distance [m]; finer bends are between the taxels.

    Raises:
        SkinError: The density has not one value for each vertex.
    """
    if spec.density is None:
        return np.ones(len(surface.faces))
    wanted = bending_density(surface, over=pitch) if isinstance(spec.density, str) else spec.density
    if len(wanted) != len(surface.vertices):
        value = f"{len(wanted)} for {len(surface.vertices)} vertices"
        raise SkinError("a density needs one value for each vertex", place="density", value=value)
    return np.asarray(wanted[surface.faces].mean(axis=1))


def bending_density(surface: Mesh, *, over: float) -> FloatArray:
    """(n,) from 1 where the surface is flat towards ``MOST`` where it bends far more than on average.

    With k the curvature and r its root mean square over the surface, 1 + 3 k² / (k² + r²): bounded, and the same for
    the same shape at another size.
    """
    squared = curvature(surface) ** 2
    average = averaging(surface.edges, len(surface.vertices))
    side = float(np.sqrt(surface.area / max(len(surface.faces), 1)))
    for _ in range(int(np.clip((over / side) ** 2, 1, 50))):  # steps of a random walk reach as far as their root
        squared = (squared + average @ squared) / 2
    share = np.bincount(surface.faces.ravel(), np.repeat(surface.face_areas, 3), len(surface.vertices))
    usual = float((squared * share).sum() / share.sum())
    flat = usual * surface.area < 1e-12  # bends by less than a millionth over its own size
    return np.ones(len(squared)) if flat else 1.0 + (MOST - 1.0) * squared / (squared + usual)


def curvature(surface: Mesh) -> FloatArray:
    """(n,) root of the sum of the squared principal curvatures at each vertex [1/m]: 1/r on a cylinder, √2/r on a ball.

    It is the size of the normals' gradient over each face (Rusinkiewicz 2004), averaged by area.
    """
    corners, normals = surface.vertices[surface.faces], surface.vertex_normals[surface.faces]
    twice = 2 * surface.face_areas
    # The gradient of a corner's weight is the side opposite to it, turned by a right angle in the face's plane.
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    slopes = np.cross(surface.face_normals[:, None], opposite) / np.where(twice > 0, twice, np.inf)[:, None, None]
    gradient = np.linalg.norm(np.einsum("mci,mcj->mij", normals, slopes), axis=(1, 2))
    total = np.bincount(surface.faces.ravel(), np.repeat(gradient * twice, 3), len(surface.vertices))
    weight = np.bincount(surface.faces.ravel(), np.repeat(twice, 3), len(surface.vertices))
    return total / np.where(weight > 0, weight, 1.0)
