"""What MuJoCo need not see of an MJCF file: scenery, decoration, and orders for absurd amounts of anything."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element

from app.errors import RobotError

MAX_COPIES = 2000
MAX_MESH_PARAMETER = 256.0  # MuJoCo's own shapes are grids of at most this many cells a side

_SECTIONS = frozenset(
    ("actuator", "sensor", "tendon", "option", "size", "visual", "statistic", "custom", "extension", "deformable")
)
_UNSUPPORTED = ("composite", "flexcomp", "attach", "model")
_FILE_ASSETS = frozenset(("texture", "hfield", "skin"))


def cut_mjcf(root: Element, path: Path) -> None:
    """Remove from the tree what is not the robot or is only for show.

    Args:
        root: The tree with its includes unfolded; it is changed.
        path: The file, for errors.

    Raises:
        RobotError: The model is not made of rigid links, or asks for absurd amounts.
    """
    for tag in _UNSUPPORTED:
        if root.find(f".//{tag}") is not None:
            remedy = "A robot is made of rigid links: export it as one plain MJCF file"
            raise RobotError(f"<{tag}> is not supported", file=path, remedy=remedy)
    _refuse_absurd_amounts(root, path)
    root[:] = [section for section in root if section.tag not in _SECTIONS]
    for parent in list(root.iter()):
        files = _FILE_ASSETS if parent.tag == "asset" else frozenset()
        parent[:] = [child for child in parent if child.tag not in files and not _is_plugin_or_relief(child)]
        if parent.tag == "material":
            parent.attrib.pop("texture", None)
            parent[:] = []


def _is_plugin_or_relief(element: Element) -> bool:
    relief = element.get("hfield") is not None or element.get("type") == "hfield"
    return element.tag == "plugin" or (element.tag == "geom" and relief)


def _refuse_absurd_amounts(root: Element, path: Path) -> None:
    copies = sum(_copies(replicate, path) for replicate in root.iter("replicate"))
    if copies > MAX_COPIES:
        raise RobotError("<replicate> asks for too many copies", file=path, value=copies)
    for mesh in root.iter("mesh"):
        finest = max((_number(word, path) for word in mesh.get("params", "").split()), default=0.0)
        if not finest <= MAX_MESH_PARAMETER:
            raise RobotError("a built-in mesh is too fine", file=path, place=mesh.get("name"), value=mesh.get("params"))


def _copies(replicate: Element, path: Path) -> float:
    """Copies asked for by a ``<replicate>`` and those nested in it."""
    copies = max(1.0, _number(replicate.get("count", "1"), path))
    for inner in replicate.findall(".//replicate"):
        copies *= max(1.0, _number(inner.get("count", "1"), path))
    return copies


def _number(text: str, path: Path) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise RobotError("a count is not a number", file=path, value=text) from error
    return value if math.isfinite(value) else math.inf
