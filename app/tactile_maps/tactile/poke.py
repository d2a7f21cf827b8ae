"""Inputs and state of a compliant finger that is pressed on the skin. Recordings contain these inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint


@dataclass(frozen=True)
class Finger:
    """A spherical fingertip on a spring. It has friction only where shear is simulated and while it is pulled.

    Attributes:
        stiffness: Spring from the world-fixed fingertip to the skin [N/m], > 0.
        radius: Radius of the fingertip [m], > 0.
        max_force: Largest force of the spring [N], at which the finger stops advancing.
        speed: Speed at which the fingertip advances into the skin while pressed [m/s], >= 0.
    """

    stiffness: float = 1000.0
    radius: float = 0.008
    max_force: float = 20.0
    speed: float = 0.012

    def __post_init__(self) -> None:
        for name, lowest in (("stiffness", 1e-3), ("radius", 1e-4), ("max_force", 0.0), ("speed", 0.0)):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= lowest):
                raise SimulationError(
                    f"the {name.replace('_', ' ')} of the finger is out of range",
                    place=f"finger {name}",
                    value=value,
                    remedy=f"Choose a number of at least {lowest:g}",
                )


@dataclass(frozen=True)
class PokePressed:
    """A finger ``id`` touches the skin at ``at`` and starts to press."""

    id: int
    at: SurfacePoint
    finger: Finger = Finger()


@dataclass(frozen=True)
class PokeMoved:
    """Finger ``id`` slides to ``at`` and keeps its depth."""

    id: int
    at: SurfacePoint


@dataclass(frozen=True)
class PokePulled:
    """Finger ``id`` is pulled towards ``at`` and drags the skin.

    It sticks to its place, and slides towards ``at`` while the pull exceeds its friction. Where shear is not simulated
    it slides as by ``PokeMoved``.
    """

    id: int
    at: SurfacePoint


@dataclass(frozen=True)
class PokeReleased:
    """Finger ``id`` leaves the skin."""

    id: int


PokeInput = PokePressed | PokeMoved | PokePulled | PokeReleased


@dataclass(frozen=True, eq=False)
class PokeState(ArrayFields):
    """A finger at one instant.

    Attributes:
        id: Id of the finger.
        at: Place on the skin.
        force: Along the skin's inward normal [N], >= 0.
        world_position: (3,) touched point [m], world frame.
        world_normal: (3,) outward skin normal, world frame.
        radius: Radius of the fingertip [m].
    """

    id: int
    at: SurfacePoint
    force: float
    world_position: FloatArray
    world_normal: FloatArray
    radius: float
