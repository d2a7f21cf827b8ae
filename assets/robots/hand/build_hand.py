"""Builds the hand: ``python assets/robots/hand/build_hand.py`` rewrites hand.xml and its meshes.

A palm with two fingers that point down, on a vertical slide. Palm and fingers are lofts like the links of the arm.
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

ARM = runpy.run_path(str(Path(__file__).parents[1] / "arm" / "build_arm.py"))
PALM = ARM["Link"]("palm", 0.030, (0.050, 0.052, 0.050), (0.026, 0.028, 0.026), (3.0, 3.0), ("flat", "flat"), 0.0060)
FINGER = ARM["Link"](
    "finger", 0.070, (0.0120, 0.0120, 0.0120), (0.0125, 0.0130, 0.0120), (3.0, 2.0), ("disc", "dome"), 0.0025
)
HEIGHT = 0.24
"""Height of the palm's upper face above the ground [m]."""
APART = 0.030
"""Distance of each finger from the middle of the hand [m]."""
KNUCKLE = 0.060
"""Distance of the fingers' joints from the palm's upper face [m]."""
OPEN = 0.2
"""Angle by which each finger leans outward at home [rad]."""


def finger_xml(side: str, sign: int) -> str:
    """The ``<body>`` of one finger; ``sign`` is the side along x."""
    name = f"{side}_finger"
    return (
        f'      <body name="{name}" pos="{sign * APART} 0 {KNUCKLE}">\n'
        f'        <joint name="{name}" axis="0 1 0" range="-0.6 0.6" armature="0.002" damping="0.02"/>\n'
        f'        <geom name="{name}_visual" class="visual" mesh="finger" rgba="{ARM["SHELL"]}"/>\n'
        f'        <geom name="{name}_collision" class="collision" mesh="finger"/>\n'
        "      </body>\n"
    )


def hand_xml() -> str:
    """The whole MJCF file."""
    meshes = "".join(f'    <mesh name="{link.name}" file="{link.name}.obj"/>\n' for link in (PALM, FINGER))
    return (
        "<!-- Written by build_hand.py: change that, not this. -->\n"
        '<mujoco model="hand">\n'
        '  <compiler angle="radian" autolimits="true" meshdir="meshes" inertiafromgeom="true"/>\n'
        '  <default>\n    <default class="visual">\n'
        '      <geom type="mesh" group="2" contype="0" conaffinity="0" density="0"/>\n    </default>\n'
        '    <default class="collision">\n'
        f'      <geom type="mesh" group="3" density="{ARM["DENSITY"]}"/>\n    </default>\n  </default>\n'
        f"  <asset>\n{meshes}  </asset>\n"
        "  <worldbody>\n"
        f'    <body name="palm" pos="0 0 {HEIGHT}" quat="0 1 0 0">\n'
        '      <joint name="lift" type="slide" axis="0 0 -1" range="-0.02 0.3" armature="0.5" damping="20"/>\n'
        f'      <geom name="palm_visual" class="visual" mesh="palm" rgba="{ARM["DARK"]}"/>\n'
        '      <geom name="palm_collision" class="collision" mesh="palm"/>\n'
        f"{finger_xml('left', -1)}{finger_xml('right', 1)}"
        "    </body>\n  </worldbody>\n"
        f'  <keyframe>\n    <key name="home" qpos="0 {-OPEN} {OPEN}"/>\n  </keyframe>\n'
        "</mujoco>\n"
    )


def build(folder: Path) -> None:
    """Write hand.xml and meshes/*.obj into ``folder``, byte for byte the same each time."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    for link in (PALM, FINGER):
        (folder / "meshes" / f"{link.name}.obj").write_bytes(ARM["to_obj"](*ARM["loft"](link)).encode("ascii"))
    (folder / "hand.xml").write_bytes(hand_xml().encode("ascii"))


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
