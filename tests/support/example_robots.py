"""Small hand-written robots for tests of the skin."""

from __future__ import annotations

import numpy as np
import trimesh

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.robot import Joint, Link, Robot


def rod(length: float, radius: float) -> Mesh:
    """Return a closed cylinder from the origin upward."""
    shape = trimesh.creation.cylinder(radius=radius, height=length, sections=32).subdivide()
    return Mesh(np.add(shape.vertices, [0, 0, length / 2]), np.asarray(shape.faces))


def two_rods(*, buried: float = 0.0, length: float = 0.3) -> Robot:
    """Return a base and a rotating rod above it, ``length`` [m] long, which starts ``buried`` [m] inside the base."""
    base = rod(0.2, 0.05)
    upper = rod(length, 0.04)
    mjcf = f"""<mujoco><worldbody><body name="base">
      <body name="upper" pos="0 0 {0.2 - buried}">
        <inertial pos="0 0 0.15" mass="1" diaginertia="0.01 0.01 0.01"/>
        <joint name="turn" axis="0 0 1" range="-1 1"/>
      </body><body name="frame" pos="0 0 1"/></body></worldbody></mujoco>"""
    links = (Link("base", base), Link("upper", upper), Link("frame", None))
    return Robot("rods", "rods.xml", mjcf, {}, links, (Joint("turn", -1, 1),), np.zeros(1))
