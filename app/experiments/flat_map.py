"""A flat square skin and its map, which is the identity: where an image's error is the interpolation's alone."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import FloatArray
from app.experiments.meshes import square_sheet
from app.maps.chart import Chart
from app.maps.layout import MapLayout, Placement
from app.maps.tactile_map import TactileMap
from app.skin.place import taxels_at
from app.skin.skin import Patch, Skin

SIDE = 0.1
"""Of the square [m]."""
_JITTER = 0.2


def flat_map(taxels: int, *, seed: int = 0) -> TactileMap:
    """About ``taxels`` of them, one in each cell of a grid, up to 0.2 cells off its middle. Cost: 50 µs each."""
    side = max(round(np.sqrt(taxels)), 1)
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    middles = np.stack([x, y], axis=-1).reshape(-1, 2) + 0.5
    places = SIDE / side * (middles + np.random.default_rng(seed).uniform(-_JITTER, _JITTER, middles.shape))
    surface = square_sheet(8 * side**2, size=SIDE)
    centres = surface.vertices[surface.faces].mean(axis=1)[:, :2]
    owner = cKDTree(places).query(centres)[1].astype(np.int64)
    worn = taxels_at(surface, np.column_stack([places, np.zeros(len(places))]), owner)
    skin = Skin((Patch("square", "square", surface, worn),))
    flat: FloatArray = surface.vertices[:, :2]
    chart = Chart(surface.faces, flat, np.arange(len(flat)), np.zeros((0, 2), np.int64), "unroll")
    return TactileMap(skin, (chart,), MapLayout((Placement(),)))
