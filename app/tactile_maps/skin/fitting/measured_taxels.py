"""Skin on a robot link from measured taxel positions.

The mesh of the link is wrapped as for a cover, and each taxel moves to the closest point of the wrap. Links without a
joint between them are one body: a taxel that is clearly closer to another of them moves onto that one. Only the surface
that can be touched counts: no taxel moves onto a core inside its pad. Where a mesh of the body is missing, taxels that
are far from the other shapes, or closer to the placeholder of the missing mesh, stay at their stated positions and are
joined to each other: no taxel moves onto a placeholder.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, SkinError, names_text
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import CLOSING_FACTOR
from tactile_maps.skin.fitting.cover_patches import StatedProperties, patches_at
from tactile_maps.skin.fitting.frame_match import MAX_MEDIAN_DISTANCE, FrameMatch, match_notes, stated_match
from tactile_maps.skin.fitting.rigid_body import BodyPart, distances_to_parts, rigid_parts, touchable_vertices
from tactile_maps.skin.model.skin import Patch, Skin, merge_skins
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels

_OUTLYING = 3.0
"""Distance of a taxel from the surface above which it is named, as a multiple of the median distance."""
_NAMED = 20
"""Largest number of taxels that are named; all are counted."""


def place_taxels(
    robot: Robot,
    link: str,
    taxels: TaxelSet,
    *,
    thickness: float = 0.003,
    file: str | Path,
    frames: Mapping[str, Pose] | None = None,
) -> Skin:
    """Return the skin of ``taxels`` on the covers of ``link`` and of links fixed to it, closest to their positions.

    Where a mesh of the link, or of a link fixed to it, is missing, taxels stay at their stated positions if they are
    more than 20 mm from the other shapes or closer to the placeholder of the missing mesh. The findings of the set come
    first.

    Args:
        robot: The robot.
        link: Name of the link that the taxels are stated for.
        taxels: Taxels with positions in the frame of the link, or of a link ``<link>_dh_frame`` fixed to it, whichever
            is closer to the meshes.
        thickness: Thickness of the cover over the meshes [m].
        file: Source of the taxels, for errors.
        frames: Other frames fixed to the link in which the positions may be stated, by name: ``T_link_frame``.

    Raises:
        RobotError: The robot does not have the link.
        SkinError: Neither the link nor any link fixed to it has geometry, or half of the taxels are more than 20 mm
            from them.

    Cost: about 0.5 s for 400 taxels; up to 1 s more where links fixed to this one reach into it.
    """
    parts, placeholders = rigid_parts(robot, link)
    match = stated_match(robot, link, parts, placeholders, taxels.positions, frames or {})
    local = match.pose.points(taxels.positions)
    stays = np.zeros(len(taxels), dtype=bool)
    if placeholders:
        closest = distances_to_parts(placeholders, local).min(axis=0)
        stays = (match.away > MAX_MEDIAN_DISTANCE) | (match.away > closest)
    skins = [Skin((), taxels.findings)]
    stated = StatedProperties(taxels.identity, taxels.axes, taxels.tangents).rotated(match.pose)
    if not stays.all():
        on = match.select(~stays)
        own = stated.select(np.flatnonzero(~stays))
        skins.append(_skin_on_covers(link, parts, on, local[~stays], own, thickness, file))
        pitch = _pitch(local[~stays], parts[0].mesh)
        skins.append(Skin((), tuple(_far_taxels(taxels, np.where(stays, 0.0, match.away), pitch))))
    if stays.any():
        normals = None if taxels.normals is None else match.pose.directions(taxels.normals)
        here = replace(taxels, name=link, link=link, positions=local, normals=normals, tangents=stated.tangents)
        here = here.select(stays)
        action = (
            "kept at their stated places, joined to each other: a mesh of the link or of one fixed to it is missing"
        )
        note = Finding("stated-places", link, action, int(stays.sum()))
        skins += [skin_from_taxels(replace(here, findings=())), Skin((), (note,))]
    return merge_skins(skins)


def _far_taxels(taxels: TaxelSet, away: FloatArray, pitch: float) -> Iterator[Finding]:
    """Yield a finding that names the taxels stated farther from the surface than the others.

    A taxel that moves by more than the pitch is no longer between its neighbours. A distance that all have, as that of
    a skin below a rubber sole, is in the finding of the whole set.

    Args:
        taxels: The taxels.
        away: (n,) distances from the surface [m].
        pitch: Distance between neighbours [m].
    """
    far = np.flatnonzero(away > max(pitch, _OUTLYING * float(np.median(away))))
    if not len(far):
        return
    far = far[np.argsort(-away[far], kind="stable")]
    identity = taxels.identity
    names = [
        f"{str(identity.name(row)) or f'taxel {taxels.numbers[row]}'} by {1e3 * away[row]:.1f} mm"
        for row in far.tolist()
    ]
    action = f"moved onto the surface, by more than the distance between taxels: {names_text(names, _NAMED)}"
    yield Finding("taxel-off-surface", taxels.link or taxels.name, action, len(far))


def _skin_on_covers(
    link: str,
    parts: Sequence[BodyPart],
    match: FrameMatch,
    local: FloatArray,
    stated: StatedProperties,
    thickness: float,
    file: str | Path,
) -> Skin:
    """Return the skin of the places ``local`` (n, 3) [m], in the frame of ``link``, on covers of the parts."""
    notes = match_notes(match, link, len(local), file)
    pitch = _pitch(local, parts[0].mesh)
    patches = list[Patch]()
    for number, part in enumerate(parts):
        own = np.flatnonzero(match.part == number)
        if not len(own):
            continue
        if part.link != link:
            notes.append(Finding("rigid-link", link, f"on {part.link}, a link fixed to it", len(own)))
        cover = wrap_mesh(
            part.mesh, thickness=thickness, voxel=pitch / 2, closing=CLOSING_FACTOR * thickness, where=part.link
        )
        places = part.pose.inverse.points(local[own])
        here = stated.select(own).rotated(part.pose.inverse)
        touchable = touchable_vertices(cover.surface, part, parts)
        found, missing = patches_at(cover.surface, places, here, pitch, part.link, touchable)
        patches += found
        notes += (*part.findings, *missing, *cover.findings)
    if not patches:
        raise SkinError("no patch could be made around the taxels", file=file, place=link)
    return Skin(tuple(patches), tuple(notes))


def _pitch(positions: FloatArray, mesh: Mesh) -> float:
    """Return the median distance to the nearest other taxel [m]; for a single taxel, 1/20 of the size of the link."""
    distances = nearest_others(positions, 1)[0]
    return float(np.median(distances)) if distances.size else mesh.size / 20
