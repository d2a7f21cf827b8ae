"""Maps that somebody drew by hand, told in the taxels of a skin so that they can be compared with its own map."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.errors import MapError
from app.maps.compare import TaxelLayout
from app.skin.exchange.taxel_set import TaxelSet
from app.skin.skin import Skin

FARTHEST = 0.02
"""A taxel of the drawing farther than this [m] from every taxel of the skin is another skin's."""


def hand_made(taxels: TaxelSet, skin: Skin) -> TaxelLayout:
    """The map points of ``taxels``, each given to the taxel of ``skin`` that is nearest to it on the body.

    Raises:
        MapError: The taxels have no map points, or most lie on another body.
    """
    if taxels.points is None or not taxels.mapped.any():
        raise MapError(
            "the file has no map points to compare with", file=taxels.name, remedy="Give columns u and v, or a layout"
        )
    shown = taxels.select(taxels.mapped)
    own = np.concatenate([patch.taxels.positions for patch in skin.patches])
    away, nearest = cKDTree(own).query(shown.positions)
    if np.median(away) > FARTHEST:
        raise MapError(
            "the drawing is not of this skin",
            file=taxels.name,
            value=f"taxels {1e3 * np.median(away):.0f} mm from the skin's in the median",
            remedy="Compare maps of the same taxels, in the same frame",
        )
    # Of several at one place, the nearest speaks for all.
    order = np.argsort(away, kind="stable")
    _, first = np.unique(nearest[order], return_index=True)
    chosen = np.sort(order[first])
    assert shown.points is not None
    return TaxelLayout(shown.points[chosen], nearest[chosen])
