"""How good a tactile map is, in numbers a user can compare."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from app.arrays import FloatArray
from app.errors import Finding
from app.maps.bijective import crossings, flipped
from app.maps.symmetric_dirichlet import SymmetricDirichlet, rotation_svd
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.maps.topography import topography


@dataclass(frozen=True)
class Spread:
    """A ratio that is at best 1, over the skin's area."""

    median: float
    p95: float
    max: float


@dataclass(frozen=True)
class MapQuality:
    """What a map keeps and what it loses.

    Attributes:
        patches: Number of patches.
        taxels: Number of taxels.
        faces: Number of triangles.
        flips: Triangles turned over on the map; 0 in a valid map.
        bijective: No flips, no patch overlaps itself or another.
        symmetric_dirichlet: Mean over the area of s1² + s2² + 1/s1² + 1/s2²; 4 is an isometry.
        angle: s1 / s2: how much longer one direction is shown than the one across.
        area: The larger of s1 s2 and its inverse: how much larger or smaller an area is shown.
        edge_error: Rms relative error of the lengths between neighbouring taxels at the best scale, without torn ones.
        torn: Share of neighbours that a seam takes apart.
        stress: Kruskal's stress-1 against exact distances over the uncut body, within patches; nan if unknown.
        trustworthiness: 1 if the six nearest taxels on the map are so on the body; nan with under 18 taxels a patch.
        continuity: 1 if the six nearest taxels on the body are so on the map.
        round_trip_mm: 95th percentile over the taxels of body -> map -> pixel's centre -> body, at 512 pixels.
        seam_mm: Length of all seams on the body.
        seconds: Spent on flattening.
        findings: What was repaired, added or could not be measured.
    """

    patches: int
    taxels: int
    faces: int
    flips: int
    bijective: bool
    symmetric_dirichlet: float
    angle: Spread
    area: Spread
    edge_error: float
    torn: float
    stress: float
    trustworthiness: float
    continuity: float
    round_trip_mm: float
    seam_mm: float
    seconds: float
    findings: tuple[Finding, ...]

    def to_json(self) -> dict[str, Any]:
        """The same as plain values; what could not be measured is null, since JSON knows no nan."""
        values = asdict(self)
        plain = {key: _plain(value) for key, value in values.items() if key != "findings"}
        plain["findings"] = [asdict(finding) for finding in self.findings]
        return plain


def measure(map_: TactileMap, *, sources: int = 12, seed: int = 0) -> MapQuality:
    """Measure ``map_``.

    Args:
        map_: At least one patch.
        sources: Taxels from which exact distances over the body are taken; more make ``stress`` surer.
        seed: Chooses them.

    Cost: 3 s for 1000 taxels on 27,000 faces, nearly all for exact distances.
    """
    flips = sum(int(flipped(chart.plane, chart.faces).sum()) for chart in map_.charts)
    shape = topography(map_, sources=sources, seed=seed)
    energy, angle, area = _distortion(map_)
    return MapQuality(
        patches=len(map_.skin.patches),
        taxels=len(map_.skin),
        faces=sum(len(chart.faces) for chart in map_.charts),
        flips=flips,
        bijective=flips == 0 and not crossings(*map_.outlines) and not _nested(map_),
        symmetric_dirichlet=energy,
        angle=angle,
        area=area,
        edge_error=shape.edge_error,
        torn=shape.torn,
        stress=shape.stress,
        trustworthiness=shape.trustworthiness,
        continuity=shape.continuity,
        round_trip_mm=_round_trip_mm(map_),
        seam_mm=_seam_mm(map_),
        seconds=sum(chart.seconds[-1] for chart in map_.charts if chart.seconds),
        findings=(*map_.skin.findings, *(f for chart in map_.charts for f in chart.findings), *shape.findings),
    )


def _distortion(map_: TactileMap) -> tuple[float, Spread, Spread]:
    """Mean symmetric Dirichlet energy, and the spreads of angle and area."""
    stretch, areas = _stretch(map_)
    with np.errstate(divide="ignore"):
        energy = (stretch**2 + stretch**-2.0).sum(axis=1)
        angle, area = stretch[:, 0] / stretch[:, 1], stretch.prod(axis=1)
        area = np.maximum(area, 1 / area)
    return float(np.average(energy, weights=areas)), _spread(angle, areas), _spread(area, areas)


def _stretch(map_: TactileMap) -> tuple[FloatArray, FloatArray]:
    """Singular values (t, 2), larger first, and areas (t,) of all faces."""
    values, areas = [], []
    for patch, chart in zip(map_.skin.patches, map_.charts, strict=True):
        problem = SymmetricDirichlet(patch.surface.vertices[chart.vertex_of], chart.faces)
        values.append(np.abs(rotation_svd(problem.jacobians(chart.plane))[1]))
        areas.append(problem.areas)
    return np.concatenate(values), np.concatenate(areas)


def _nested(map_: TactileMap) -> bool:
    """Whether a patch lies inside another: their borders need not cross for that."""
    insides = np.stack([uv[chart.faces[0]].mean(axis=0) for chart, uv in zip(map_.charts, map_.uv, strict=True)])
    for number, outline in enumerate(map_.outlines):
        others = np.arange(len(insides)) != number
        if (_windings(outline, insides[others]) != 0).any():
            return True
    return False


def _windings(loop: FloatArray, points: FloatArray) -> FloatArray:
    """How often a closed polygon runs around each point."""
    arms = loop[None] - points[:, None]
    after = np.roll(arms, -1, axis=1)
    turned = np.arctan2(arms[..., 0] * after[..., 1] - arms[..., 1] * after[..., 0], (arms * after).sum(axis=-1))
    return np.rint(turned.sum(axis=1) / (2 * np.pi))


def _round_trip_mm(map_: TactileMap) -> float:
    image, skin = TactileImage(map_), map_.skin
    errors = []
    for taxel, point in enumerate(map_.taxel_points):
        at = image.back_project(*image.pixel(point))
        if at is not None and at.patch == skin.patch_of[taxel]:
            errors.append(np.linalg.norm(skin.position(at) - skin.position(skin.taxel_point(taxel))))
    return 1e3 * float(np.percentile(errors, 95)) if errors else float("nan")


def _seam_mm(map_: TactileMap) -> float:
    pairs = zip(map_.skin.patches, map_.charts, strict=True)
    ends = [patch.surface.vertices[chart.seams] for patch, chart in pairs]
    return 1e3 * float(sum(np.linalg.norm(end[:, 0] - end[:, 1], axis=1).sum() for end in ends))


def _spread(values: FloatArray, areas: FloatArray) -> Spread:
    order = np.argsort(values)
    share = (np.cumsum(areas[order]) - 0.5 * areas[order]) / areas.sum()
    median, p95 = np.interp([0.5, 0.95], share, values[order])
    return Spread(float(median), float(p95), float(values.max()))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value
