"""What the tactile image keeps of the map: where a touch is, and how strong it is."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.skin.skin import Skin


def round_trip_mm(map_: TactileMap, image: TactileImage) -> FloatArray:
    """(n,) how far body -> map -> centre of the pixel -> body leads from each taxel [mm].

    inf where the pixel's centre is off the taxel's patch. Cost: 2 ms for 1000 taxels.
    """
    low = image.extent[0]
    steps = np.floor((map_.taxel_points - low) / image.resolution)
    centres = low + (steps + 0.5) * image.resolution
    patch, face, weights = map_.to_body_many(centres)
    back = surface_positions(map_.skin, patch, face, weights)
    back[patch != map_.skin.patch_of] = np.inf
    taxels = [patch.taxels.positions for patch in map_.skin.patches]
    return 1e3 * np.linalg.norm(back - np.concatenate(taxels), axis=1)


def force_error(image: TactileImage) -> FloatArray:
    """(n,) relative error of the force that the image shows when one taxel alone is touched; -1 where it shows none.

    Shown force: sum over the pixels of pressure times area; true force: pressure times the taxel's area. The largest
    of them bounds the error of any touch. Cost: 3 ms beside the pixels' areas.
    """
    shown = image.weights.T.astype(np.float64) @ image.pixel_areas.ravel()
    return np.asarray(shown) / image.taxel_areas - 1


def surface_positions(skin: Skin, patch: IntArray, face: IntArray, weights: FloatArray) -> FloatArray:
    """(k, 3) [m], link frames, of places given by patch (k,), face (k,) and weights (k, 3); nan for patch -1."""
    result = np.full((len(patch), 3), np.nan)
    for number, worn in enumerate(skin.patches):
        here = patch == number
        result[here] = worn.surface.points(face[here], weights[here])
    return result
