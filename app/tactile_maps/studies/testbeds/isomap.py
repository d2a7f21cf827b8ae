"""A map by Isomap over neighbouring taxels, as published maps of real skins were made; used for comparison."""

from __future__ import annotations

import time

import numpy as np

from tactile_maps.maps.learned.embedding import embed
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap

ISOMAP = "isomap"


def isomap(map_: TactileMap) -> LearnedMap:
    """Return taxel places whose distances fit the shortest paths between neighbours (Tenenbaum et al. 2000).

    Args:
        map_: Map of the skin; neighbours across its seams are ignored, because a sleeve could not be flattened.

    Cost: 1 s for 1000 taxels.
    """
    began = time.perf_counter()
    skin = map_.skin
    first, second = skin.neighbours.T
    away = np.linalg.norm(skin.positions[first] - skin.positions[second], axis=1)
    on_map = np.linalg.norm(map_.taxel_points[first] - map_.taxel_points[second], axis=1)
    near = on_map <= SEAM_RATIO * away
    distances = np.full((len(skin), len(skin)), np.inf)
    np.fill_diagonal(distances, 0.0)
    distances[first[near], second[near]] = distances[second[near], first[near]] = away[near]
    embedded = embed(distances)
    placed = np.ones(len(skin), dtype=bool)
    seconds = time.perf_counter() - began
    return LearnedMap(embedded.points, placed, ISOMAP, seconds, embedded.stress, embedded.findings)
