"""The half-space model: what taxels feel that lie under a cover, where forces have spread out.

The traction at the surface is water-fill's. Below it, a force spreads as in an elastic half-space (Love's stress under
a small square, whatever the material), so a taxel feels what presses beside it: a cover is a blur. The blur is a
receptive field built once, so this costs a reading little more than water-fill.
"""

from __future__ import annotations

from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE, subsurface_field
from tactile_maps.tactile.mechanics.receptive_field import ReceptiveField
from tactile_maps.tactile.models.water_fill import WaterFillModel

_LAYER = ElasticLayer()


class HalfSpaceModel(WaterFillModel):
    """Pressures on the taxels at the depth of the layer, from what presses the surface. Built once for a skin.

    Distances are straight lines between points of one link that face alike: a seam or a gap between two patches is no
    border, the far side of a thin link is none of it.

    Force is kept: what a point bears is felt whole, to rounding. A true half-space would carry up to half of it off
    beside a border, where a cover has no material to carry it; and squares stand in for the points' cells, whose sums
    are 6 % off where the points lie 1.7 depths apart, 1 % at one depth. Both are made good by the same factor. Measured
    against a dense sum, 1,000 taxels on a tube are off by 2 to 4 % of the force, where water-fill is by 9 to 31 %.

    Lost: the free sides of the cover and the rigid shell below it (its stress is higher in the middle than a
    half-space's once the depth is a good part of the thickness), the curvature of the link, shear.

    Args:
        skin: The skin.
        layer: Its foundation and the depth of its taxels.
        field: What a taxel feels of the stress about it; its whole cell by default.
        share: Of a force, what may pass beyond the receptive fields; it is felt within them instead.

    Raises:
        SimulationError: The cover is too deep for so fine a skin.

    Cost: to build, see ``subsurface_field``; a reading then costs 10 ns more than water-fill's for each taxel that
        feels a cluster.
    """

    def __init__(
        self,
        skin: Skin,
        *,
        layer: ElasticLayer = _LAYER,
        field: ReceptiveField | None = None,
        share: float = TAIL_SHARE,
    ) -> None:
        below = subsurface_field(skin, layer.depth, field=field, share=share)
        super().__init__(skin, stiffness=layer.foundation, field=below)
