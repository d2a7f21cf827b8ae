"""Skin on a bare mesh without a robot or a wrap: the taxels are on the triangles of the mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactile_maps.core.arrays import BoolArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.geometry.inner_walls import inner_walls
from tactile_maps.geometry.remesh.repair import repair_mesh
from tactile_maps.geometry.surface.connectivity import (
    components_of,
    manifold_twins,
    remove_unreferenced,
    split_nonmanifold,
)
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.raycast import outer_faces, without_islands
from tactile_maps.skin.model.skin import LOW_COVERAGE, Patch, Skin, Taxels, low_coverage, patch_name
from tactile_maps.skin.taxel_placement.placement import (
    HEXAGON_AREA,
    MODULE_PITCH,
    PlacementSpec,
    place_taxels,
    refine_for_spec,
)
from tactile_maps.skin.taxel_placement.sampling import share_by_area

_Part = tuple[Mesh, PlacementSpec]

MIN_COMPONENT_AREA = 0.5
"""Area of a piece, in areas of a taxel, below which it stays bare."""


@dataclass(frozen=True, eq=False)
class _Surface:
    """A repaired mesh or its visible part: ``vertex_of`` (k,) original vertices, ``piece`` (m,) pieces of the faces."""

    mesh: Mesh
    vertex_of: IntArray
    piece: IntArray


@dataclass(frozen=True, eq=False)
class _Divided:
    """A repaired mesh, its pieces that get taxels, the number of other pieces, and findings."""

    mesh: Mesh
    parts: list[_Part]
    small: int
    findings: tuple[Finding, ...]


def skin_of_mesh(
    mesh: Mesh,
    spec: PlacementSpec | None = None,
    *,
    name: str = "mesh",
    surface: Literal["outer", "all"] = "outer",
    progress: Progress = no_progress,
) -> Skin:
    """Place taxels on any mesh, with one patch for each connected piece of its surface.

    The mesh is repaired first. Its triangles keep their places, and are divided only where they are too coarse.

    Args:
        mesh: Mesh in any state [m], in the frame of the link that the skin covers.
        spec: Specification of the taxels of all pieces; painted values are those of the vertices of the mesh. The
            default is 1000 evenly spaced taxels.
        name: Name of the mesh, its link and its patches.
        surface: ``outer`` leaves parts bare that are not visible from outside (inner shells, parts within parts) and
            the inner walls of thin shells.
        progress: Receives a text and the fraction done, 0 to 1; may raise to cancel.

    Raises:
        MeshError: The mesh has no area, or would need more than two million faces.
        SkinError: No piece is large enough for a taxel, or none has room for the specified taxels.

    Cost: 1 s for 1000 taxels on 20,000 faces.
    """
    spec = spec or PlacementSpec(taxels=1000)
    found = _divide(mesh, spec, name, surface, progress)
    patches, refused = _patches(found.parts, name, progress)
    skin = Skin(patches, bare_area=_bare_area(found.mesh, patches))
    low = _low_coverage(found, name, skin.coverage, skin.bare_area, len(refused))
    return replace(skin, findings=(*found.findings, *refused, *low))


def findings_of_mesh(mesh: Mesh, *, name: str = "mesh") -> tuple[Finding, ...]:
    """Return the findings of ``skin_of_mesh`` with its defaults, without placing taxels, which fit on every piece.

    Raises:
        MeshError: The mesh has no area.
        SkinError: No piece is large enough for a taxel.

    Cost: 60 % of ``skin_of_mesh``.
    """
    found = _divide(mesh, PlacementSpec(taxels=1000), name, "outer", no_progress)
    bare = found.mesh.area - sum(part.area for part, _ in found.parts)
    return (*found.findings, *_low_coverage(found, name, 1.0 - bare / found.mesh.area, bare, 0))


def _divide(
    mesh: Mesh, spec: PlacementSpec, name: str, surface: Literal["outer", "all"], progress: Progress
) -> _Divided:
    """Repair a mesh, and divide its surface into the pieces that get taxels."""
    progress(f"Repairing {name}", 0.0)
    repaired = repair_mesh(mesh, where=name)
    whole = _Surface(repaired.mesh, repaired.vertex_of, repaired.component)
    notes = list[Finding]()
    if surface == "outer":
        progress(f"Finding the visible surface of {name}", 0.2)
        whole, notes = _outer_surface(whole, _min_component_area(whole.mesh, spec), name)
    parts, small = _components_with_specs(whole, spec, name)
    add_finding(notes, "small-piece", name, "not covered: too small for a taxel", small)
    return _Divided(whole.mesh, parts, small, (*repaired.findings, *notes))


def _low_coverage(found: _Divided, name: str, coverage: float, bare: float, refused: int) -> tuple[Finding, ...]:
    """Return the finding about a low coverage; ``bare`` is the area without taxels [m²], of ``refused`` pieces too."""
    if coverage >= LOW_COVERAGE:
        return ()
    too_small = found.mesh.area - sum(part.area for part, _ in found.parts)
    reasons = f"{found.small} pieces ({_area_text(too_small)}) are too small for a taxel"
    if refused:
        reasons += f", {refused} ({_area_text(bare - too_small)}) have no room for taxels"
    remedy = "join the pieces of the mesh, or place more taxels"
    return (low_coverage(name, coverage, reasons, remedy, found.small + refused),)


def _bare_area(mesh: Mesh, patches: tuple[Patch, ...]) -> float:
    """Return the area of ``mesh`` without taxels [m²], without rounding errors."""
    bare = mesh.area - sum(patch.surface.area for patch in patches)
    return bare if bare > 1e-9 * mesh.area else 0.0


def _area_text(area: float) -> str:
    return f"{1e4 * area:.3g} cm²"


def _patches(parts: list[_Part], name: str, progress: Progress) -> tuple[tuple[Patch, ...], list[Finding]]:
    """Return a patch on each part with room for its taxels, and findings about the others."""
    patches = list[Patch]()
    refusals = list[SkinError]()
    for number, (part, spec) in enumerate(parts):
        progress(f"Placing taxels on {name}", 0.4 + 0.6 * number / len(parts))
        try:
            fine, own = refine_for_spec(part, spec)
            taxels = _numbered_on(place_taxels(fine.mesh, own), patches)
            patches.append(Patch(patch_name(name, len(patches)), name, fine.mesh, taxels))
        except SkinError as refusal:
            refusals.append(refusal)
    if not patches:
        raise refusals[0]
    return tuple(patches), [Finding("bare-piece", name, f"not covered: {refusal.problem}") for refusal in refusals]


def _numbered_on(taxels: Taxels, before: list[Patch]) -> Taxels:
    """Return the taxels with module numbers that continue those of the patches before."""
    modules = taxels.identity.modules
    used = [patch.taxels.identity.modules.max() for patch in before if patch.taxels.identity.modules is not None]
    if modules is None or not used:
        return taxels
    return replace(taxels, identity=replace(taxels.identity, modules=modules + 1 + max(used)))


def _min_component_area(mesh: Mesh, spec: PlacementSpec) -> float:
    """Return the smallest area of a piece that gets a taxel [m²]."""
    if spec.taxels is not None:
        return MIN_COMPONENT_AREA * mesh.area / spec.taxels
    return MIN_COMPONENT_AREA * float(HEXAGON_AREA) * (spec.pitch or MODULE_PITCH) ** 2


def _outer_surface(whole: _Surface, smallest: float, name: str) -> tuple[_Surface, list[Finding]]:
    """Return the outer surface, split where only other faces connect it, and findings about the faces left out."""
    mesh = whole.mesh
    notes = list[Finding]()
    seen: BoolArray = without_islands(mesh, outer_faces(mesh), smallest)
    inner = inner_walls(mesh, seen)
    chosen = without_islands(mesh, seen & ~inner, smallest) if inner.any() else seen
    add_finding(notes, "hidden-face", name, "not covered: not visible from outside", int((~seen).sum()))
    left_out = seen & ~chosen
    area = _area_text(float(mesh.face_areas[left_out].sum()))
    action = f"not covered: inner side of a thin shell, {area}; the surface 'all' covers both sides"
    add_finding(notes, "inner-wall", name, action, int(left_out.sum()))
    if chosen.all():
        return whole, notes
    twins = manifold_twins(mesh.faces[chosen], whole.piece[chosen])
    faces, copy_of = split_nonmanifold(mesh.faces[chosen], twins)
    outer = Mesh(mesh.vertices[copy_of], faces)
    return _Surface(outer, whole.vertex_of[copy_of], components_of(twins, len(faces))), notes


def _components_with_specs(whole: _Surface, spec: PlacementSpec, name: str) -> tuple[list[_Part], int]:
    """Return the pieces with taxels, largest first, each with its specification, and the number of smaller pieces."""
    areas = np.bincount(whole.piece, whole.mesh.face_areas).astype(np.float64)
    large = np.flatnonzero(areas >= _min_component_area(whole.mesh, spec))
    if not len(large):
        raise SkinError(
            "no piece of the mesh is large enough for a taxel",
            place=name,
            value=f"{len(areas)} pieces, the largest of {1e6 * areas.max(initial=0.0):.3g} mm²",
            remedy="Place more taxels, reduce the pitch, or join the pieces",
        )
    large = large[np.argsort(-areas[large], kind="stable")]
    counts = [None] * len(large) if spec.taxels is None else share_by_area(areas[large], spec.taxels).tolist()
    order = np.argsort(whole.piece, kind="stable")
    begin = np.searchsorted(whole.piece[order], np.arange(len(areas) + 1))
    parts = []
    for number, count in zip(large.tolist(), counts, strict=True):
        if count != 0:
            faces, used = remove_unreferenced(whole.mesh.faces[order[begin[number] : begin[number + 1]]])
            own = spec.restricted_to(whole.vertex_of[used], taxels=count)
            parts.append((Mesh(whole.mesh.vertices[used], faces), own))
    return parts, len(areas) - len(parts)
