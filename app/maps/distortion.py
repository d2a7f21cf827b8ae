"""What laying flat does to each face: how it changes angles, areas and lengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from app.arrays import BoolArray, FloatArray, readonly
from app.geometry.closest import ClosestPoint
from app.maps.bijective import flipped
from app.maps.rest import rest_triangles
from app.maps.symmetric_dirichlet import rotation_svd
from app.maps.tactile_map import TactileMap
from app.skin.skin import Skin


@dataclass(frozen=True)
class Spread:
    """A measure over the skin's area."""

    median: float
    p95: float
    max: float


@dataclass(frozen=True, eq=False)
class Distortion:
    """Of every face of a map, numbered through the patches.

    Attributes:
        stretch: (t, 2) singular values s1 >= s2 >= 0 of the map's differential.
        flipped: (t,) faces without positive area on the map.
        areas: (t,) of the faces on the body [m²].
    """

    stretch: FloatArray
    flipped: BoolArray
    areas: FloatArray

    def __post_init__(self) -> None:
        for name, kind in (("stretch", float), ("flipped", bool), ("areas", float)):
            object.__setattr__(self, name, readonly(getattr(self, name), kind))

    @property
    def angle(self) -> FloatArray:
        """(t,) s1 / s2: how much longer one direction is shown than the one across; 1 keeps angles, inf is a line."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.nan_to_num(self.stretch[:, 0] / self.stretch[:, 1], nan=np.inf, posinf=np.inf)

    @property
    def area(self) -> FloatArray:
        """(t,) s1 s2: how many times larger the area is shown, whichever way round the face lies."""
        return self.stretch.prod(axis=1)

    @property
    def isometry(self) -> FloatArray:
        """(t,) max(s1, 1 / s2): the worst change of any length; 1 keeps lengths."""
        with np.errstate(divide="ignore"):
            return np.maximum(self.stretch[:, 0], 1 / self.stretch[:, 1])

    @property
    def energy(self) -> FloatArray:
        """(t,) symmetric Dirichlet s1² + s2² + 1/s1² + 1/s2² (Smith and Schaefer 2015); 4 is an isometry."""
        with np.errstate(divide="ignore"):
            return (self.stretch**2 + self.stretch**-2.0).sum(axis=1)

    @property
    def mean_energy(self) -> float:
        """By area; what the flattening makes small."""
        return float(np.average(self.energy, weights=self.areas)) if len(self.areas) else float("nan")

    def spread(self, values: FloatArray) -> Spread:
        """Median, 95th percentile and maximum of face values (t,), by the area they hold on."""
        if not len(values):
            return Spread(*3 * (float("nan"),))
        order = np.argsort(values)
        share = (np.cumsum(self.areas[order]) - 0.5 * self.areas[order]) / self.areas.sum()
        # Picked, not blended: beside an infinite value a blend would be nan.
        median, p95 = values[order[np.minimum(np.searchsorted(share, [0.5, 0.95]), len(order) - 1)]]
        return Spread(float(median), float(p95), float(values.max()))


def distortion(map_: TactileMap) -> Distortion:
    """Compare every face on the map with itself on the body. Cost: 15 ms for 20,000 faces."""
    stretch, turned, areas = [], [], []
    for patch, chart, placement in zip(map_.skin.patches, map_.charts, map_.layout.placements, strict=True):
        rest = rest_triangles(patch.surface.vertices[chart.vertex_of], chart.faces)
        corner = placement.scale * chart.plane[chart.faces]
        first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        along = first / rest.base[:, None]
        across = (second - rest.along[:, None] * along) / rest.across[:, None]
        stretch.append(np.abs(rotation_svd(np.stack([along, across], axis=2))[1]))
        turned.append(flipped(chart.plane, chart.faces))
        areas.append(rest.areas)
    return Distortion(np.concatenate(stretch), np.concatenate(turned), np.concatenate(areas))


def taxel_cells(skin: Skin) -> csr_matrix:
    """Sparse (taxels, faces): the share of each taxel's area that lies in each face; rows sum to one.

    ``taxel_cells(skin) @ distortion(map_).angle`` is each taxel's mean angle distortion over its cell. Depends on the
    skin only. Cost: 20 ms for 1000 taxels on 20,000 faces.
    """
    rows, columns, values, faces = [], [], [], 0
    for patch, start in zip(skin.patches, skin.first[:-1], strict=True):
        felt = patch.taxels.quadrature
        rows.append(felt.taxel + start)
        columns.append(ClosestPoint(patch.surface).query(felt.positions)[0] + faces)
        values.append(felt.areas / patch.taxels.areas[felt.taxel])
        faces += len(patch.surface.faces)
    shares = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return coo_matrix(shares, shape=(len(skin), faces)).tocsr()
