"""A contact region: one touched area of the skin, read from the tactile map."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.geometry.surface_point import SurfacePoint

_NO_AXES, _NO_MAP_AXES = readonly(np.zeros((2, 3))), readonly(np.zeros((2, 2)))


@dataclass(frozen=True, eq=False)
class ContactRegion:
    """A connected touched area.

    Attributes:
        id: Kept while the region lives, from frame to frame; 1 or more.
        taxels: (k,) taxel numbers, the touched ones and their one-ring, rising.
        force: Sum of pressure times area over them [N]; normal force only, shear is not observable.
        area: Of the touched taxels [m²].
        peak: Highest pressure [Pa].
        map_point: (2,) centre of pressure on the tactile map [m].
        at: The centre of pressure back-projected to the body.
        link: Name of the touched link.
        point: (3,) the same point, link frame [m].
        normal: (3,) outward unit normal there, link frame.
        torn: Whether a seam tears the region apart on the map, so that its centre was taken on the body instead.
        mean: Mean pressure over the touched taxels [Pa].
        axes: (2, 3) half-axes of the ellipse with the region's second moments, the longer first, link frame [m].
        map_axes: (2, 2) the same two on the map [m]; as the map distorts there they need not be at right angles, but
            ``map_point + cos t map_axes[0] + sin t map_axes[1]`` still draws the ellipse.
        place_error: Standard uncertainty of the centre, radial [m]; see ``accuracy``.
        force_error: Standard uncertainty of the force [N].
        partner: Id of the region on another link that touches this one; 0 for none known.
        merged: Ids of the regions that have become part of this one at this frame.
        split_from: Id of the region that this one has come off at this frame; 0 for none.
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
    mean: float = 0.0
    axes: FloatArray = field(default_factory=lambda: _NO_AXES)
    map_axes: FloatArray = field(default_factory=lambda: _NO_MAP_AXES)
    place_error: float = 0.0
    force_error: float = 0.0
    partner: int = 0
    merged: tuple[int, ...] = ()
    split_from: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "taxels", readonly(self.taxels, np.int64))
        for name in ("map_point", "point", "normal", "axes", "map_axes"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
