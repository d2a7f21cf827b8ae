"""How much of the body each pixel of a tactile image stands for, so that the image keeps the force."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import cg

from app.arrays import FloatArray, IntArray
from app.maps.tactile_map import TactileMap

_PRECISION = 1e-15
_ROUNDS = 400


def behind(map_: TactileMap, patch: IntArray, face: IntArray, resolution: float) -> FloatArray:
    """(k,) area on the body behind pixels of side ``resolution`` [m] whose centres lie in faces (k,); 0 for face -1.

    Exactly ``resolution² / (s1 s2)``: over a face the map stretches areas by the ratio of the face's two areas.
    """
    areas = np.zeros(len(face))
    for number, (worn, chart, uv) in enumerate(zip(map_.skin.patches, map_.charts, map_.uv, strict=True)):
        first, second = (uv[chart.faces[:, k]] - uv[chart.faces[:, 0]] for k in (1, 2))
        on_map = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        here = np.flatnonzero((patch == number) & (face >= 0))
        areas[here] = worn.surface.face_areas[face[here]] / on_map[face[here]]
    return resolution**2 * areas


def force_areas(weights: csr_matrix, areas: FloatArray, taxel_areas: FloatArray) -> FloatArray:
    """(k,) [m²] areas of the pixels near ``areas``, with which the image has exactly the force of the taxels.

    Pixels cut the skin into squares, taxels into cells, and interpolation spreads each reading over its neighbours; so
    the areas behind the pixels, times the image, miss the force by some per cent. The image being W y, its force is
    right for every y if and only if Wᵀ A = a. Of all such A we take the one nearest to the geometric areas D (least
    sum of (A - D)² / D), which is A = D (W f): each pixel's area times a factor, interpolated like the pressure itself
    from one factor f for each taxel, found from (Wᵀ D W) f = a. It is 1 where cells, squares and map agree.

    Args:
        weights: (k, n) W, taken at its own precision.
        areas: (k,) D [m²]; 0 for pixels that are not on the skin, and they stay so.
        taxel_areas: (n,) a [m²].

    From about six pixels a taxel on, 98 % of the factors lie between 0.3 and 2.3, those far from 1 at the rim; with two
    or fewer they swing by tens: the whole force is still right, but not that of a part of the image. A taxel that no
    pixel shows has no part in the image and none in its force; where there are fewer pixels than taxels the areas are
    the nearest in the sense of least squares.
    """
    exact = weights.astype(np.float64)
    mass = (exact.T @ diags(areas) @ exact).tocsr()
    shown = mass.diagonal() > 0
    if not shown.any():
        return np.zeros(len(areas))
    mass, wanted = mass[shown][:, shown], taxel_areas[shown]
    scale = 1 / np.sqrt(mass.diagonal())
    factors = scale * cg(diags(scale) @ mass @ diags(scale), scale * wanted, rtol=_PRECISION, maxiter=_ROUNDS)[0]
    return np.asarray(areas * (exact[:, shown] @ factors))
