"""One interpolation applied to a whole map, patch by patch, as one sparse matrix."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.sparse import csr_matrix

from app.arrays import FloatArray, IntArray
from app.errors import MapError
from app.maps.interpolation.barycentric import barycentric
from app.maps.interpolation.natural_neighbour import natural_neighbour
from app.maps.interpolation.nearest import nearest
from app.maps.interpolation.thin_plate import thin_plate
from app.maps.interpolation.triangles import TaxelTriangles, stacked
from app.maps.tactile_map import TactileMap

Interpolation = Callable[[TaxelTriangles, FloatArray], csr_matrix]

INTERPOLATIONS: Mapping[str, Interpolation] = {
    "barycentric": barycentric,
    "nearest": nearest,
    "natural-neighbour": natural_neighbour,
    "thin-plate": thin_plate,
}


def interpolation_weights(
    map_: TactileMap, patch: IntArray, points: FloatArray, *, interpolation: str = "barycentric"
) -> csr_matrix:
    """Sparse (k, taxels): each row sums to one for a point on a patch, and is empty for patch -1.

    Between the taxels of the point's own patch, as the method says. Outside their triangles (the patch's rim, and gaps
    too wide to bridge) the value at the nearest place on their border: continuous, never taken from another patch and
    never beyond the values of the taxels there.

    Args:
        map_: The map.
        patch: (k,) patch of each point, -1 for none.
        points: (k, 2) [m].
        interpolation: A name in ``INTERPOLATIONS``.

    Raises:
        MapError: There is no such interpolation.

    Cost: see each method; using the matrix costs half a nanosecond for each of its entries.
    """
    if interpolation not in INTERPOLATIONS:
        choice = f"Choose {', '.join(INTERPOLATIONS)}"
        raise MapError("there is no such interpolation", place="interpolation", value=interpolation, remedy=choice)
    # The last row, an empty one, is that of the points on no patch.
    blocks, row_of, rows = [], np.full(len(points), -1, dtype=np.int64), 0
    for number, (first, last) in enumerate(zip(map_.skin.first[:-1], map_.skin.first[1:], strict=True)):
        asked = np.flatnonzero(patch == number)
        if len(asked) and last > first:
            found = INTERPOLATIONS[interpolation](TaxelTriangles(map_.taxel_points[first:last]), points[asked])
            entries = found.data, found.indices + first, found.indptr
            blocks.append(csr_matrix(entries, shape=(len(asked), len(map_.skin))))
            row_of[asked] = rows + np.arange(len(asked))
            rows += len(asked)
    matrix = stacked([*blocks, csr_matrix((1, len(map_.skin)))])[row_of]
    matrix.eliminate_zeros()
    return matrix
