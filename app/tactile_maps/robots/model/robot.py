"""Robot as a self-contained value: everything needed to simulate, draw and record it, from any source."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.codec import LATER, AnyFloat
from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.geometry.surface.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body of the robot.

    Attributes:
        name: The body's name in the MJCF; unique.
        mesh: Visible shape in the link frame [m]; None for a link without geometry.
        missing: Bare names of its missing mesh files, which small boxes replace in ``mesh``.
        left_out: Small boxes [m], link frame, at the places of missing meshes of a link that has other shapes. They are
            not part of ``mesh``, and a recording does not store them.
    """

    name: str
    mesh: Mesh | None
    missing: tuple[str, ...] = ()
    left_out: tuple[Mesh, ...] = ()


@dataclass(frozen=True)
class Joint:
    """A scalar joint, in the order of the posture vector.

    Attributes:
        name: Unique name.
        lower: Lower limit [rad, or m for a slide]; -inf without limit.
        upper: Upper limit.
        slide: True for a prismatic joint.
        max_speed: Largest speed that its file states [rad/s, or m/s for a slide]; inf if it states none.
        max_effort: Largest torque of its drive [N m], or force for a slide [N]; inf if its file states none.
    """

    name: str
    lower: AnyFloat
    upper: AnyFloat
    slide: bool = False
    max_speed: AnyFloat = field(default=math.inf, metadata=LATER)
    max_effort: AnyFloat = field(default=math.inf, metadata=LATER)


@dataclass(frozen=True, eq=False)
class Robot(ArrayFields):
    """A robot with a fixed base and scalar joints.

    Attributes:
        name: Short name for the user.
        source: Path or library name of its origin.
        mjcf: The robot alone as MJCF text: no scene, no actuators, no sensors, no free joint; angles in radians.
        assets: Mesh files that the MJCF names, by file name.
        links: Bodies in MJCF order, without the world.
        joints: Joints in posture order.
        home: (len(joints),) home posture, inside the limits.
        findings: Problems noticed and repaired while reading it.

    Example:
        >>> robot = tm.load_robot("arm")
        >>> len(robot.joints), robot.links[0].name
        (7, 'base')
    """

    name: str
    source: str
    mjcf: str
    assets: Mapping[str, bytes]
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    home: FloatArray
    findings: tuple[Finding, ...] = ()

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints in the order of a posture."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def link_index(self) -> dict[str, int]:
        """Position of each link in ``links``, by name."""
        return {link.name: i for i, link in enumerate(self.links)}

    def link(self, name: str) -> Link:
        """Return the link called ``name``; raises RobotError, which names the valid ones."""
        if name not in self.link_index:
            known = ", ".join(self.link_index)
            raise RobotError("unknown link", file=self.source, value=name, remedy=f"Choose one of: {known}")
        return self.links[self.link_index[name]]
