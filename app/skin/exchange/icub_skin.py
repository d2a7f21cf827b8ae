"""Puts the taxels of an iCub positions file on a robot's link."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import Finding, SkinError
from app.geometry.clean import clean
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.wrap import wrap
from app.robots.robot import Robot
from app.skin.exchange.icub import IcubTaxels, read_icub_positions
from app.skin.pieces import tidy_pieces
from app.skin.place import cells, surface_graph, taxels_at
from app.skin.skin import Patch, Skin
from scipy.spatial import cKDTree

_PREFIXES = ("", "l_", "r_")
_WORN_WITHIN = 0.020
"""Taxels further than this from the link's surface (median) [m] belong to another link or frame."""
_FACES_PER_TAXEL = 16


def import_icub(robot: Robot, path: str | Path, *, link: str = "", thickness: float = 0.003) -> Skin:
    """Wear the taxels of a positions file.

    The link is the one named in the file. Its wrapped surface is cut to what lies within about a pitch of a taxel, each
    piece one patch; a taxel's area is the part of the surface closer to it than to any other.

    Args:
        robot: Has the link.
        path: The file.
        link: Wear them on this link instead.
        thickness: Of the cover over the link's mesh [m].

    Raises:
        SkinError: The file is unusable, the robot has no such link, or the taxels lie far from it.
    """
    taxels = read_icub_positions(path)
    name = link or _find_link(robot, taxels, path)
    own = robot.link(name).mesh
    if own is None:
        raise SkinError("the link has no geometry to wear taxels", file=path, value=name)
    mesh, notes = clean(own, where=name)
    pitch = _pitch(taxels.positions)
    wrapped = wrap(mesh, thickness=thickness, voxel=max(pitch / 3, 0.0015), where=name)
    distance = ClosestPoint(wrapped.surface).query(taxels.positions)[2]
    if np.median(distance) > _WORN_WITHIN:
        raise SkinError("the taxels lie far from the link's surface", file=path, place=name,
                        value=f"median {1e3 * np.median(distance):.1f} mm",
                        remedy="The file was made for another link or another frame; choose the link by hand")
    moved = Finding("moved-to-surface", name, f"taxels moved onto the cover, {1e3 * np.median(distance):.1f} mm in the "
                    f"median, {1e3 * distance.max():.1f} mm at most", len(distance))
    patches, lost = _patches(name, wrapped.surface, taxels.positions, pitch)
    findings = [*taxels.findings, *notes, *wrapped.findings, moved]
    if lost:
        findings.append(Finding("shared-place", name, "left out: another taxel lies at the same place on the cover",
                                lost))
    return Skin(patches, tuple(findings))


def _find_link(robot: Robot, taxels: IcubTaxels, path: str | Path) -> str:
    """The robot's link for the file's name; ``upper_arm`` in a left-arm file is ``l_upper_arm`` on the robot."""
    known = robot.link_index
    side = {"l": "l_", "r": "r_"}.get(Path(path).name[0].lower(), "")
    for name in (taxels.link, side + taxels.link, *(prefix + taxels.link for prefix in _PREFIXES)):
        if name in known:
            return name
    raise SkinError("the robot has no link of the file's name", file=path, value=taxels.link or "no name",
                    remedy=f"Choose the link by hand: {', '.join(known)}")


def _pitch(positions: FloatArray) -> float:
    """Median distance to the nearest other taxel [m]."""
    if len(positions) < 2:
        return 0.01
    return float(np.median(cKDTree(positions).query(positions, 2)[0][:, 1]))


def _patches(link: str, surface: Mesh, positions: FloatArray, pitch: float) -> tuple[tuple[Patch, ...], int]:
    """The worn pieces of the surface with their taxels, and how many taxels found no place of their own."""
    reach = 2.5 * pitch
    worn = cKDTree(positions).query(surface.vertices, distance_upper_bound=reach)[0] < reach
    pieces = tidy_pieces(surface, worn, smallest=4 * pitch**2, largest_hole=(4 * pitch) ** 2)
    distances = np.stack([ClosestPoint(piece).query(positions)[2] for piece in pieces])
    home = distances.argmin(axis=0)
    patches, placed = [], 0
    for number, piece in enumerate(pieces):
        mine = positions[home == number]
        if not len(mine):
            continue
        own, owner = _cells(piece, mine, reach)
        name = link if not patches else f"{link} {len(patches) + 1}"
        patches.append(Patch(name, link, piece, taxels_at(piece, own, owner)))
        placed += len(own)
    return tuple(patches), len(positions) - placed


def _cells(piece: Mesh, positions: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
    """Positions that have a face of their own, and the taxel of each face (-1 beyond reach)."""
    faces, _, _ = ClosestPoint(piece).query(positions)
    seeds, first = np.unique(faces, return_index=True)
    centres = piece.vertices[piece.faces].mean(axis=1)
    return positions[first], cells(surface_graph(piece, centres), seeds, reach=reach)
