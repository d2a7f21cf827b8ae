"""A skin from measured taxel positions, fitted to the link of a robot that carries them.

The link's mesh gets a wrap as for a cover; each taxel moves to the closest point on it. Positions may be in the link's
frame or in that of a link fixed to it; the frame in which they lie closer to the mesh is taken. Taxels that lie far
from the link are refused: they belong to another link or frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from app.core.arrays import BoolArray, FloatArray, IntArray
from app.core.errors import Finding, SkinError
from app.geometry.closest_point import ClosestPoint
from app.geometry.geodesics import distances_from
from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.geometry.repair import clean_mesh
from app.geometry.wrap import wrap_mesh
from app.robots.kinematics import Configuration
from app.robots.robot import Robot
from app.skin.cover import CLOSING_FACTOR
from app.skin.sampling import distinct_faces, face_graph, geodesic_voronoi, straighten_cells, taxels_at_points
from app.skin.skin import NO_IDENTITY, Patch, Skin, TaxelIdentity, Taxels
from app.skin.usable_surface import patch_name, usable_components

MAX_MEDIAN_DISTANCE = 0.020
"""Taxels farther from their link than this [m] (half of them) belong to another link or frame."""
PATCH_MARGIN = 1.5
"""The patch reaches this many pitches beyond its taxels."""
CELL_RADIUS = 1.0
"""A taxel feels this many pitches around itself, where no other taxel is nearer."""
_LARGEST_HOLE = 8.0  # in pitches²
_DH_FRAME_SUFFIX = "_dh_frame"


def fit_taxels_to_link(
    robot: Robot,
    link: str,
    positions: FloatArray,
    *,
    thickness: float = 0.003,
    file: str | Path,
    identity: TaxelIdentity = NO_IDENTITY,
    frames: Mapping[str, Pose] | None = None,
) -> Skin:
    """The skin whose taxels lie on the cover of ``link`` closest to ``positions``.

    Args:
        robot: Wears it.
        link: Name of the link.
        positions: (n, 3) [m], distinct, in the link's frame, or in that of a link ``<link>_dh_frame`` fixed to it,
            whichever lies closer to the link's mesh.
        thickness: Of the cover over the mesh [m].
        file: Where the positions came from, for errors.
        identity: Of the taxels, which the skin's take along.
        frames: Other frames fixed to the link that the positions may be stated in, by name: ``T_link_frame``.

    Raises:
        RobotError: The robot has no such link.
        SkinError: The link has no geometry, or half of the taxels lie more than 20 mm from it.

    Cost: about 0.5 s for 400 taxels.
    """
    mesh, findings = _link_mesh(robot, link)
    match = _closest_frame(mesh, positions, {**_candidate_frames(robot, link), **(frames or {})})
    local, notes = match.pose.points(positions), _match_notes(match, link, len(positions), file)
    pitch = _pitch(local, mesh)
    wrapped = wrap_mesh(mesh, thickness=thickness, voxel=pitch / 2, closing=CLOSING_FACTOR * thickness, where=link)
    faces, weights, _ = ClosestPoint(wrapped.surface).query(local)
    points = wrapped.surface.points(faces, weights)
    usable = _vertices_within(wrapped.surface, faces, PATCH_MARGIN * pitch)
    pieces = usable_components(wrapped.surface, usable, smallest=0.0, largest_hole=_LARGEST_HOLE * pitch**2)
    patches = _patches(pieces, points, identity, pitch, link)
    missing = len(points) - sum(len(patch.taxels) for patch in patches)
    if missing:
        notes.append(Finding("taxel-off-patch", link, "left out: no patch could be made around it", missing))
    if not patches:
        raise SkinError("no patch could be made around the taxels", file=file, place=link)
    return Skin(patches, (*findings, *notes, *wrapped.findings))


def carrying_link(robot: Robot, named: str | None, path: Path) -> str:
    """The robot's link that carries the taxels of a file which calls it ``named``.

    ``upper_arm`` in the file ``left_arm.txt`` is ``l_upper_arm`` on the robot.

    Raises:
        SkinError: The file names none, or one that the robot does not have.
    """
    links = ", ".join(robot.link_index)
    if named is None:
        remedy = f"Choose the link that carries these taxels, one of: {links}"
        raise SkinError("the file does not name its link", file=path, remedy=remedy)
    side = {"left": "l_", "right": "r_"}.get(path.name.partition("_")[0], "")
    for name in (named, side + named):
        if name in robot.link_index:
            return name
    raise SkinError(
        "the robot has no link of the file's name", file=path, value=named, remedy=f"Choose one of: {links}"
    )


def _link_mesh(robot: Robot, link: str) -> tuple[Mesh, tuple[Finding, ...]]:
    mesh = robot.link(link).mesh
    if mesh is None or not len(mesh.faces):
        raise SkinError("the link has no geometry for a skin", file=robot.source, value=link)
    return clean_mesh(mesh, where=link)


def _candidate_frames(robot: Robot, link: str) -> dict[str, Pose]:
    """Frames the positions may be stated in, by name: ``T_link_frame``. Only frames fixed to the link."""
    configuration, other = Configuration(robot), link + _DH_FRAME_SUFFIX
    frames = {link: Pose.identity()}
    if other in robot.link_index:
        pose = configuration.pose(link).inverse @ configuration.pose(other)
        configuration.update(robot.home + 0.1)
        moved = configuration.pose(link).inverse @ configuration.pose(other)
        if np.allclose(moved.matrix, pose.matrix, atol=1e-9):
            frames[other] = pose
    return frames


@dataclass(frozen=True, eq=False)
class FrameMatch:
    """The frame in which taxels lie closest to the mesh of their link.

    Attributes:
        name: Of the frame.
        pose: ``T_link_frame``.
        median: Of their distances to the mesh [m].
        p95: 95 % of them lie no farther from it [m].
        most: The farthest [m].
    """

    name: str
    pose: Pose
    median: float
    p95: float
    most: float


def match_frame(
    robot: Robot, link: str, positions: FloatArray, *, frames: Mapping[str, Pose] | None = None
) -> FrameMatch:
    """In which frame ``positions`` (n, 3) [m] lie closest to ``link``; arguments and errors as ``fit_taxels_to_link``.

    Cost: 0.1 s for 400 taxels.
    """
    mesh, _ = _link_mesh(robot, link)
    return _closest_frame(mesh, positions, {**_candidate_frames(robot, link), **(frames or {})})


def _closest_frame(mesh: Mesh, positions: FloatArray, frames: Mapping[str, Pose]) -> FrameMatch:
    closest = ClosestPoint(mesh)
    matches = []
    for name, pose in frames.items():
        away = closest.query(pose.points(positions))[2]
        median, p95 = np.quantile(away, [0.5, 0.95])
        matches.append(FrameMatch(name, pose, float(median), float(p95), float(away.max())))
    return min(matches, key=lambda match: match.median)


def _match_notes(match: FrameMatch, link: str, count: int, file: str | Path) -> list[Finding]:
    """How far the taxels lie from the link's mesh, and in which frame; refuses those of another link."""
    if match.median > MAX_MEDIAN_DISTANCE:
        raise SkinError(
            f"half of the taxels lie more than {1e3 * MAX_MEDIAN_DISTANCE:.0f} mm from the link {link}",
            file=file,
            value=f"median {1e3 * match.median:.1f} mm",
            remedy="Choose another link, or state the positions in the link's frame",
        )
    notes = [
        Finding(
            "taxel-distance",
            link,
            f"moved onto the cover from {1e3 * match.median:.1f} mm (median) and "
            f"{1e3 * match.most:.1f} mm (most) off the link's mesh",
            count,
        )
    ]
    if match.name != link:
        notes.append(Finding("taxel-frame", link, f"the positions are stated in the frame {match.name}"))
    return notes


def _pitch(positions: FloatArray, mesh: Mesh) -> float:
    """Median distance to the nearest other taxel [m]; a lone taxel feels a twentieth of the link."""
    if len(positions) < 2:
        return mesh.size / 20
    return float(np.median(cKDTree(positions).query(positions, k=2)[0][:, 1]))


def _vertices_within(surface: Mesh, seeds: IntArray, reach: float) -> BoolArray:
    """(vertices,) corners of the faces within ``reach`` [m] of a seed face, over the surface."""
    graph = face_graph(surface, surface.vertices[surface.faces].mean(axis=1))
    away = distances_from(graph, np.unique(seeds), limit=reach)
    usable = np.zeros(len(surface.vertices), dtype=bool)
    usable[surface.faces[np.isfinite(away)]] = True
    return usable


def _patches(
    pieces: list[Mesh], points: FloatArray, identity: TaxelIdentity, pitch: float, link: str
) -> tuple[Patch, ...]:
    """One patch for each piece that has taxels; each taxel goes to the nearest piece."""
    away = np.array([ClosestPoint(piece).query(points)[2] for piece in pieces]).reshape(len(pieces), len(points))
    patches: list[Patch] = []
    for i, piece in enumerate(pieces):
        own = np.flatnonzero((away.argmin(axis=0) == i) & (away[i] <= pitch))
        if len(own):
            taxels = replace(_taxels(piece, points[own], pitch), identity=identity.select(own))
            patches.append(Patch(patch_name(link, len(patches)), link, piece, taxels))
    return tuple(patches)


def _taxels(piece: Mesh, points: FloatArray, pitch: float) -> Taxels:
    centres = piece.vertices[piece.faces].mean(axis=1)
    seeds = distinct_faces(centres, points)
    graph: csr_matrix = face_graph(piece, centres)
    owner = geodesic_voronoi(graph, seeds, reach=CELL_RADIUS * pitch)
    return taxels_at_points(piece, points, straighten_cells(piece, points, owner, seeds))
