"""What taxels feel that lie under a cover: a receptive field that spreads each force as an elastic half-space does.

Points that are close together compared to the depth are felt alike, so they are taken in clumps: the work depends on
how much skin there is in depths, however fine its taxels are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, vstack
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray, readonly
from app.errors import SimulationError
from app.skin.skin import Skin
from app.skin.taxels import Quadrature
from app.touch.love import reach, square_stress
from app.touch.points import skin_points
from app.touch.receptive_field import ReceptiveField, as_table, whole_cells

SHARE = 0.01
"""Of a force, what passes so far aside that its whereabouts are not followed."""
_CLUMP = 0.3
"""Points of a taxel are taken together within a box of so many depths: felt up to half of that from where they are."""
_FACING = 0.2
_BLOCK = 2_000_000
_MOST_PAIRS = 60_000_000


@dataclass(frozen=True, eq=False)
class Buried(ReceptiveField):
    """The table, by clump of quadrature points.

    Attributes:
        clump: (q,) which clump each quadrature point belongs to.
    """

    clump: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "clump", readonly(self.clump, np.int64))

    def add(self, pressures: FloatArray, points: IntArray, forces: FloatArray) -> None:
        """As of every receptive field. Cost: 10 ns for each taxel that feels a clump under load."""
        summed = np.bincount(self.clump.take(points), forces)
        loaded = np.flatnonzero(summed)
        felt = self.weights.take(loaded, axis=0)
        felt *= summed.take(loaded)[:, None]
        pressures += np.bincount(self.taxels.take(loaded, axis=0).ravel(), felt.ravel(), len(pressures))


class _Clumps(NamedTuple):
    """Middles (c, 3) [m], mean normals (c, 3), areas (c,) and links (c,) of clumps."""

    positions: FloatArray
    normals: FloatArray
    areas: FloatArray
    links: IntArray


def buried(skin: Skin, depth: float, *, field: ReceptiveField | None = None, share: float = SHARE) -> Buried:
    """What taxels feel of forces on the surface ``depth`` [m] above them.

    Each row is made to keep its force: what a clump bears is felt whole, see ``models.half_space``.

    Args:
        skin: The skin.
        depth: Of all taxels below it [m], > 0.
        field: What a taxel feels of the stress about it; its whole cell by default.
        share: Of a force, what may pass beyond the receptive fields; it is felt within them instead.

    Raises:
        SimulationError: More than 60 million pairs of clumps are within reach: it would take gigabytes.

    Cost: 0.2 µs a pair of clumps within reach: 0.2 s for a flat 100 cm² in 1,000 taxels at 2 mm, 1 s for a tube of
    450 cm², 8 s and 150 MB when that has 10,000 taxels.
    """
    points = skin_points(skin)
    clump = _clumped(points, _CLUMP * depth)
    clumps, share_of = _gathered(skin, points, clump)
    surface = field or whole_cells(skin)
    count, width = surface.taxels.shape
    rows = np.repeat(np.arange(count), width)
    felt = csr_matrix((surface.weights.ravel(), (rows, surface.taxels.ravel())), shape=(count, len(skin)))
    felt = share_of @ felt
    below = vstack([part @ felt for part in _spread(clumps, depth, reach(depth, share))]).tocoo()
    table = as_table(len(clumps.areas), below.row.astype(np.int64), below.col.astype(np.int64), below.data)
    return Buried(table.taxels, table.weights, clump)


def _clumped(points: Quadrature, size: float) -> IntArray:
    """(q,) number of each point's clump: a taxel's points, halved along the longest axis until a box of ``size`` holds
    them.
    """
    clump = np.unique(points.taxel, return_inverse=True)[1]
    while True:
        order = np.argsort(clump, kind="stable")
        starts = np.flatnonzero(np.diff(clump[order], prepend=-1))
        low = np.minimum.reduceat(points.positions[order], starts)
        high = np.maximum.reduceat(points.positions[order], starts)
        axis = (high - low).argmax(axis=1)
        wide = (high - low).max(axis=1) > size
        if not wide.any():
            return clump.astype(np.int64)
        middle = 0.5 * np.take_along_axis(low + high, axis[:, None], axis=1)[:, 0]
        along = np.take_along_axis(points.positions, axis[clump][:, None], axis=1)[:, 0]
        clump = np.unique(2 * clump + (wide[clump] & (along > middle[clump])), return_inverse=True)[1]


def _gathered(skin: Skin, points: Quadrature, clump: IntArray) -> tuple[_Clumps, csr_matrix]:
    """The clumps, and (c, q) the share of each point in its clump's area."""
    number = np.arange(len(clump))
    areas = np.bincount(clump, points.areas).astype(np.float64)
    share_of = csr_matrix((points.areas / areas[clump], (clump, number)), shape=(len(areas), len(clump)))
    normals = share_of @ points.normals
    names = {patch.link: number for number, patch in enumerate(skin.patches)}
    wearer = np.array([names[patch.link] for patch in skin.patches])
    links = np.empty(len(areas), dtype=np.int64)
    links[clump] = wearer[skin.patch_of[points.taxel]]
    return _Clumps(share_of @ points.positions, normals, areas, links), share_of


def _spread(clumps: _Clumps, depth: float, radius: float) -> Iterator[csr_matrix]:
    """Rows (c, c), some at a time: which share of the force on a clump passes below each; a row sums to one."""
    # Links lie apart along a fourth axis, so that none feels through another.
    places = np.column_stack([clumps.positions, 4 * radius * clumps.links])
    tree = cKDTree(places)
    count = len(places)
    pairs = int(tree.count_neighbors(tree, radius))
    if pairs > _MOST_PAIRS:
        raise SimulationError(
            "the cover is too deep for so fine a skin",
            place="layer.depth",
            value=f"{1e3 * depth:g} mm, {pairs:,} pairs of places",
            remedy="Choose a shallower cover, fewer taxels or another contact model",
        )
    step = max(_BLOCK * count // max(pairs, 1), 1)
    for start in range(0, count, step):
        here = np.arange(start, min(start + step, count))
        near = cKDTree(places[here]).sparse_distance_matrix(tree, radius, output_type="ndarray")
        source, target = here[near["i"]], near["j"]
        alike = np.einsum("ij,ij->i", clumps.normals[source], clumps.normals[target]) > _FACING
        source, target, away = source[alike], target[alike], near["v"][alike]
        passing = clumps.areas[target] * square_stress(away, depth, side=np.sqrt(clumps.areas)[source])
        total = np.bincount(source - start, passing, len(here))
        yield csr_matrix((passing / total[source - start], (source - start, target)), shape=(len(here), count))
