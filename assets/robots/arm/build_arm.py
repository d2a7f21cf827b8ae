"""Builds the arm that ships with the app: ``python assets/robots/arm/build_arm.py`` rewrites arm.xml and its meshes.

Seven joints in the order shoulder, elbow, wrist. Roll joints meet end to end, pitch joints side by side, so every link
may be one convex, watertight loft: MuJoCo collides with the convex hull of a mesh, and here hull and skin are the same
surface. A link is a stack of super-ellipses |x/a|^n + |y/b|^n = 1 along its z axis, closed by a cap at both ends:
*flat* for a roll joint, *disc* for a pitch joint whose axis is y, *dome* for the free end.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

DENSITY = 1150  # kg/m³: shell, motors and gears averaged
OVERLAP = 0.002  # m: neighbours dip into each other so that no light shows through a joint
RIM = 0.012  # m: height of a flat end's rounded rim
RIM_EXPONENT = 3.5  # the larger, the flatter the end and the tighter its rim
SHELL = "0.90 0.91 0.92 1"
DARK = "0.30 0.33 0.37 1"


@dataclass(frozen=True)
class Link:
    """Link: a loft along z between the sections at z = 0 and z = ``length`` [m]; its joint is at the origin.

    Attributes:
        a: Half widths along x at the low section, half way and at the high section [m].
        b: The same along y.
        n: Exponents of the super-ellipse at the low and the high section; 2 is an ellipse.
        caps: Kinds of the low and the high cap: ``flat``, ``disc`` or ``dome``.
        edge: Target length of a triangle's side [m].
        colour: Red, green, blue, opacity.
    """

    name: str
    length: float
    a: tuple[float, float, float]
    b: tuple[float, float, float]
    n: tuple[float, float]
    caps: tuple[str, str]
    edge: float
    colour: str = SHELL


@dataclass(frozen=True)
class Hinge:
    """The joint that carries a link: axis ``z`` (roll) or ``y`` (pitch); radians and SI units."""

    name: str
    axis: str
    limit: float
    armature: float
    damping: float
    home: float


LINKS = (
    Link("base", 0.090, (0.100, 0.094, 0.084), (0.100, 0.094, 0.084), (2.0, 2.0), ("flat", "flat"), 0.0100, DARK),
    Link("turret", 0.125, (0.080, 0.0805, 0.078), (0.080, 0.0785, 0.074), (2.0, 3.0), ("flat", "disc"), 0.0085),
    Link("shoulder", 0.125, (0.075, 0.073, 0.066), (0.068, 0.0675, 0.064), (3.0, 2.0), ("disc", "flat"), 0.0085, DARK),
    Link("upper_arm", 0.255, (0.064, 0.070, 0.061), (0.062, 0.063, 0.057), (2.0, 3.0), ("flat", "disc"), 0.0080),
    Link("elbow", 0.095, (0.060, 0.058, 0.053), (0.055, 0.054, 0.052), (3.0, 2.0), ("disc", "flat"), 0.0075, DARK),
    Link("forearm", 0.245, (0.052, 0.0560, 0.0485), (0.051, 0.0515, 0.045), (2.0, 3.0), ("flat", "disc"), 0.0072),
    Link("wrist", 0.075, (0.046, 0.045, 0.040), (0.042, 0.041, 0.039), (3.0, 2.0), ("disc", "flat"), 0.0065, DARK),
    Link("hand", 0.060, (0.039, 0.041, 0.040), (0.038, 0.0375, 0.035), (2.0, 2.2), ("flat", "dome"), 0.0060),
)
HINGES = (
    Hinge("turret_yaw", "z", 2.97, 0.10, 2.0, 0.35),
    Hinge("shoulder_pitch", "y", 2.09, 0.10, 2.0, 0.25),
    Hinge("upper_arm_roll", "z", 2.97, 0.08, 1.5, -0.25),
    Hinge("elbow_pitch", "y", 2.35, 0.08, 1.5, 1.45),
    Hinge("forearm_roll", "z", 2.97, 0.05, 1.0, 0.30),
    Hinge("wrist_pitch", "y", 2.09, 0.02, 0.4, 0.85),
    Hinge("hand_roll", "z", 2.97, 0.01, 0.3, 0.00),
)


def section(n: float, edge: float, size: float) -> FloatArray:
    """A ring of points (k, 2) evenly spaced along the unit super-ellipse |x|^n + |y|^n = 1, counter-clockwise."""
    angle = np.linspace(0.0, 2.0 * np.pi, 4097)
    c = np.cos(angle)
    s = np.sin(angle)
    ring = np.stack([np.sign(c) * np.abs(c) ** (2 / n), np.sign(s) * np.abs(s) ** (2 / n)], axis=1)
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    count = max(6, round(walked[-1] * size / edge))
    at = np.arange(count) / count * walked[-1]
    return np.stack([np.interp(at, walked, ring[:, k]) for k in range(2)], axis=1)


def bend(values: tuple[float, float, float], t: float) -> float:
    """The parabola through ``values`` at t = 0, 1/2 and 1."""
    low, middle, high = values
    return low * (1 - t) * (1 - 2 * t) + middle * 4 * t * (1 - t) + high * t * (2 * t - 1)


def cap_height(kind: str, ring: FloatArray, scale: float, a: float, b: float, n: float) -> FloatArray:
    """Height (k,) [m] of a cap above its section at the points ``scale * ring`` of the unit section."""
    if kind == "disc":  # |y/b|^n + (r/a)^n = 1 with r the distance from the joint's axis: a disc with a soft rim
        y = np.abs(scale * ring[:, 1])
        radius = a * np.clip(1 - y**n, 0, 1) ** (1 / n)
        return np.sqrt(np.clip(radius**2 - (a * scale * ring[:, 0]) ** 2, 0, None))
    height, exponent = (RIM, RIM_EXPONENT) if kind == "flat" else (1.1 * b, 2.2)
    return np.full(len(ring), height * max(0.0, 1 - scale**exponent) ** (1 / exponent))


def cap_scales(kind: str, a: float, b: float, n: float, edge: float) -> FloatArray:
    """Scales of a cap's rings, from next to the section (just below 1) down to the last before the pole."""
    fine = 1 - np.linspace(0.0, 1.0, 2001) ** 2
    ring = section(n, 0.3, 1.0)
    points = [np.column_stack([s * ring * (a, b), cap_height(kind, ring, s, a, b, n)]) for s in fine]
    steps = np.linalg.norm(np.diff(np.array(points), axis=0), axis=2).mean(axis=1)
    walked = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(3, round(walked[-1] / (0.87 * edge)))
    scales: FloatArray = np.interp(np.arange(1, count) / count * walked[-1], walked, fine)
    return scales


def cap_rings(link: Link, top: bool) -> list[FloatArray]:
    """Rings (k, 3) of one cap from the section towards the pole, the pole (1, 3) last."""
    side = 1 if top else 0
    a = link.a[2 * side]
    b = link.b[2 * side]
    n = link.n[side]
    rings = []
    for scale in [*cap_scales(link.caps[side], a, b, n, link.edge), 0.0]:
        ring = section(n, link.edge, scale * (a + b) / 2) if scale else np.zeros((1, 2))
        height = cap_height(link.caps[side], ring, scale, a, b, n)
        z = link.length + height if top else -height
        rings.append(np.column_stack([scale * ring * (a, b), z]))
    return rings


def body_rings(link: Link) -> list[FloatArray]:
    """Rings (k, 3) from the low section to the high one."""
    rings = []
    count = round(link.length / (0.87 * link.edge))
    for t in (k / count for k in range(count + 1)):
        a = bend(link.a, t)
        b = bend(link.b, t)
        ease = 1 - (1 - t) ** 2 if link.n[1] > link.n[0] else t**2  # keeps the diagonals convex
        ring = section(link.n[0] + (link.n[1] - link.n[0]) * ease, link.edge, (a + b) / 2)
        rings.append(np.column_stack([ring * (a, b), np.full(len(ring), link.length * t)]))
    return rings


def zip_rings(low: int, low_count: int, high: int, high_count: int) -> list[tuple[int, int, int]]:
    """Triangles of the band between two rings of vertices that start at ``low`` and ``high``; outside is outside."""
    if low_count == 1:
        return [(low, high + (j + 1) % high_count, high + j) for j in range(high_count)]
    if high_count == 1:
        return [(low + i, low + (i + 1) % low_count, high) for i in range(low_count)]
    faces = []
    i = 0
    j = 0
    while i < low_count or j < high_count:
        here = (low + i % low_count, high + j % high_count)
        if j == high_count or (i < low_count and (2 * i + 1) * high_count <= (2 * j + 1) * low_count):
            faces.append((here[0], low + (i + 1) % low_count, here[1]))
            i += 1
        else:
            faces.append((here[0], high + (j + 1) % high_count, here[1]))
            j += 1
    return faces


def loft(link: Link) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) [m] and outward faces (m, 3) of a link, in its own frame."""
    rings = cap_rings(link, top=False)[::-1] + body_rings(link) + cap_rings(link, top=True)
    starts = np.concatenate([[0], np.cumsum([len(ring) for ring in rings])])
    faces: list[tuple[int, int, int]] = []
    for k in range(len(rings) - 1):
        faces += zip_rings(int(starts[k]), len(rings[k]), int(starts[k + 1]), len(rings[k + 1]))
    vertices = np.concatenate(rings)
    if link.caps[0] != "disc":
        vertices[:, 2] += RIM  # the joint of a roll link is where the cap ends, not where it begins
    return vertices, np.array(faces, dtype=np.int64)


def to_obj(vertices: FloatArray, faces: IntArray) -> str:
    """Wavefront OBJ text with 10 µm steps."""
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices + 0.0]
    lines += [f"f {i} {j} {k}" for i, j, k in faces + 1]
    return "\n".join(lines).replace("-0.00000", "0.00000") + "\n"


def joint_offsets() -> list[tuple[float, float, float]]:
    """Return the origin of each link's frame in its parent's [m]; pitch joints are offset to alternate sides."""
    offsets = []
    side = 1.0
    for parent, child, hinge in zip(LINKS[:-1], LINKS[1:], HINGES, strict=True):
        foot = 0.0 if parent.caps[0] == "disc" else RIM
        if hinge.axis == "z":
            offsets.append((0.0, 0.0, foot + parent.length + RIM - OVERLAP))
        else:
            offsets.append((0.0, side * (parent.b[2] + child.b[0] - OVERLAP), foot + parent.length))
            side = -side
    return offsets


def body_xml(index: int, offsets: list[tuple[float, float, float]]) -> str:
    """The ``<body>`` of link ``index`` with everything it carries inside."""
    link = LINKS[index]
    pad = "  " * (index + 2)
    place = ""
    joint = ""
    if index:
        hinge = HINGES[index - 1]
        place = ' pos="{:.5f} {:.5f} {:.5f}"'.format(*offsets[index - 1])
        joint = (
            f'{pad}  <joint name="{hinge.name}" axis="{"0 0 1" if hinge.axis == "z" else "0 1 0"}"'
            f' range="{-hinge.limit} {hinge.limit}" armature="{hinge.armature}" damping="{hinge.damping}"/>\n'
        )
    child = body_xml(index + 1, offsets) if index + 1 < len(LINKS) else ""
    return (
        f'{pad}<body name="{link.name}"{place}>\n{joint}'
        f'{pad}  <geom name="{link.name}_visual" class="visual" mesh="{link.name}" rgba="{link.colour}"/>\n'
        f'{pad}  <geom name="{link.name}_collision" class="collision" mesh="{link.name}"/>\n'
        f"{child}{pad}</body>\n"
    )


def arm_xml() -> str:
    """The whole MJCF file."""
    meshes = "".join(f'    <mesh name="{link.name}" file="{link.name}.obj"/>\n' for link in LINKS)
    home = " ".join(str(hinge.home) for hinge in HINGES)
    return (
        "<!-- Written by build_arm.py: change that, not this. -->\n"
        '<mujoco model="arm">\n'
        '  <compiler angle="radian" autolimits="true" meshdir="meshes" inertiafromgeom="true"/>\n'
        '  <default>\n    <default class="visual">\n'
        '      <geom type="mesh" group="2" contype="0" conaffinity="0" density="0"/>\n    </default>\n'
        '    <default class="collision">\n'
        f'      <geom type="mesh" group="3" density="{DENSITY}"/>\n    </default>\n  </default>\n'
        f"  <asset>\n{meshes}  </asset>\n"
        f"  <worldbody>\n{body_xml(0, joint_offsets())}  </worldbody>\n"
        '  <contact>\n    <exclude body1="base" body2="turret"/>\n  </contact>\n'
        f'  <keyframe>\n    <key name="home" qpos="{home}"/>\n  </keyframe>\n'
        "</mujoco>\n"
    )


def build(folder: Path) -> None:
    """Write arm.xml and meshes/*.obj into ``folder``, byte for byte the same each time."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    for link in LINKS:
        (folder / "meshes" / f"{link.name}.obj").write_bytes(to_obj(*loft(link)).encode("ascii"))
    (folder / "arm.xml").write_bytes(arm_xml().encode("ascii"))


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
