"""All quadrature points of a skin as one value: pressure is evaluated there, whichever model does it."""

from __future__ import annotations

import numpy as np

from app.skin.skin import Skin
from app.skin.taxels import Quadrature


def skin_points(skin: Skin) -> Quadrature:
    """The quadrature points of all patches, patch after patch; their number here is what models call a point.

    Positions and normals are in the frame of the link that wears the patch; ``taxel`` is numbered through the skin.
    """
    parts = [patch.taxels.quadrature for patch in skin.patches]
    if not parts:
        return Quadrature(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
    return Quadrature(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.areas for part in parts]),
        np.concatenate([part.taxel + first for part, first in zip(parts, skin.first[:-1], strict=True)]),
    )
