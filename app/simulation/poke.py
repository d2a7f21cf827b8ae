"""Pokes: a compliant finger pressed on the skin, as data. What the hand did is recorded as these inputs."""

from __future__ import annotations

from dataclasses import dataclass

from app.arrays import FloatArray, readonly
from app.geometry.surface_point import SurfacePoint


@dataclass(frozen=True)
class Finger:
    """A frictionless spherical fingertip on a spring.

    Attributes:
        stiffness: Spring from the world-fixed fingertip to the skin [N/m].
        radius: Of the fingertip [m].
        max_force: The spring never pushes harder [N]; the finger stops advancing there.
        speed: How fast the fingertip advances into the skin while held [m/s].
    """

    stiffness: float = 1000.0
    radius: float = 0.008
    max_force: float = 20.0
    speed: float = 0.012


@dataclass(frozen=True)
class PokePressed:
    """A finger ``id`` touches the skin at ``at`` and starts to press."""

    id: int
    at: SurfacePoint
    finger: Finger = Finger()


@dataclass(frozen=True)
class PokeMoved:
    """Finger ``id`` strokes to ``at`` and keeps its depth."""

    id: int
    at: SurfacePoint


@dataclass(frozen=True)
class PokeReleased:
    """Finger ``id`` leaves the skin."""

    id: int


PokeInput = PokePressed | PokeMoved | PokeReleased


@dataclass(frozen=True, eq=False)
class PokeState:
    """One finger at one instant.

    Attributes:
        id: Which finger.
        at: Where it touches.
        force: Along the skin's inward normal [N], >= 0.
        point: (3,) touched point, world [m].
        normal: (3,) outward skin normal, world.
        radius: Of the fingertip [m].
    """

    id: int
    at: SurfacePoint
    force: float
    point: FloatArray
    normal: FloatArray
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", readonly(self.point))
        object.__setattr__(self, "normal", readonly(self.normal))
