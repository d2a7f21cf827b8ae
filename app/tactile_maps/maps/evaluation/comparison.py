"""Comparison of two maps of the same taxels, such as an automatic and a hand-drawn one.

A drawing is expressed in the taxels of a skin (``drawn_layout``), so that it can be compared with the skin's own map.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.evaluation.topography import BodyDistances, Topography, json_value, measure_topography
from tactile_maps.maps.model.layout import fit_placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_maps.skin.model.taxel_set import TaxelSet

Better = Literal["first", "second", "neither"]

IDEALS: dict[str, float] = {
    "flips": 0.0,
    "overlaps": 0.0,
    "coverage": 1.0,
    "symmetric_dirichlet": 4.0,
    "angle": 1.0,
    "area": 1.0,
    "isometry": 1.0,
    "edge_error": 0.0,
    "torn": 0.0,
    "stress": 0.0,
    "spearman": 1.0,
    "trustworthiness": 1.0,
    "continuity": 1.0,
    "round_trip_mm": 0.0,
    "force_error": 0.0,
    "seam_mm": 0.0,
}
"""Ideal value of each measure; for distributions the 95th percentile is compared."""
_ALIKE = 1e-9


@dataclass(frozen=True, eq=False)
class TaxelLayout(ArrayFields, points=2):
    """A map given only by the positions of its taxels, such as a hand-drawn one.

    Attributes:
        points: (n, 2) [m], in the order of the taxels.
        numbers: (n,) taxel number of each in the other map; by default the same order.
    """

    points: FloatArray
    numbers: IntArray | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.isfinite(self.points).all():
            raise MapError("a taxel position of the layout is not finite", value=int((~np.isfinite(self.points)).sum()))


@dataclass(frozen=True)
class ComparedMeasure:
    """A measure of both maps; None if a map does not have it or it is unknown.

    Attributes:
        name: A key of ``MapQuality``.
        first: Value of the first map.
        second: Value of the second map.
        better: The map closer to the ideal.
    """

    name: str
    first: float | None
    second: float | None
    better: Better


@dataclass(frozen=True)
class Comparison:
    """Measures of two maps.

    Attributes:
        first: Measures of the first map.
        second: Measures of the second map.
        measures: The measures side by side.
        procrustes_mm: Rms distance between the maps' taxels after the best rigid motion, mirroring and scale of each
            patch [mm of the first map]. It measures similarity, not quality.
    """

    first: Topography
    second: Topography
    measures: tuple[ComparedMeasure, ...]
    procrustes_mm: float

    def to_json(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {key: json_value(value) for key, value in asdict(self).items()}


def compare_maps(
    first: TactileMap | TaxelLayout,
    second: TactileMap | TaxelLayout,
    *,
    distances: BodyDistances | None = None,
) -> Comparison:
    """Measure two maps of the same taxels.

    Args:
        first: A map, or only the points of its taxels.
        second: The same; taxels correspond by number.
        distances: Body distances; by default of the skin of the first argument that is a map.

    Raises:
        MapError: Different taxels, or two layouts without distances.

    Example:
        >>> conformal = tm.build_map(skin, method="lscm")
        >>> comparison = tm.compare_maps(tactile_map, conformal)
        >>> {measure.name: measure.better for measure in comparison.measures}["edge_error"]
        'first'
    """
    skins = [map_.skin for map_ in (first, second) if isinstance(map_, TactileMap)]
    if distances is None and not skins:
        raise MapError("two layouts contain no distances on the body", remedy="Give the distances between the taxels")
    body = BodyDistances(skins[0]) if distances is None else distances
    a = _points(first, int(body.first[-1]))
    b = _points(second, int(body.first[-1]))
    one = _measured(first, a, body)
    other = _measured(second, b, body)
    return Comparison(one, other, _side_by_side(one, other), 1e3 * procrustes(a, b, body.first))


def procrustes(first: FloatArray, second: FloatArray, starts: IntArray) -> float:
    """Return the rms distance of points (n, 2) after the best similarity of each part, maybe mirrored (Gower 1975).

    Args:
        first: (n, 2).
        second: (n, 2).
        starts: (parts + 1,) index of each part's first point, and n.
    """
    squares = 0.0
    for a, b in pairwise(starts):
        if b > a:
            fit = fit_placement(second[a:b], first[a:b])
            squares += ((first[a:b] - fit.apply(second[a:b])) ** 2).sum()
    return float(np.sqrt(squares / max(len(first), 1)))


def _points(map_: TactileMap | TaxelLayout, count: int) -> FloatArray:
    if isinstance(map_, TactileMap) or map_.numbers is None:
        points = map_.taxel_points if isinstance(map_, TactileMap) else map_.points
        if len(points) != count:
            raise MapError("the maps do not have the same taxels", value=f"{len(points)} and {count}")
        return points
    if sorted(map_.numbers.tolist()) != list(range(count)):
        raise MapError(
            "the layout does not name each taxel once",
            value=f"{len(np.unique(map_.numbers))} different numbers for {count} taxels",
            remedy="Compare only the taxels that both maps have",
        )
    points = np.empty((count, 2))
    points[map_.numbers] = map_.points
    return points


def _measured(map_: TactileMap | TaxelLayout, points: FloatArray, body: BodyDistances) -> Topography:
    if isinstance(map_, TactileMap):
        return measure(map_, distances=body)
    return measure_topography(points, body)


def _side_by_side(first: Topography, second: Topography) -> tuple[ComparedMeasure, ...]:
    rows = []
    for name, ideal in IDEALS.items():
        a = _value(first, name)
        b = _value(second, name)
        if a is not None or b is not None:
            rows.append(ComparedMeasure(name, a, b, _better(a, b, ideal)))
    return tuple(rows)


def _value(quality: Topography, name: str) -> float | None:
    value = getattr(quality, name, None)
    value = getattr(value, "p95", value)
    return None if value is None else float(value)


def _better(a: float | None, b: float | None, ideal: float) -> Better:
    """Return the map closer to the ideal; unknown or infinite values are not compared."""
    if a is None or b is None or not (math.isfinite(a) and math.isfinite(b)):
        return "neither"
    here = abs(a - ideal)
    there = abs(b - ideal)
    if abs(here - there) <= _ALIKE:
        return "neither"
    return "first" if here < there else "second"


FARTHEST_TAXEL = 0.02
"""Median distance [m] between taxels of a drawing and those of the skin above which the drawing is of another skin."""


def drawn_layout(taxels: TaxelSet, skin: Skin) -> TaxelLayout:
    """Return the map points of ``taxels``, each assigned to the taxel of ``skin`` closest on the body.

    Raises:
        MapError: The taxels have no map points, or most are on another body.
    """
    if taxels.points is None or not taxels.mapped.any():
        raise MapError(
            "the file has no map points to compare with", file=taxels.name, remedy="Give columns u and v, or a layout"
        )
    shown = taxels.select(taxels.mapped)
    away, nearest = cKDTree(skin.positions).query(shown.positions)
    if np.median(away) > FARTHEST_TAXEL:
        raise MapError(
            "the drawing is not of this skin",
            file=taxels.name,
            value=f"taxels {1e3 * np.median(away):.0f} mm (median) from those of the skin",
            remedy="Compare maps of the same taxels, in the same frame",
        )
    # Of several taxels assigned to one, the closest is used.
    order = np.argsort(away, kind="stable")
    _, first = np.unique(nearest[order], return_index=True)
    chosen = np.sort(order[first])
    assert shown.points is not None
    return TaxelLayout(shown.points[chosen], nearest[chosen])
