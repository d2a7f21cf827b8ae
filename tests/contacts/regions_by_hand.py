"""Contact regions without a reader, for what follows them."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.geometry.surface.mesh import SurfacePoint


def region(id_: int, **said) -> ContactRegion:
    """A region of 1 N at the forearm's origin, facing up; ``link_position`` moves it."""
    known = {
        "taxels": np.array([id_]),
        "force": 1.0,
        "area": 1e-4,
        "peak": 1e4,
        "map_point": np.zeros(2),
        "at": SurfacePoint(0, id_, (1.0, 0.0, 0.0)),
        "link": "forearm",
        "link_position": np.zeros(3),
        "link_normal": np.array([0.0, 0.0, 1.0]),
    }
    return ContactRegion(id_, **(known | said))
