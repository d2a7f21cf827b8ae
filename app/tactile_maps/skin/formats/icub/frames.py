"""Frames in which iCub's positions files state their taxels, on the links of the official model.

The files come from several calibrations, each in a frame of its own: that of the link in the robot's URDF, that of a
link ``<link>_dh_frame``, or one that the URDF does not have. The last are known here, from the Denavit-Hartenberg
chains of iCub's documentation (iCub Tech, Forward Kinematics, arms and head v1): the third joint of the
torso, on the way to the head, for the chest; the elbow, for the upper arms. One file, the V2.7 right upper arm, is in
no documented frame: its pose is that which makes it the mirror image of the left one (median 0.13 mm off).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

ROOT = "root_link"


def icub_frames(robot: Robot, link: str) -> dict[str, Pose]:
    """Return the documented frames of a link that the URDF does not have, by name: ``T_link_frame``."""
    known = _FRAMES.get(link, {})
    if not known or ROOT not in robot.link_index or link not in robot.link_index:
        return {}
    configuration = Configuration(robot)
    configuration.update(np.zeros(len(robot.joints)))
    to_link = configuration.pose(link).inverse @ configuration.pose(ROOT)
    return {name: to_link @ pose for name, pose in known.items()}


def _denavit_hartenberg(rows: Sequence[tuple[float, float, float, float]]) -> Pose:
    """Return the pose in the root frame, at zero joint angles, of links (a [mm], d [mm], alpha [deg], offset [deg])."""
    pose = Pose(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]), np.zeros(3))
    for a, d, alpha, theta in rows:
        ca = np.cos(np.deg2rad(alpha))
        sa = np.sin(np.deg2rad(alpha))
        ct = np.cos(np.deg2rad(theta))
        st = np.sin(np.deg2rad(theta))
        rotation = np.array([[ct, -st * ca, st * sa], [st, ct * ca, -ct * sa], [0.0, sa, ca]])
        pose = pose @ Pose(rotation, 1e-3 * np.array([ct * a, st * a, d]))
    return pose


_WAIST = ((32.0, 0.0, 90.0, 0.0), (0.0, -5.5, 90.0, -90.0))
_HEAD = (*_WAIST, (2.31, -193.3, -90.0, -90.0))
_LEFT_ELBOW = (
    *_WAIST,
    (23.3647, -143.3, -90.0, 105.0),
    (0.0, 107.74, -90.0, 90.0),
    (0.0, 0.0, 90.0, -90.0),
    (15.0, 152.28, -90.0, 75.0),
)
_RIGHT_ELBOW = (
    *_WAIST,
    (-23.3647, -143.3, 90.0, -105.0),
    (0.0, -107.74, 90.0, -90.0),
    (0.0, 0.0, -90.0, -90.0),
    (-15.0, -152.28, -90.0, -105.0),
)
_RIGHT_ARM_FILE = Pose(
    Rotation.from_rotvec([-87.5888, -29.1978, 29.2341], degrees=True).as_matrix(),
    np.array([-0.036197, 0.138402, 0.104879]),
)
_FRAMES: dict[str, dict[str, Pose]] = {
    "chest": {"torso (third DH link)": _denavit_hartenberg(_HEAD)},
    "l_upper_arm": {"elbow (DH)": _denavit_hartenberg(_LEFT_ELBOW)},
    "r_upper_arm": {"elbow (DH)": _denavit_hartenberg(_RIGHT_ELBOW), "mirrored left arm": _RIGHT_ARM_FILE},
}
"""Frames by link and name: ``T_root_frame`` with all joints at zero."""
