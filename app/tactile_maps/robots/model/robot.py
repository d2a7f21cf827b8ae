"""The robot as a self-contained value: everything needed to simulate, draw and record it, from any source."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.core.codec import LATER, AnyFloat
from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.geometry.surface.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid body of the robot.

    Attributes:
        name: The body's name in the MJCF; unique.
        mesh: What it looks like, in the link frame [m]; None for a link without geometry.
        missing: Its mesh files that were not there, by their bare names: small boxes stand for them in ``mesh``.
        left_out: Small boxes [m], link frame, at the places of missing meshes of a link that has other shapes. They are
            not part of ``mesh``. A recording does not store them.
    """

    name: str
    mesh: Mesh | None
    missing: tuple[str, ...] = ()
    left_out: tuple[Mesh, ...] = ()


@dataclass(frozen=True)
class Joint:
    """One scalar joint, in the order of the posture vector.

    Attributes:
        name: Unique.
        lower: Lower limit [rad, or m for a slide]; -inf when free.
        upper: Upper limit.
        slide: True for a prismatic joint.
        max_speed: Largest speed that its file states [rad/s, or m/s for a slide]; inf where it states none.
        max_effort: Largest torque of its drive [N m], or force for a slide [N]; inf where its file states none.
    """

    name: str
    lower: AnyFloat
    upper: AnyFloat
    slide: bool = False
    max_speed: AnyFloat = field(default=math.inf, metadata=LATER)
    max_effort: AnyFloat = field(default=math.inf, metadata=LATER)


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot with a fixed base and scalar joints.

    Attributes:
        name: A short name for people.
        source: Where it came from: a path or a library name.
        mjcf: The robot alone as MJCF text: no scene, no actuators, no sensors, no free joint; angles in radians.
        assets: Mesh files the MJCF names, by file name.
        links: Bodies in MJCF order, without the world.
        joints: Joints in posture order.
        home: (len(joints),) the posture at rest, inside the limits.
        findings: What was noticed and repaired while reading it.

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

    def __post_init__(self) -> None:
        freeze_arrays(self, "home")

    @cached_property
    def link_index(self) -> dict[str, int]:
        """Position of each link in ``links``, by name."""
        return {link.name: i for i, link in enumerate(self.links)}

    def link(self, name: str) -> Link:
        """The link called ``name``; raises RobotError naming the valid ones."""
        if name not in self.link_index:
            known = ", ".join(self.link_index)
            raise RobotError("there is no such link", file=self.source, value=name, remedy=f"Choose one of: {known}")
        return self.links[self.link_index[name]]
