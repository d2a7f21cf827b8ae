"""Bodies that press the skin, by their signed distance: how far a point is from the surface, negative inside."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from app.arrays import FloatArray


class Shape(Protocol):
    """A solid body about its own frame."""

    @property
    def reach(self) -> float:
        """Radius [m] about the origin of the body's frame that holds all of it; inf for a plane."""

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m] of ``points`` (k, 3) [m], body frame; negative inside."""


@dataclass(frozen=True)
class Ball:
    """A sphere about the origin.

    Attributes:
        radius: [m], > 0.
    """

    radius: float

    @property
    def reach(self) -> float:
        """Its radius [m]."""
        return self.radius

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        distance: FloatArray = np.sqrt(np.vecdot(points, points))
        distance -= self.radius
        return distance


@dataclass(frozen=True)
class Box:
    """A box about the origin, its sides along the axes.

    Attributes:
        half: Half of each side [m], > 0.
    """

    half: tuple[float, float, float]

    @property
    def reach(self) -> float:
        """Half its diagonal [m]."""
        return math.hypot(*self.half)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        beyond = np.abs(points) - self.half
        inside = np.minimum(beyond.max(axis=1, initial=-np.inf), 0.0)
        np.maximum(beyond, 0.0, out=beyond)
        return np.asarray(np.sqrt(np.vecdot(beyond, beyond)) + inside)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about the origin, its axis along z.

    Attributes:
        radius: [m], > 0.
        half: Half its height [m], > 0.
    """

    radius: float
    half: float

    @property
    def reach(self) -> float:
        """From its middle to its rim [m]."""
        return math.hypot(self.radius, self.half)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        aside = np.hypot(points[:, 0], points[:, 1]) - self.radius
        above = np.abs(points[:, 2]) - self.half
        inside = np.minimum(np.maximum(aside, above), 0.0)
        return np.asarray(np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0)) + inside)


@dataclass(frozen=True)
class Plane:
    """The ground: all below z = 0 is solid."""

    @property
    def reach(self) -> float:
        """It has no end."""
        return math.inf

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        return np.array(points[:, 2])
