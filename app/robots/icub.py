"""iCub's torso and left arm, from the wheel ``icub-models`` where it is installed."""

from __future__ import annotations

import re
import sys
from importlib import metadata
from pathlib import Path
from xml.etree.ElementTree import Element

from app.errors import RobotError
from app.robots.robot import Robot
from app.robots.urdf import robot_of_urdf, urdf_tree

MODEL = "iCubGazeboV2_7"
REMEDY = "pip install 'tactile-maps[robots]'"
BASE_HEIGHT = 0.18  # m: the pelvis just clears the ground
BASE_YAW = -1.5708  # rad: its front and its left arm face the usual camera
# A bent arm, off the body [rad].
HOME = {"l_shoulder_pitch": -0.5, "l_shoulder_roll": 0.6, "l_elbow": 1.0, "l_wrist_prosup": 0.2}
# Frames named *_dh_frame stay: taxel files state positions in them.
_PART = re.compile(r"root_link$|torso_|chest$|l_(shoulder|arm|upper_arm|elbow|forearm|wrist|hand)")
_FRAME = re.compile(r"_skin_\d+$|_ems_|_gyro_|_imu(_|$)")


def icub_folder() -> Path | None:
    """The folder ``share/iCub`` of the installed wheel, or None where it is not installed."""
    places = [Path(sys.prefix, "share", "iCub")]
    try:
        files = metadata.files("icub-models") or []
    except metadata.PackageNotFoundError:
        files = []
    places += [Path(file.locate()).resolve().parents[2] for file in files if file.match(f"robots/{MODEL}/model.urdf")]
    return next((place for place in places if (place / "robots" / MODEL / "model.urdf").is_file()), None)


def load_icub() -> Robot:
    """iCub from pelvis to left hand: 10 joints, link names as in its URDF (``chest``, ``l_upper_arm``, ``l_forearm``).

    Raises:
        RobotError: The wheel is not installed.
    """
    folder = icub_folder()
    if folder is None:
        raise RobotError("the robot icub needs a package that is not installed", value="icub-models", remedy=REMEDY)
    path = folder / "robots" / MODEL / "model.urdf"
    root = _torso_and_left_arm(urdf_tree(path))
    return robot_of_urdf(
        root, path, package_roots=[folder.parent], name="icub", home=HOME, base_height=BASE_HEIGHT, base_yaw=BASE_YAW
    )


def _torso_and_left_arm(root: Element) -> Element:
    """Keep the wanted links and the joints between them; massless sensor frames go too."""
    kept = {link.get("name", "") for link in root.iter("link") if _wanted(link.get("name", ""))}
    root[:] = [
        child
        for child in root
        if (child.tag == "link" and child.get("name") in kept)
        or (child.tag == "joint" and {_end(child, "parent"), _end(child, "child")} <= kept)
        or child.tag == "material"
    ]
    return root


def _wanted(name: str) -> bool:
    return bool(_PART.match(name)) and not _FRAME.search(name)


def _end(joint: Element, which: str) -> str:
    end = joint.find(which)
    return end.get("link", "") if end is not None else ""
