"""A contact region: one touched area of the skin, read from the tactile map."""

from __future__ import annotations

from dataclasses import dataclass

from app.arrays import FloatArray, IntArray, readonly
from app.geometry.surface_point import SurfacePoint


@dataclass(frozen=True, eq=False)
class ContactRegion:
    """A connected touched area.

    Attributes:
        id: Kept while the region lives, from frame to frame.
        taxels: (k,) taxel numbers, the touched ones and their one-ring.
        force: Sum of pressure times area over them [N]; normal force only, shear is not observable.
        area: Of the touched taxels [m²].
        peak: Highest pressure [Pa].
        map_point: (2,) centre of pressure on the tactile map [m].
        at: The centre of pressure back-projected to the body.
        link: Name of the touched link.
        point: (3,) the same point, link frame [m].
        normal: (3,) outward unit normal there, link frame.
        torn: Whether a seam tears the region apart on the map, so that its centre was taken on the body instead.
    """

    id: int
    taxels: IntArray
    force: float
    area: float
    peak: float
    map_point: FloatArray
    at: SurfacePoint
    link: str
    point: FloatArray
    normal: FloatArray
    torn: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "taxels", readonly(self.taxels, int))
        for name in ("map_point", "point", "normal"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
