"""Taxels on a surface as a person asks for them."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import SkinError
from app.geometry.closest import barycentric
from app.geometry.mesh import Mesh
from app.geometry.subdivide import Subdivided, subdivide
from app.skin.place import place_taxels
from app.skin.placement_spec import MODULE_PITCH, Painted, PlacementSpec
from app.skin.placing.density import face_density
from app.skin.placing.keep_out import allowed_faces
from app.skin.placing.lattice import place_lattice
from app.skin.placing.modules import place_modules
from app.skin.taxels import Taxels

EDGES_PER_PITCH = 2.5
"""Faces are divided until a taxel is this many edges across, so that its cell has about a dozen."""
HEXAGON = np.sqrt(3) / 2
"""Area of a taxel with six neighbours, in pitches squared."""


def place(surface: Mesh, spec: PlacementSpec) -> Taxels:
    """Place taxels on a surface that is fine enough for them.

    Args:
        surface: Connected, manifold, no face without area [m].
        spec: What is wanted; a painted density or zone has one value for each of the surface's vertices.

    Raises:
        SkinError: An edge is longer than the pitch (``divided`` helps), nothing is left outside the zones, more taxels
            are asked for than there are faces, or not one module fits.

    Cost: 1000 taxels on 26,000 faces take 0.6 s evenly or as a lattice; 100 modules 1 s.
    """
    allowed = allowed_faces(surface, spec.keep_out)
    room = float(surface.face_areas[allowed].sum())
    pitch = _pitch(spec, room)
    if spec.taxels != 1:
        _refuse_coarse(surface, pitch)
    if spec.pattern == "modules":
        return place_modules(surface, pitch, allowed=allowed, seed=spec.seed)
    count = spec.taxels or max(1, round(room / (HEXAGON * pitch**2)))
    if spec.pattern == "hexagonal":
        return place_lattice(surface, count, pitch, allowed=allowed, seed=spec.seed)
    if spec.pattern == "even":
        density = None if spec.density is None else face_density(surface, spec, pitch=pitch)
        return place_taxels(surface, count, seed=spec.seed, density=density, allowed=allowed)
    assert_never(spec.pattern)


def divided(surface: Mesh, spec: PlacementSpec) -> tuple[Subdivided, PlacementSpec]:
    """The surface made fine enough for ``spec``, with the same shape, and ``spec`` with what is painted carried over.

    Raises:
        SkinError: As ``place``.
        MeshError: It would take more than two million faces.
    """
    room = float(surface.face_areas[allowed_faces(surface, spec.keep_out)].sum())
    pitch = _pitch(spec, room)
    if spec.density is not None:
        wanted = face_density(surface, spec, pitch=pitch)
        pitch /= np.sqrt(wanted.max() / np.average(wanted, weights=surface.face_areas))
    fine = subdivide(surface, longest=pitch / EDGES_PER_PITCH)
    corners, weights = _origins(surface, fine)
    density = spec.density
    if density is not None and not isinstance(density, str):
        density = (density[corners] * weights).sum(axis=1)
    zones = [
        # A new vertex is marked where any corner is that it lies between, so that the painted zone does not shrink.
        Painted(np.any(zone.vertices[corners] & (weights > 0), axis=1)) if isinstance(zone, Painted) else zone
        for zone in spec.keep_out
    ]
    return fine, replace(spec, density=density, keep_out=tuple(zones))


def _pitch(spec: PlacementSpec, room: float) -> float:
    """The pitch [m] on average over ``room`` [m²]."""
    if spec.pitch is not None:
        return spec.pitch
    return MODULE_PITCH if spec.taxels is None else float(np.sqrt(room / (HEXAGON * spec.taxels)))


def _refuse_coarse(surface: Mesh, pitch: float) -> None:
    ends = surface.vertices[surface.edges]
    longest = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
    if longest > pitch:
        raise SkinError(
            "the surface is too coarse for so fine a pitch",
            place="pitch",
            value=f"edges up to {1e3 * longest:.3g} mm, a pitch of {1e3 * pitch:.3g} mm",
            remedy="Divide the surface first, or ask for a larger pitch",
        )


def _origins(coarse: Mesh, fine: Subdivided) -> tuple[IntArray, FloatArray]:
    """(n, 3) coarse corners that each fine vertex lies between, and its barycentric weights there."""
    face = np.zeros(len(fine.mesh.vertices), dtype=np.int64)
    face[fine.mesh.faces.ravel()] = np.repeat(fine.parent, 3)
    corners = coarse.faces[face]
    weights = barycentric(coarse.vertices[corners], fine.mesh.vertices)
    return corners, np.where(weights < 1e-9, 0.0, weights)
