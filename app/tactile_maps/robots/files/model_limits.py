"""Limits of a model, checked in its text before MuJoCo reads it.

``check_amounts`` limits what costs time and memory. ``check_contents`` accepts only a robot: no file except the given
ones, no plug-in, no request for memory, no other kind of section.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection
from itertools import product
from pathlib import Path
from xml.etree.ElementTree import Element

from tactile_maps.core.errors import RobotError

MAX_COPIES = 2000
MAX_BODIES = 500
MAX_JOINTS = 500
MAX_SHAPES = 5000
MAX_COUPLINGS = 500
MAX_MESHES = 5000
"""Largest number of meshes; the time to look one up by name grows with it."""
MAX_CLASSES = 500
"""Largest number of classes of defaults; resetting one takes milliseconds."""
MAX_PAIRS = 3000
"""Pairs of bodies or shapes that the model excludes from contact or that it lists."""
MAX_MODEL_ELEMENTS = 50_000
"""Elements of all kinds, copies included."""
MAX_CHAIN = 200
"""Largest number of links in a chain; MuJoCo's time grows with the third power, and it stops at 1,000."""
MAX_BUILT_IN_FACES = 200_000
MAX_MESH_PARAMETER = 256.0  # MuJoCo's own shapes are grids of at most this many cells a side
LARGEST_MAGNITUDE = 1e6
"""Largest length [m] and largest value of other units; beyond it float32 is too coarse for shapes."""

_COUNTED = (
    ("bodies", ("body", "link"), MAX_BODIES),
    ("joints", ("joint", "freejoint"), MAX_JOINTS),
    ("shapes", ("geom", "visual", "collision"), MAX_SHAPES),
    ("couplings", ("connect", "weld", "mimic"), MAX_COUPLINGS),
    ("meshes", ("mesh",), MAX_MESHES),
    ("classes of defaults", ("default",), MAX_CLASSES),
    ("pairs in its contact section", ("exclude", "pair"), MAX_PAIRS),
)
_PLACED = ("body", "link", "geom", "joint", "inertial", "origin", "sphere", "box", "cylinder", "capsule")
_OWNERS = ("body", "link", "joint", "geom")
"""Elements that place an invalid value, with their name."""
_NUMBERS = (
    *("value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "lower", "upper", "effort", "damping", "friction", "rpy"),
    *("mass", "density", "diaginertia", "fullinertia", "range", "armature", "frictionloss", "stiffness", "ref"),
    *("quat", "euler", "axisangle", "xyaxes", "zaxis", "axis", "scale", "multiplier", "offset", "margin"),
)
"""Attributes that may not be NaN. A NaN among lengths is too large; a NaN among velocities is a finding."""
_LENGTHS = ("size", "pos", "fromto", "radius", "length", "xyz")


def check_amounts(root: Element, file: Path | str) -> None:
    """Count the elements of the model, including copies by ``<replicate>``.

    Args:
        root: MJCF with its includes unfolded, or URDF.
        file: The file, for errors.

    Raises:
        RobotError: The model exceeds a limit, or a size is out of range.
    """
    counts = _counts(root, file)
    for name, tags, most in _COUNTED:
        count = sum(counts[tag] for tag in tags)
        if count > most:
            remedy = f"The maximum is {most}: leave out what is not part of the robot, or merge rigid parts"
            raise RobotError(f"the robot has more than {most} {name}", file=file, value=count, remedy=remedy)
    if counts.total() > MAX_MODEL_ELEMENTS:
        remedy = f"The maximum is {MAX_MODEL_ELEMENTS}, copies included"
        raise RobotError("the robot has too many elements", file=file, value=counts.total(), remedy=remedy)
    _check_meshes(root, file)
    _check_lengths(root, file)
    _check_numbers(root, file)
    _check_chain(root, file)


def _counts(root: Element, file: Path | str) -> Counter[str]:
    """Return the number of elements of each kind, including copies."""
    counts: Counter[str] = Counter()
    todo: list[tuple[Element, float]] = [(root, 1.0)]
    while todo:
        element, copies = todo.pop()
        if element.tag == "replicate":
            copies *= max(1.0, _number(element.get("count", "1"), file))
            if copies > MAX_COPIES:
                remedy = f"The maximum is {MAX_COPIES}, those nested in each other multiplied"
                raise RobotError("<replicate> asks for too many copies", file=file, value=copies, remedy=remedy)
        counts[element.tag] += int(copies)
        # The elements of a default are settings, except further defaults.
        todo.extend((child, copies) for child in element if element.tag != "default" or child.tag == "default")
    return counts


def _check_meshes(root: Element, file: Path | str) -> None:
    """Limit the shapes that MuJoCo generates."""
    faces = 0.0
    for mesh in root.iter("mesh"):
        params = mesh.get("params", "")
        finest = max((_number(word, file) for word in params.split()), default=0.0)
        if not finest <= MAX_MESH_PARAMETER:
            remedy = f"The maximum is {MAX_MESH_PARAMETER:g} cells a side"
            place = mesh.get("name")
            raise RobotError("a built-in mesh is too fine", file=file, place=place, value=params, remedy=remedy)
        if mesh.get("builtin", "none") != "none":
            faces += 20 * 4 ** min(finest, 10) if "sphere" in mesh.get("builtin", "") else 2 * max(finest, 8) ** 2
    if faces > MAX_BUILT_IN_FACES:
        remedy = f"The maximum is {MAX_BUILT_IN_FACES} triangles together: lower their params"
        raise RobotError("the built-in meshes are too fine", file=file, value=f"{faces:.0f} triangles", remedy=remedy)


def _check_lengths(root: Element, file: Path | str) -> None:
    placed = (element for element in root.iter() if element.tag in _PLACED)
    for element, name in product(placed, _LENGTHS):
        for word in element.get(name, "").split():
            try:
                value = float(word)
            except ValueError:
                continue  # MuJoCo reports the invalid word
            if not abs(value) < LARGEST_MAGNITUDE:
                place = f"{element.tag} {element.get('name', '')}".strip() + f", {name}"
                remedy = f"Lengths are in metres, below {LARGEST_MAGNITUDE:g}"
                problem = "a position or size is implausibly large"
                raise RobotError(problem, file=file, place=place, value=word, remedy=remedy)


def _check_numbers(root: Element, file: Path | str) -> None:
    """Refuse values that are not a number (NaN), which MuJoCo ignores or reports as another error."""
    todo = [(root, "robot")]
    while todo:
        element, owner = todo.pop()
        if element.tag in _OWNERS:
            owner = f"{element.tag} {element.get('name', '')}".strip()
        for name in _NUMBERS if element.tag != "config" else ():  # a plug-in checks its own values
            if any(word.lower().lstrip("+-") == "nan" for word in element.get(name, "").split()):
                own = f"<{element.tag}> " if element.tag not in _OWNERS else ""
                place = f"{owner}, {own}{name}"
                remedy = "Write a finite number, or leave it out to use the default"
                problem = "a value is not a number"
                raise RobotError(problem, file=file, place=place, value=element.get(name), remedy=remedy)
        todo.extend((child, owner) for child in reversed(element))


def _check_chain(root: Element, file: Path | str) -> None:
    """Limit the longest chain of links of a URDF file; that of an MJCF file is limited by the depth of its text."""
    parents: dict[str, str] = {}
    for joint in root.iter("joint"):
        parent = joint.find("parent")
        child = joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = parent.get("link", "")
    for link in parents:
        length = 1
        above = link
        while above in parents and length <= MAX_CHAIN:
            length = length + 1
            above = parents[above]
        if length > MAX_CHAIN:
            remedy = "Look for links that are each other's parents, or merge rigid parts"
            problem = f"a chain has more than {MAX_CHAIN} links"
            raise RobotError(problem, file=file, place=f"link {link}", remedy=remedy)


def _number(text: str, file: Path | str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise RobotError("a count is not a number", file=file, value=text, remedy="Write a whole number") from error
    return value if math.isfinite(value) else math.inf


NO_ROBOT_SECTIONS = frozenset(
    ("actuator", "sensor", "tendon", "option", "size", "visual", "statistic", "custom", "extension", "deformable")
)
"""Sections of MJCF that do not describe the robot's links."""
_NEVER = frozenset(
    (
        "include",
        "attach",
        "model",
        "plugin",
        "extension",
        "composite",
        "flexcomp",
        "hfield",
        "texture",
        "skin",
        "size",
        "option",
    )
)
_FOLDERS = ("meshdir", "texturedir", "assetdir")


def check_contents(root: Element, files: Collection[str], file: Path | str) -> None:
    """Check that a tree describes only a robot and names only given files.

    Args:
        root: Tree that MuJoCo will receive.
        files: Names of the given files.
        file: Source of the text, for errors.

    Raises:
        RobotError: The tree names another file or folder, or contains an element that is not part of a robot.
    """
    if root.tag not in ("mujoco", "robot"):
        raise RobotError(
            "the file is not a robot", file=file, value=f"<{root.tag}>", remedy="Its root is <mujoco> or <robot>"
        )
    remedy = "A robot is made of rigid links: remove it"
    for section in root:
        if section.tag in NO_ROBOT_SECTIONS:
            raise RobotError(f"<{section.tag}> is not allowed in a robot", file=file, remedy=remedy)
    for element in root.iter():
        if element.tag in _NEVER:
            named = element.get("plugin") or element.get("file") or element.get("name")
            raise RobotError(f"<{element.tag}> is not allowed in a robot", file=file, value=named, remedy=remedy)
        for folder in _FOLDERS:
            if element.get(folder):
                raise RobotError("a robot may not name folders", file=file, place=folder, value=element.get(folder))
        for name, value in element.attrib.items():
            if name.startswith("file") and value not in files:
                problem = "MuJoCo cannot build the robot: it names a file that is not its own"
                remedy = "Only the files that came with it are opened"
                raise RobotError(problem, file=file, place=f"<{element.tag}>", value=value, remedy=remedy)
