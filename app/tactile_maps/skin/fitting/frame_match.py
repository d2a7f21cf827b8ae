"""The link and the frame for which the positions of measured taxels are stated.

Positions may be stated in the frame of the link or of a link fixed to it; the frame in which they are closer to the
meshes is used. Taxels far from the body belong to another link or frame, and are rejected.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.rigid_body import BodyPart, above_hidden, distances_to_parts, no_geometry, rigid_parts

MAX_MEDIAN_DISTANCE = 0.020
"""Median distance of taxels from their link [m], above which they belong to another link or frame."""
SAME_SURFACE = 1e-3
"""A taxel moves to another link fixed to its own if that one is closer by more than this [m] and by more than half. It
moves to any closer one where its own link is hidden inside others."""
_ON_MESH = 5e-5
"""Distance [m] below which a stated taxel is on the mesh."""
_DH_FRAME_SUFFIX = "_dh_frame"


@dataclass(frozen=True, eq=False)
class FrameMatch(ArrayFields):
    """The frame in which taxels are closest to the meshes of their link and of links fixed to it.

    Attributes:
        name: Name of the frame.
        pose: ``T_link_frame``.
        part: (n,) number of the part that each taxel is closest to; the link itself has the number 0.
        away: (n,) distance of each taxel to that part [m].
    """

    name: str
    pose: Pose
    part: IntArray
    away: FloatArray

    @property
    def median(self) -> float:
        """Median distance [m]."""
        return float(np.median(self.away))

    def select(self, which: BoolArray) -> FrameMatch:
        """Return the match of the taxels where ``which`` (n,) is true."""
        return replace(self, part=self.part[which], away=self.away[which])


def match_frame(
    robot: Robot, link: str, positions: FloatArray, *, frames: Mapping[str, Pose] | None = None
) -> FrameMatch:
    """Return the frame in which ``positions`` (n, 3) [m] are closest to ``link`` and the links fixed to it.

    Arguments and errors are those of ``place_taxels``. Where all meshes are missing, the distances are infinite.

    Cost: 0.1 s for 400 taxels; up to 1 s more where links fixed to this one reach into it.
    """
    return stated_match(robot, link, *rigid_parts(robot, link), positions, frames or {})


def stated_match(
    robot: Robot,
    link: str,
    parts: Sequence[BodyPart],
    placeholders: Sequence[BodyPart],
    positions: FloatArray,
    frames: Mapping[str, Pose],
) -> FrameMatch:
    """Return the frame of stated taxels: the link's own if a mesh is missing and no frame is close to the others."""
    own = {link: Pose.identity()}
    if not parts and not placeholders:
        raise no_geometry(robot, link)
    if not parts:
        return FrameMatch(link, own[link], np.zeros(len(positions), dtype=np.int64), np.full(len(positions), np.inf))
    match = _closest_frame(link, parts, positions, {**_candidate_frames(robot, link), **frames})
    far = match.median > MAX_MEDIAN_DISTANCE
    return _closest_frame(link, parts, positions, own) if placeholders and far else match


def _candidate_frames(robot: Robot, link: str) -> dict[str, Pose]:
    """Return the frames of the robot in which positions may be stated, by name: ``T_link_frame``, fixed to the link."""
    configuration = Configuration(robot)
    other = link + _DH_FRAME_SUFFIX
    frames = {link: Pose.identity()}
    if other in configuration.rigid_links(link):
        frames[other] = configuration.pose(link).inverse @ configuration.pose(other)
    return frames


def _closest_frame(
    link: str, parts: Sequence[BodyPart], positions: FloatArray, frames: Mapping[str, Pose]
) -> FrameMatch:
    matches = []
    for name, pose in frames.items():
        distances = distances_to_parts(parts, pose.points(positions))
        part = distances.argmin(axis=0)
        least = distances.min(axis=0)
        if parts[0].link == link:
            own = distances[0] <= np.maximum(least + SAME_SURFACE, 2 * least)
            part[own & ~above_hidden(parts[0], pose.points(positions))] = 0
        away = distances[part, np.arange(len(positions))]
        matches.append(FrameMatch(name, pose, part, away))
    return min(matches, key=lambda match: match.median)


def match_notes(match: FrameMatch, link: str, count: int, file: str | Path) -> list[Finding]:
    """Return findings of the distance of the taxels from the link, and of their frame.

    Raises:
        SkinError: The taxels are far from the link.
    """
    if match.median > MAX_MEDIAN_DISTANCE:
        raise SkinError(
            f"half of the taxels are more than {1e3 * MAX_MEDIAN_DISTANCE:.0f} mm from the link {link}",
            file=file,
            value=f"median {1e3 * match.median:.1f} mm",
            remedy="Choose another link, or state the positions in the link's frame",
        )
    most = float(match.away.max())
    stated = f"{1e3 * match.median:.1f} mm (median) and {1e3 * most:.1f} mm (largest) off the link's mesh"
    action = (
        f"moved onto the cover from {stated}" if most >= _ON_MESH else "stated on the link's mesh, kept on its cover"
    )
    notes = [Finding("taxel-distance", link, action, count)]
    if match.name != link:
        notes.append(Finding("taxel-frame", link, f"the positions are stated in the frame {match.name}"))
    return notes


def carrying_link(robot: Robot, named: str | None, path: Path) -> str:
    """Return the link of the robot that a file calls ``named``.

    ``upper_arm`` in the file ``left_arm.txt`` is ``l_upper_arm`` on the robot.

    Raises:
        SkinError: The file does not name a link, or the robot does not have it.
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
