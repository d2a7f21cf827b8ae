"""The centre of pressure as an image has it: by pixels, as in the paper, in place of straight from the taxels.

An image is a linear function of the pressures, and so are its pixels' sum and first moments. The centre over the pixels
of some taxels is therefore that of as many points: each taxel's weight is what it adds to all pixels, its place the
mean of the pixels that it adds to. With small pixels that differs from the taxels themselves by how the interpolation
spreads a reading, with large ones also by where the grid happens to lie.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from tactile_maps.core.arrays import FloatArray, readonly
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap

BackProjection: TypeAlias = Literal["triangle", "three-taxels"]
"""From a centre on the map to the body: by the triangle that contains it, or as the mean of the three nearest taxels,
weighted by the inverse of their distances."""
BACK_PROJECTIONS: tuple[BackProjection, ...] = get_args(BackProjection)
PIXELS = (1e-4, 0.05)
"""Smallest and largest selectable pixel [m]."""


@dataclass(frozen=True)
class CentreSettings:
    """Where a contact's centre is taken from, and how it comes back to the body; checked by ``ReadingSettings``.

    Attributes:
        pixel: Of the image whose pixels it is the centre of [m on the map]; None for none: straight from the taxels.
        interpolation: Of that image.
        back_projection: From the map to the body.
    """

    pixel: float | None = None
    interpolation: str = "barycentric"
    back_projection: BackProjection = "triangle"


@dataclass(frozen=True, eq=False)
class TaxelMoments:
    """What a taxel is in a sum over pixels.

    Attributes:
        weights: (taxels,) what it adds to all pixels together, for each unit of its reading; or its area.
        points: (taxels, 2) where that is on the map [m].
    """

    weights: FloatArray
    points: FloatArray


def taxel_moments(map_: TactileMap, settings: CentreSettings) -> TaxelMoments:
    """By its area where it lies, without pixels; else by those it adds to.

    A taxel that no pixel shows weighs nothing, and lies where it does.

    Raises:
        MapError: The image would have too many pixels.

    Cost: nothing without pixels; else that of a ``TactileImage``, 0.1 s for 512 pixels across.
    """
    if settings.pixel is None:
        return TaxelMoments(map_.skin.areas, map_.taxel_points)
    image = TactileImage(map_, resolution=settings.pixel, interpolation=settings.interpolation)
    columns = image.weights.astype(np.float64).tocsc()
    weights = np.asarray(columns.sum(axis=0)).ravel()
    moments = columns.T @ image.centres()
    shown = weights > 0
    points = map_.taxel_points.copy()
    points[shown] = moments[shown] / weights[shown, None]
    return TaxelMoments(readonly(np.where(shown, weights, 0.0)), readonly(points))
