"""A skin that places itself on a robot: the links chosen, wrapped, freed of their joints, and set with taxels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.errors import Finding, SkinError
from app.geometry.clean import clean
from app.geometry.mesh import Mesh
from app.geometry.wrap import wrap
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.skin.choose import choose_links, hull_area
from app.skin.cover_spec import BRIDGED, CoverSpec
from app.skin.pieces import clear_of, piece_name, tidy_pieces
from app.skin.place import place_taxels
from app.skin.skin import Patch, Skin
from app.skin.visible import visible_from_outside

Progress = Callable[[str, float], None]

FACES_PER_TAXEL = 12
JOINT_CLEARANCE = 0.010
"""Skin keeps this far from the links beside it [m], so that joints can move."""
_MIN_TAXELS = 12
_MIN_SHARE = 0.15
_MAX_HOLE_TAXELS = 4


@dataclass(frozen=True, eq=False)
class _Piece:
    link: str
    surface: Mesh


def _silent(_text: str, _fraction: float) -> None:
    """No progress wanted."""


def cover(robot: Robot, spec: CoverSpec, *, progress: Progress = _silent) -> Skin:
    """Cover ``robot`` as ``spec`` says.

    Args:
        robot: Its links' meshes may be in any state; see ``geometry.wrap``.
        spec: What is wanted.
        progress: Told what is being done and how far it is, 0 to 1; may raise to cancel.

    Raises:
        SkinError: No link can wear skin, or a named link has no geometry.
        RobotError: A named link does not exist.

    Cost: about 1 s for 1000 taxels on three links.
    """
    links = spec.links or choose_links(robot)
    meshes, findings = _cleaned_links(robot)
    _check_links(robot, links, meshes)
    voxel = _voxel({name: meshes[name] for name in links}, spec.taxels)
    configuration = Configuration(robot)
    pieces: list[_Piece] = []
    for i, name in enumerate(links):
        progress(f"Covering {name}", 0.7 * i / len(links))
        found, notes = _pieces(configuration, meshes, name, spec.thickness, voxel)
        pieces += found
        findings += notes
    if not pieces:
        raise SkinError(
            "no surface is left for skin once the joints are kept clear",
            file=robot.source,
            place=", ".join(links),
            remedy="Choose other links or a thinner cover",
        )
    progress("Placing taxels", 0.7)
    return Skin(_patches(pieces, spec), tuple(findings))


def _check_links(robot: Robot, links: tuple[str, ...], meshes: dict[str, Mesh]) -> None:
    bare = [name for name in links if robot.link(name).name not in meshes]
    if bare:
        raise SkinError(
            "the link has no geometry to wear a skin",
            file=robot.source,
            value=bare[0],
            remedy=f"Choose among: {', '.join(meshes)}",
        )


def _cleaned_links(robot: Robot) -> tuple[dict[str, Mesh], list[Finding]]:
    meshes: dict[str, Mesh] = {}
    findings: list[Finding] = []
    for link in robot.links:
        if link.mesh is not None and len(link.mesh.faces):
            meshes[link.name], notes = clean(link.mesh, where=link.name)
            findings += notes
    return meshes, findings


def _voxel(meshes: dict[str, Mesh], taxels: int) -> float:
    """Edge length that gives each taxel about ``FACES_PER_TAXEL`` faces; a voxel² of surface carries about three."""
    area = sum(hull_area(mesh) for mesh in meshes.values())
    return float(np.sqrt(3.0 * area / (taxels * FACES_PER_TAXEL)))


def _pieces(
    configuration: Configuration, meshes: dict[str, Mesh], name: str, thickness: float, voxel: float
) -> tuple[list[_Piece], list[Finding]]:
    wrapped = wrap(meshes[name], thickness=thickness, voxel=voxel, closing=BRIDGED * thickness, where=name)
    here = configuration.pose(name).inverse
    others = []
    for other, mesh in meshes.items():
        if other != name:
            relative = here @ configuration.pose(other)
            others.append(Mesh(relative.points(mesh.vertices), mesh.faces))
    usable = clear_of(wrapped.surface, others, distance=JOINT_CLEARANCE)
    usable &= visible_from_outside(wrapped.surface, others, voxel=wrapped.voxel)
    taxel_area = FACES_PER_TAXEL * voxel**2 / 3
    smallest = max(_MIN_SHARE * wrapped.surface.area, _MIN_TAXELS * taxel_area)
    found = tidy_pieces(wrapped.surface, usable, smallest=smallest, largest_hole=_MAX_HOLE_TAXELS * taxel_area)
    notes = list(wrapped.findings)
    if not found:
        notes.append(Finding("no-room", name, "left bare: neighbouring links are too close everywhere"))
    return [_Piece(name, surface) for surface in found], notes


def _patches(pieces: list[_Piece], spec: CoverSpec) -> tuple[Patch, ...]:
    shares = np.array([piece.surface.area for piece in pieces])
    shares = spec.taxels * shares / shares.sum()
    counts = np.floor(shares).astype(int)
    # Largest remainders get the taxels that rounding down left over, so that the total is what was asked for.
    counts[np.argsort(counts - shares, kind="stable")[: spec.taxels - counts.sum()]] += 1
    counts = np.maximum(counts, 1)
    patches = []
    for i, piece in enumerate(pieces):
        before = sum(other.link == piece.link for other in pieces[:i])
        taxels = place_taxels(piece.surface, int(counts[i]), seed=spec.seed)
        patches.append(Patch(piece_name(piece.link, before), piece.link, piece.surface, taxels))
    return tuple(patches)
