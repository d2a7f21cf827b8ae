"""A point on the skin: the one currency in which body and map speak of a place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SurfacePoint:
    """A place on the skin that moves with it.

    Attributes:
        patch: Index of the patch in the skin.
        face: Index of the triangle in the patch's surface.
        weights: Barycentric weights of the triangle's three corners; they sum to one and are not negative.
    """

    patch: int
    face: int
    weights: tuple[float, float, float]
