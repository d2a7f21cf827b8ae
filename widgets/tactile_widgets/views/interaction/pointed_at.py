"""What is under the pointer, as a view knows it: skin, or another body of the scene."""

from __future__ import annotations

from dataclasses import dataclass

from tactile_maps.geometry.surface.mesh import SurfacePoint


@dataclass(frozen=True)
class PointedAt:
    """What a person points at.

    Attributes:
        at: The place of the skin; None beside it.
        body: Without skin there: the number of the link, or of the object behind the links; None for nothing.
    """

    at: SurfacePoint | None = None
    body: int | None = None
