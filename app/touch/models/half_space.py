"""The half-space model: what taxels feel that lie under a cover, where forces have spread out.

The traction at the surface is water-fill's. Below it, a force spreads as in an elastic half-space (Love's stress under
a small square, whatever the material), so a taxel feels what presses beside it: a cover is a blur. The blur is a
receptive field built once, so this costs a reading little more than water-fill.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray
from app.errors import SimulationError
from app.skin.skin import Skin
from app.touch.layer import Layer
from app.touch.love import reach, rectangle_stress
from app.touch.models.water_fill import WaterFill
from app.touch.points import skin_points
from app.touch.receptive_field import ReceptiveField, as_table, whole_cells

SHARE = 0.01
"""Of a force, what passes so far aside that its whereabouts are not followed."""
_FACING = 0.2
_LAYER = Layer()
_MOST_PAIRS = 20_000_000


class HalfSpace(WaterFill):
    """Pressures on the taxels at the depth of the layer, from what presses the surface. Built once for a skin.

    Distances are straight lines between points of one link that face alike: a seam or a gap between two patches is no
    border, the far side of a thin link is none of it.

    Force is kept: what a point bears is felt whole, to rounding. A true half-space would carry up to half of it off
    beside a border, where a cover has no material to carry it; and squares stand in for the points' cells, whose sums
    are 6 % off where the points lie 1.7 depths apart, 1 % at one depth. Both are made good by the same factor.

    Lost: the free sides of the cover and the rigid shell below it (its stress is higher in the middle than a
    half-space's once the depth is a good part of the thickness), the curvature of the link, shear.

    Args:
        skin: The skin.
        layer: Its foundation and the depth of its taxels.
        field: What a taxel feels of the stress about it; its whole cell by default.
        share: Of a force, what may pass beyond the receptive fields; it is felt within them instead.

    Raises:
        SimulationError: Under so deep a cover so fine a skin would need receptive fields of over 20 million points.

    Cost: to build, 0.3 s for 10,000 quadrature points at a tenth of that many taxels; then a few times water-fill.
    """

    def __init__(
        self, skin: Skin, *, layer: Layer = _LAYER, field: ReceptiveField | None = None, share: float = SHARE
    ) -> None:
        below = buried(skin, layer.depth, field=field, share=share)
        super().__init__(skin, stiffness=layer.foundation, field=below)


def buried(skin: Skin, depth: float, *, field: ReceptiveField | None = None, share: float = SHARE) -> ReceptiveField:
    """What taxels feel of forces on the surface ``depth`` [m] above them; see ``HalfSpace``."""
    points, radius = skin_points(skin), reach(depth, share)
    fine = field is None and np.sqrt(np.median(skin.areas)) <= depth
    targets = _cells(skin) if fine else _Targets(points.positions, points.normals, points.areas, 0.0)
    felt = diags(1.0 / skin.areas).tocsr() if fine else _sparse(field or whole_cells(skin), len(skin))
    wearer = np.array([patch.link for patch in skin.patches])
    sources, places = wearer[skin.patch_of[points.taxel]], wearer[skin.patch_of] if fine else None
    blocks = [coo_matrix((0, len(skin)))]
    order = []
    for link in dict.fromkeys(wearer.tolist()):
        here = np.flatnonzero(sources == link)
        there = np.flatnonzero((sources if places is None else places) == link)
        for block, part in _spread(points, here, targets, there, depth, radius):
            order.append(block)
            blocks.append(part @ felt)
    entries = vstack(blocks).tocoo()
    rows = np.concatenate([np.zeros(0, np.int64), *order])[entries.row]
    return as_table(len(points.areas), rows, entries.col.astype(np.int64), entries.data)
