"""Builds the arm that ships with the app: ``python assets/robots/arm/build_arm.py`` rewrites arm.xml and its meshes.

Seven joints in the order shoulder, elbow, wrist. Roll joints meet end to end, pitch joints side by side, so every link
may be one convex, watertight loft: MuJoCo collides with the convex hull of a mesh, and here hull and skin are the same
surface. A link is a stack of super-ellipses |x/a|^n + |y/b|^n = 1 along its z axis. A *flat* end belongs to a roll
joint, a *disc* end to a pitch joint whose axis is y, a *dome* is free.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

DENSITY = 1150.0  # kg/m³, shell, motors and gears averaged
OVERLAP = 0.002  # m, neighbours dip into each other so that no light shows through a joint
CORNER = 4.5  # exponent of the rounded rims
SHELL, DARK = "0.90 0.91 0.92 1", "0.29 0.32 0.36 1"


@dataclass(frozen=True)
class Link:
    """One link: a loft from z = ``low`` to z = ``high`` [m], in a frame whose origin is its joint.

    Attributes:
        a: Half widths along x at the low end, in the middle and at the high end [m].
        b: The same along y.
        n: Exponents of the super-ellipse at the low and the high end; 2 is an ellipse.
        ends: Kinds of the low and the high end: ``flat``, ``disc`` or ``dome``.
        edge: Target length of a triangle's side [m].
    """

    name: str
    low: float
    high: float
    a: tuple[float, float, float]
    b: tuple[float, float, float]
    n: tuple[float, float]
    ends: tuple[str, str]
    edge: float
    colour: str = SHELL


@dataclass(frozen=True)
class Hinge:
    """The joint that carries a link; ``offset`` [m] is its place in the parent's frame. SI units, radians."""

    name: str
    axis: str
    offset: tuple[float, float, float]
    limit: float
    armature: float
    damping: float
    home: float


LINKS = (
    Link("base", 0.000, 0.110, (0.098, 0.091, 0.080), (0.098, 0.091, 0.080), (2.0, 2.0), ("flat", "flat"), 0.0100, DARK),
    Link("shoulder", 0.000, 0.150, (0.080, 0.080, 0.078), (0.080, 0.076, 0.070), (2.0, 2.9), ("flat", "disc"), 0.0085),
    Link("upper_arm", 0.000, 0.130, (0.076, 0.073, 0.064), (0.067, 0.066, 0.063), (2.9, 2.0), ("disc", "flat"), 0.0085),
    Link("elbow", 0.000, 0.270, (0.064, 0.069, 0.063), (0.063, 0.063, 0.058), (2.0, 2.9), ("flat", "disc"), 0.0080),
    Link("forearm", 0.000, 0.100, (0.061, 0.058, 0.052), (0.055, 0.054, 0.051), (2.9, 2.0), ("disc", "flat"), 0.0075),
    Link("lower_arm", 0.000, 0.260, (0.052, 0.056, 0.048), (0.051, 0.051, 0.044), (2.0, 2.9), ("flat", "disc"), 0.0072),
    Link("wrist", 0.000, 0.085, (0.047, 0.045, 0.040), (0.042, 0.041, 0.039), (2.9, 2.0), ("disc", "flat"), 0.0065),
    Link("hand", 0.000, 0.070, (0.040, 0.043, 0.036), (0.039, 0.036, 0.028), (2.0, 2.4), ("flat", "dome"), 0.0060, DARK),
)
