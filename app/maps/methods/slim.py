"""Scalable locally injective maps (Rabinovich et al. 2017; libigl): the same energy as ``balanced``, reweighted.

Cost: 40 ms a round for 10,000 faces, ten to forty rounds. Loses: time; the peer that ``balanced`` is measured against.
"""

from __future__ import annotations

from collections.abc import Iterator

import igl
import numpy as np

from app.arrays import FloatArray
from app.maps.methods.disk import Disk

_ROUNDS, _STILL = 100, 1e-4


def flatten_disk(disk: Disk) -> Iterator[FloatArray]:
    """Rounds from Tutte's map until one gains less than 1e-4 of what could be gained."""
    none, nowhere = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
    energy = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    start = np.ascontiguousarray(disk.start)
    data = igl.slim_precompute(disk.positions, disk.faces, start, energy, none, nowhere, 0.0)
    reached = disk.energy.energy(disk.start)
    for _ in range(_ROUNDS):
        plane = np.asarray(igl.slim_solve(data, 1))[:, :2]
        yield plane
        before, reached = reached, disk.energy.energy(plane)
        if not before - reached > _STILL * max(reached - 4, 1e-9):
            return
