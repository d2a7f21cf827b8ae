"""Builds the robot with two arms: ``python assets/robots/two_arms/build_two_arms.py`` rewrites two_arms.xml.

Two of the shipped arms are mounted on a base plate, 0.5 m apart, so that the left hand can touch the right forearm.
Both share the meshes of the single arm; their names have the prefixes ``left_`` and ``right_``.
"""

from __future__ import annotations

import sys
from copy import deepcopy
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

ARM = Path(__file__).parents[1] / "arm" / "arm.xml"
SIDES = {"left": 0.25, "right": -0.25}
"""Position of each arm along y [m]."""
MIRRORED = ("turret_yaw", "upper_arm_roll", "forearm_roll", "hand_roll")
"""Joints with the opposite sign in the home posture of the right arm, so that the arms are mirror images."""
PLATE = "0.10 0.36 0.01"
"""Half extents of the base plate [m]."""


def one_arm(body: Element, side: str, y: float) -> Element:
    """Return a copy of the arm's tree at ``y`` [m] with ``side`` before all names."""
    arm = deepcopy(body)
    for element in arm.iter():
        if element.get("name"):
            element.set("name", f"{side}_{element.get('name')}")
    arm.set("pos", f"0 {y} 0.01")
    return arm


def part(root: Element, path: str) -> Element:
    """The one element at ``path`` of the arm's file."""
    found = root.find(path)
    if found is None:
        raise ValueError(f"arm.xml has no {path}")
    return found


def home(root: Element, side: str) -> list[str]:
    """The arm's posture at rest, mirrored for the right arm."""
    names = [joint.get("name", "") for joint in root.iter("joint")]
    values = part(root, "keyframe/key").get("qpos", "").split()
    turned = MIRRORED if side == "right" else ()
    return [str(0.0 - float(v) if name in turned else float(v)) for name, v in zip(names, values, strict=True)]


def two_arms_xml() -> str:
    """The whole MJCF file."""
    root = ElementTree.parse(ARM).getroot()
    postures = [value for side in SIDES for value in home(root, side)]
    root.set("model", "two_arms")
    part(root, "compiler").set("meshdir", "../arm/meshes")
    world = part(root, "worldbody")
    contact = part(root, "contact")
    arm = part(world, "body")
    world.remove(arm)
    plate = SubElement(world, "body", name="plate")
    SubElement(plate, "geom", name="plate", type="box", size=PLATE, density="2700", rgba="0.30 0.33 0.37 1")
    contact.clear()
    for side, y in SIDES.items():
        plate.append(one_arm(arm, side, y))
        for other in ("plate", f"{side}_turret"):
            SubElement(contact, "exclude", body1=f"{side}_base", body2=other)
    part(root, "keyframe/key").set("qpos", " ".join(postures))
    ElementTree.indent(root)
    return f"<!-- Written by build_two_arms.py: change that, not this. -->\n{ElementTree.tostring(root, 'unicode')}\n"


def build(folder: Path) -> None:
    """Write two_arms.xml into ``folder``, byte for byte the same each time."""
    (folder / "two_arms.xml").write_bytes(two_arms_xml().encode("ascii"))


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
