"""Quality report of a tactile map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding
from tactile_maps.flattening.bijectivity import crossings
from tactile_maps.maps.evaluation.distortion import DistortionSummary, distortion, nested_patches
from tactile_maps.maps.evaluation.topography import BodyDistances, Topography, measure_topography
from tactile_maps.maps.model.tactile_image import TactileImage, force_error, round_trip_mm
from tactile_maps.maps.model.tactile_map import TactileMap


@dataclass(frozen=True, kw_only=True)
class MapQuality(Topography):
    """Quality of a map: the topography of its taxels, and the measures below. None where a value is unknown.

    Attributes:
        patches: Number of patches.
        taxels: Number of taxels.
        coverage: Share of the requested surface that has taxels, 0 to 1.
        faces: Number of triangles.
        flips: Triangles flipped on the map; 0 in a valid map.
        overlaps: Pairs of border segments that meet, and patches inside another; 0 in a valid map.
        bijective: True without flips and overlaps: every map point has one body point.
        symmetric_dirichlet: Mean over the area of s1² + s2² + 1/s1² + 1/s2²; 4 is an isometry.
        energy: The same per face.
        angle: s1 / s2: ratio of the largest to the smallest stretch.
        area: The larger of s1 s2 and its inverse: change of area.
        isometry: The larger of s1 and 1 / s2: largest change of length.
        round_trip_mm: 95th percentile over the taxels of the error of body -> map -> pixel centre -> body; None if all
            centres are off their taxels' patches.
        force_error: Largest relative error of the image's force over touches of single taxels.
        seam_mm: Total length of seams on the body.
        seconds: Time of flattening.
        findings: Repairs, additions and quantities that could not be measured.
    """

    patches: int
    taxels: int
    coverage: float
    faces: int
    flips: int
    overlaps: int
    bijective: bool
    symmetric_dirichlet: float
    energy: DistortionSummary
    angle: DistortionSummary
    area: DistortionSummary
    isometry: DistortionSummary
    round_trip_mm: float | None
    force_error: float
    seam_mm: float
    seconds: float
    findings: tuple[Finding, ...]


def measure(
    map_: TactileMap,
    *,
    distances: BodyDistances | None = None,
    images: Sequence[TactileImage] | None = None,
    sources: int | None = None,
    seed: int = 0,
) -> MapQuality:
    """Measure the quality of a map.

    Args:
        map_: Map with at least one patch.
        distances: Body distances of ``map_.skin``, by default computed here at nearly all of the cost. Reuse them
            between edits.
        images: Images that together show all charts of ``map_``, in any layout; by default one image of the map at 512
            pixels.
        sources: See ``BodyDistances``, if computed here.
        seed: See ``BodyDistances``.

    Example:
        >>> quality = tm.measure(tactile_map)
        >>> quality.flips, quality.overlaps, quality.trustworthiness > 0.9
        (0, 0, True)

    Cost: 1.2 s for 1000 taxels on 18,000 faces; 40 ms with given distances and images.
    """
    body = BodyDistances(map_.skin, sources=sources, seed=seed) if distances is None else distances
    images = (TactileImage(map_),) if images is None else images
    faces = distortion(map_)
    over = overlaps(map_)
    flips = int(faces.flipped.sum())
    return MapQuality(
        **vars(measure_topography(map_.taxel_points, body)),
        patches=len(map_.skin.patches),
        taxels=len(map_.skin),
        coverage=map_.skin.coverage,
        faces=len(faces.areas),
        flips=flips,
        overlaps=over,
        bijective=flips == 0 and over == 0,
        symmetric_dirichlet=faces.mean_energy,
        energy=faces.spread(faces.energy),
        angle=faces.spread(faces.angle),
        area=faces.spread(_either_way(faces.area)),
        isometry=faces.spread(faces.isometry),
        round_trip_mm=_percentile(np.concatenate([round_trip_mm(image.map, image) for image in images]), 95),
        force_error=max(float(np.abs(force_error(image)).max(initial=0.0)) for image in images),
        seam_mm=_seam_mm(map_),
        seconds=sum(chart.seconds[-1] for chart in map_.charts if chart.seconds),
        findings=(*map_.skin.findings, *(f for chart in map_.charts for f in chart.findings), *body.findings),
    )


def overlaps(map_: TactileMap) -> int:
    """Return the number of pairs of border segments that meet, plus patches inside another; 0 without overlap."""
    pairs = zip(map_.charts, map_.uv, strict=True)
    borders = [[uv[loop] for loop in chart.connectivity.boundary_loops] for chart, uv in pairs]
    insides = [uv[chart.faces[0]].mean(axis=0) for chart, uv in zip(map_.charts, map_.uv, strict=True)]
    return crossings(*(loop for border in borders for loop in border)) + len(nested_patches(borders, insides))


def _either_way(ratio: FloatArray) -> FloatArray:
    """Return the larger of each ratio and its inverse."""
    with np.errstate(divide="ignore"):
        return np.maximum(ratio, 1 / ratio)


def _seam_mm(map_: TactileMap) -> float:
    pairs = zip(map_.skin.patches, map_.charts, strict=True)
    ends = [patch.surface.vertices[chart.seams] for patch, chart in pairs]
    return 1e3 * float(sum(np.linalg.norm(end[:, 0] - end[:, 1], axis=1).sum() for end in ends))


def _percentile(values: FloatArray, share: float) -> float | None:
    """Return the percentile of the finite values; None if there are none."""
    known = values[np.isfinite(values)]
    return float(np.percentile(known, share)) if len(known) else None
