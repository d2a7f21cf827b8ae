"""A pin: a place of the body held at a place of the plane."""

from __future__ import annotations

from dataclasses import dataclass

from app.geometry.surface_point import SurfacePoint


@dataclass(frozen=True)
class Pin:
    """A place of the body held at a place of the plane.

    Attributes:
        at: On the body.
        place: (x, y) in the chart's own frame [m], so that pins move with their patch.
    """

    at: SurfacePoint
    place: tuple[float, float]
