"""Isomap over neighbours, as published maps were made."""

from __future__ import annotations

import numpy as np

from tactile_maps.studies.testbeds.isomap import isomap
from tests.support.touch import prepared_bar


def test_flat_patch_is_reproduced_except_for_corners_of_its_paths():
    map_ = prepared_bar().map
    learned = isomap(map_)
    body = map_.skin.patches[0].taxels.positions
    pairs = map_.skin.neighbours
    laid, true = (np.linalg.norm(np.subtract(*points[pairs.T]), axis=1) for points in (learned.points, body))
    assert learned.placed.all()
    assert np.median(np.abs(laid / np.median(laid / true) / true - 1)) < 0.1
