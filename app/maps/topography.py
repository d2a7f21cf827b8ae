"""How well the map keeps the body's neighbourhoods and distances: what makes it topographic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import Finding
from app.maps.geodesics import Geodesics
from app.maps.tactile_map import TactileMap

NEIGHBOURS = 6
TORN = 2.0
"""Neighbours more than so many times farther apart on the map than on the body are torn apart by a seam."""


@dataclass(frozen=True)
class Topography:
    """See ``MapQuality`` for what each number says."""

    edge_error: float
    torn: float
    stress: float
    trustworthiness: float
    continuity: float
    findings: tuple[Finding, ...]


def topography(map_: TactileMap, *, sources: int, seed: int) -> Topography:
    """Compare distances on map and body, patch by patch; patches count by their taxels.

    Args:
        map_: The map.
        sources: How many taxels of the whole skin exact distances are taken from; at least two of each patch.
        seed: Chooses them.
    """
    edge_error, torn = edge_lengths(map_)
    generator, findings, rows = np.random.default_rng(seed), [], []
    for number, patch in enumerate(map_.skin.patches):
        count, geodesics = len(patch.taxels), Geodesics(patch.surface)
        if not geodesics.exact:
            findings.append(Finding("inexact-distance", patch.name, "body distances taken along edges"))
        wanted = min(count, max(2, round(sources * count / max(len(map_.skin), 1))))
        chosen = np.sort(generator.choice(count, wanted, replace=False))
        rows.append((count, _stress(map_, number, geodesics, chosen), *_neighbourhoods(map_, number, geodesics)))
    counts, *values = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    stress, trust, continuity = (_mean(value, counts) for value in values)
    return Topography(edge_error, torn, stress, trust, continuity, tuple(findings))


def edge_lengths(map_: TactileMap) -> tuple[float, float]:
    """Rms relative error of the lengths between neighbours at the best common scale, and the share torn apart.

    On the body the length is that of the circular arc between two taxels that turns by the angle of their normals:
    exact on a sphere and around a tube, where the straight line is too short.
    """
    skin = map_.skin
    if not len(skin.neighbours):
        return 0.0, 0.0
    i, j = skin.neighbours.T
    positions = np.concatenate([patch.taxels.positions for patch in skin.patches])
    normals = np.concatenate([patch.taxels.normals for patch in skin.patches])
    half = 0.5 * np.arccos(np.clip((normals[i] * normals[j]).sum(axis=1), -1.0, 1.0))
    on_body = np.linalg.norm(positions[i] - positions[j], axis=1) / np.sinc(half / np.pi)
    on_map = np.linalg.norm(map_.taxel_points[i] - map_.taxel_points[j], axis=1)
    torn = on_map > TORN * on_body
    kept = ~torn & (on_body > 0)
    if not kept.any():
        return float("nan"), float(torn.mean())
    ratio = on_map[kept] / on_body[kept]
    return float(np.sqrt(np.mean((ratio / _best_scale(ratio) - 1) ** 2))), float(torn.mean())


def _best_scale(ratio: FloatArray) -> float:
    """The scale s that makes mean((ratio / s - 1)²) least."""
    return float((ratio**2).sum() / ratio.sum())


def _stress(map_: TactileMap, number: int, geodesics: Geodesics, chosen: IntArray) -> float:
    """Kruskal's stress-1 of the map's distances against exact ones over the uncut body, at the best scale.

    Both are taken between the taxels' nearest vertices, so that no rounding to vertices enters.
    """
    vertices, plane = _nearest_vertices(map_, number)
    if len(vertices) < 2:
        return 0.0
    on_body = np.stack([geodesics.from_vertex(int(vertices[k]), vertices) for k in chosen])
    on_map = np.linalg.norm(plane[chosen, None] - plane[None], axis=2)
    square = (on_map**2).sum()
    if square == 0:
        return float("nan")
    scale = (on_map * on_body).sum() / square
    return float(np.sqrt(((scale * on_map - on_body) ** 2).sum() / (on_body**2).sum()))


def _nearest_vertices(map_: TactileMap, number: int) -> tuple[IntArray, FloatArray]:
    """For each taxel the heaviest corner of its face: surface vertex (n,) and map point (n, 2)."""
    taxels, chart = map_.skin.patches[number].taxels, map_.charts[number]
    corner = chart.faces[taxels.faces, taxels.weights.argmax(axis=1)]
    return chart.vertex_of[corner], map_.uv[number][corner]


def _neighbourhoods(map_: TactileMap, number: int, geodesics: Geodesics) -> tuple[float, float]:
    """Trustworthiness (no false neighbours on the map) and continuity (none lost); Venna and Kaski 2001."""
    vertices, plane = _nearest_vertices(map_, number)
    if len(vertices) < 3 * NEIGHBOURS:
        return float("nan"), float("nan")
    on_body = np.stack([geodesics.quickly_from_vertex(int(v), vertices) for v in vertices])
    on_map = np.linalg.norm(plane[:, None] - plane[None], axis=2)
    body, flat = _ranks(on_body), _ranks(on_map)
    return _kept(flat, body), _kept(body, flat)


def _ranks(distances: FloatArray) -> IntArray:
    """(n, n) place of each other taxel in each one's order of distance, from 1; 0 is the taxel itself."""
    ordered = distances.copy()
    np.fill_diagonal(ordered, -np.inf)
    return np.argsort(np.argsort(ordered, axis=1, kind="stable"), axis=1)


def _kept(here: IntArray, there: IntArray, *, k: int = NEIGHBOURS) -> float:
    """One minus the normed sum of how far the k nearest by ``here`` are beyond place k by ``there``."""
    count = len(here)
    beyond = np.where((here >= 1) & (here <= k), np.maximum(there - k, 0), 0).sum()
    return float(1 - 2 * beyond / (count * k * (2 * count - 3 * k - 1)))


def _mean(values: FloatArray, weights: FloatArray) -> float:
    """Weighted mean of what could be measured; nan where nothing could."""
    known = np.isfinite(values)
    return float(np.average(values[known], weights=weights[known])) if known.any() else float("nan")
