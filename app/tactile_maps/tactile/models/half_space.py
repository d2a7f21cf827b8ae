"""Half-space model: pressures on taxels below a cover, which spreads forces.

The traction at the surface is that of water-fill. Below it, a force spreads as in an elastic half-space (Love's stress
under a small square, independent of the material), so that a taxel measures forces next to it: the cover is a blur. The
blur is a receptive field that is built once, so that a reading costs little more than water-fill.
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

    Distances are straight lines between points of one link that face in similar directions: a seam or a gap between two
    patches is not a border, and the far side of a thin link does not count.

    Force is conserved to rounding. A true half-space would carry up to half of it outside a border, where a cover has
    no material, and squares replace the cells of points, whose sums have errors of 6 % for points 1.7 depths apart and
    1 % at one depth. One factor corrects both. Compared with a dense sum, 1,000 taxels on a tube have errors of 2 to 4
    % of the force; water-fill has 9 to 31 %.

    Not modelled: the free sides of the cover and the rigid shell below it (its stress is higher in the middle than that
    of a half-space if the depth is a considerable part of the thickness), the curvature of the link, shear.

    Args:
        skin: The skin.
        layer: The skin's cover: its foundation and the depth of the taxels.
        field: Receptive field of a taxel at its own depth; its whole cell by default.
        share: Share of a force that may pass outside the receptive fields; it is added within them.

    Raises:
        SimulationError: The cover is too deep for so fine a skin.

    Cost: that of ``subsurface_field`` to build; a reading costs 10 ns more than water-fill for each taxel and loaded
        cluster in its field.
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
        super().__init__(skin, layer=layer, field=below)
