"""A skin from taxel positions that somebody measured: worn by a link, wherever its taxels say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from app.arrays import BoolArray, FloatArray, IntArray
from app.errors import Finding, SkinError
from app.geometry.clean import clean
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.geometry.wrap import wrap
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.skin.cover_spec import BRIDGED
from app.skin.pieces import piece_name, tidy_pieces
from app.skin.place import cells, own_faces, straight_cells, surface_graph, taxels_at
from app.skin.skin import Patch, Skin
from app.skin.taxels import Taxels

FARTHEST_MEDIAN = 0.020
"""Taxels farther from their link than this [m] (half of them) belong to another link or frame."""
MARGIN = 1.5
"""The patch reaches this many pitches beyond its taxels."""
REACH = 1.0
"""A taxel feels this many pitches around itself, where no other taxel is nearer."""
_LARGEST_HOLE = 8.0  # in pitches²
_OTHER_FRAME = "_dh_frame"


def wear(robot: Robot, link: str, positions: FloatArray, *, thickness: float = 0.003, file: str | Path) -> Skin:
    """The skin whose taxels lie on the cover of ``link`` closest to ``positions``.

    Args:
        robot: Wears it.
        link: Name of the link.
        positions: (n, 3) [m], distinct, in the link's frame, or in that of a link ``<link>_dh_frame`` fixed to it,
            whichever lies closer to the link's mesh.
        thickness: Of the cover over the mesh [m].
        file: Where the positions came from, for errors.

    Raises:
        RobotError: The robot has no such link.
        SkinError: The link has no geometry, or half of the taxels lie more than 20 mm from it.

    Cost: about 0.5 s for 400 taxels.
    """
    mesh, findings = _link_mesh(robot, link)
    frames = _frames(robot, link)
    local, notes = _on_link(mesh, positions, frames, link, file)
    pitch = _pitch(local, mesh)
    wrapped = wrap(mesh, thickness=thickness, voxel=pitch / 2, closing=BRIDGED * thickness, where=link)
    faces, weights, _ = ClosestPoint(wrapped.surface).query(local)
    points = wrapped.surface.points(faces, weights)
    usable = _around(wrapped.surface, faces, MARGIN * pitch)
    pieces = tidy_pieces(wrapped.surface, usable, smallest=0.0, largest_hole=_LARGEST_HOLE * pitch**2)
    patches = _patches(pieces, points, pitch, link)
    missing = len(points) - sum(len(patch.taxels) for patch in patches)
    if missing:
        notes.append(Finding("taxel-off-patch", link, "left out: no patch could be made around it", missing))
    if not patches:
        raise SkinError("no patch could be made around the taxels", file=file, place=link)
    return Skin(patches, (*findings, *notes, *wrapped.findings))


def _link_mesh(robot: Robot, link: str) -> tuple[Mesh, tuple[Finding, ...]]:
    mesh = robot.link(link).mesh
    if mesh is None or not len(mesh.faces):
        raise SkinError("the link has no geometry to wear a skin", file=robot.source, value=link)
    return clean(mesh, where=link)


def _frames(robot: Robot, link: str) -> dict[str, Pose]:
    """Frames the positions may be stated in, by name: ``T_link_frame``. Only frames fixed to the link."""
    configuration, other = Configuration(robot), link + _OTHER_FRAME
    frames = {link: Pose.identity()}
    if other in robot.link_index:
        pose = configuration.pose(link).inverse @ configuration.pose(other)
        configuration.update(robot.home + 0.1)
        moved = configuration.pose(link).inverse @ configuration.pose(other)
        if np.allclose(moved.matrix, pose.matrix, atol=1e-9):
            frames[other] = pose
    return frames


def _on_link(
    mesh: Mesh, positions: FloatArray, frames: dict[str, Pose], link: str, file: str | Path
) -> tuple[FloatArray, list[Finding]]:
    """The positions in the link's frame, and how far they lie from its mesh."""
    closest = ClosestPoint(mesh)
    away = {name: closest.query(pose.points(positions))[2] for name, pose in frames.items()}
    frame = min(away, key=lambda name: float(np.median(away[name])))
    median, most = float(np.median(away[frame])), float(away[frame].max())
    if median > FARTHEST_MEDIAN:
        raise SkinError(
            f"half of the taxels lie more than {1e3 * FARTHEST_MEDIAN:.0f} mm from the link {link}",
            file=file,
            value=f"median {1e3 * median:.1f} mm",
            remedy="Choose another link, or state the positions in the link's frame",
        )
    notes = [
        Finding(
            "taxel-distance",
            link,
            f"moved onto the cover from {1e3 * median:.1f} mm (median) and "
            f"{1e3 * most:.1f} mm (most) off the link's mesh",
            len(positions),
        )
    ]
    if frame != link:
        notes.append(Finding("taxel-frame", link, f"the positions are stated in the frame {frame}"))
    return frames[frame].points(positions), notes


def _pitch(positions: FloatArray, mesh: Mesh) -> float:
    """Median distance to the nearest other taxel [m]; a lone taxel feels a twentieth of the link."""
    if len(positions) < 2:
        return mesh.size / 20
    return float(np.median(cKDTree(positions).query(positions, k=2)[0][:, 1]))


def _around(surface: Mesh, seeds: IntArray, reach: float) -> BoolArray:
    """(vertices,) corners of the faces within ``reach`` [m] of a seed face, over the surface."""
    graph = surface_graph(surface, surface.vertices[surface.faces].mean(axis=1))
    away = dijkstra(graph, directed=False, indices=np.unique(seeds), min_only=True, limit=reach)
    usable = np.zeros(len(surface.vertices), dtype=bool)
    usable[surface.faces[np.isfinite(away)]] = True
    return usable


def _patches(pieces: list[Mesh], points: FloatArray, pitch: float, link: str) -> tuple[Patch, ...]:
    """One patch for each piece that has taxels; each taxel goes to the nearest piece."""
    away = np.array([ClosestPoint(piece).query(points)[2] for piece in pieces]).reshape(len(pieces), len(points))
    patches: list[Patch] = []
    for i, piece in enumerate(pieces):
        own = points[(away.argmin(axis=0) == i) & (away[i] <= pitch)]
        if len(own):
            patches.append(Patch(piece_name(link, len(patches)), link, piece, _taxels(piece, own, pitch)))
    return tuple(patches)


def _taxels(piece: Mesh, points: FloatArray, pitch: float) -> Taxels:
    centres = piece.vertices[piece.faces].mean(axis=1)
    seeds = own_faces(centres, points)
    graph: csr_matrix = surface_graph(piece, centres)
    owner = cells(graph, seeds, reach=REACH * pitch)
    return taxels_at(piece, points, straight_cells(piece, points, owner, seeds))
