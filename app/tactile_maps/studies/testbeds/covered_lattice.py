"""Taxels on a hexagonal lattice below a cover, and their readings under a contact of known force, by integration.

15 x 15 taxels 7 mm apart are below an elastic half-space; each senses a disc of 1.9 mm. A contact is Hertz's ellipsoid
of pressure with 1 N. The numbers are those of the theory of force from normal stress below a cover.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.tactile.mechanics.half_space_stress import point_stress, square_stress

PITCH = 7e-3
ELECTRODE = 1.9e-3
SIDE = 15
AREA = float(np.sqrt(3) / 2 * PITCH**2)
"""Area of a taxel [m²]."""
PLACES = 8
"""Number of contacts, near the middle of the lattice."""
_PEAK_SHARE = 0.1
_ABOVE_NOISE = 3.0
_NEAR = 1.1 * PITCH


def _lattice() -> FloatArray:
    i, j = (k.ravel() for k in np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij"))
    points = PITCH * np.stack([i + 0.5 * (j % 2), np.sqrt(3) / 2 * j], axis=1)
    return np.asarray(points - points.mean(axis=0))


def disc(radius: float, count: int) -> FloatArray:
    """Return points (n, 2) spread evenly over a disc [m], ``count`` across."""
    grid = (np.arange(count) + 0.5) / count * 2 - 1
    x, y = (k.ravel() for k in np.meshgrid(grid, grid))
    inside = x**2 + y**2 <= 1
    return np.asarray(radius * np.stack([x[inside], y[inside]], axis=1))


TAXELS = _lattice()
FELT = disc(ELECTRODE, 8)
"""Places of the taxels (225, 2), and the points (n, 2) about each that it senses [m]."""
APART: FloatArray = np.linalg.norm(TAXELS[:, None] - TAXELS, axis=2)
"""Distances between taxels (225, 225) [m]."""
_NEIGHBOURS = (APART < _NEAR) & (APART > 0)


@lru_cache(maxsize=32)
def exact_readings(radius: float, depth: float, *, points: bool = False) -> tuple[FloatArray, ...]:
    """Return the readings of the taxels (225,) [Pa] under 1 N at each of eight places.

    Args:
        radius: Radius of the contact [m].
        depth: Depth of the taxels [m].
        points: Whether taxels sense only at their centres.
    """
    at = disc(radius, 16)
    felt = np.zeros((1, 2)) if points else FELT
    force = np.sqrt(1 - (at**2).sum(axis=1) / radius**2)
    force /= force.sum() * len(felt)
    found = []
    for centre in np.random.default_rng(0).uniform(-PITCH, PITCH, (PLACES, 2)):
        away = (np.linalg.norm(TAXELS[:, None] + part - at - centre, axis=2) for part in felt)
        found.append(np.asarray(sum(point_stress(distance, depth) @ force for distance in away)))
    return tuple(found)


@lru_cache(maxsize=32)
def area_blur(depth: float) -> FloatArray:
    """Return the reading of each taxel per pressure on the area above each taxel (225, 225), sensed by discs.

    Args:
        depth: Depth of the taxels [m].
    """
    side = np.array(np.sqrt(AREA))
    parts = [square_stress(np.linalg.norm(TAXELS[:, None] + f - TAXELS, axis=2), depth, side=side) for f in FELT]
    return np.asarray(sum(parts) / len(parts))


def contact_region(readings: FloatArray, noise: float) -> tuple[IntArray, IntArray]:
    """Return the strongest connected region above 3 sigma and a tenth of the peak, without and with its ring.

    Args:
        readings: (225,) [Pa].
        noise: Standard deviation of each reading [Pa].
    """
    touched = readings >= max(_ABOVE_NOISE * noise, _PEAK_SHARE * float(readings.max()))
    joined = csr_matrix(_NEIGHBOURS & touched & touched[:, None])
    labels = connected_components(joined, directed=False)[1]
    core = touched & (labels == labels[readings.argmax()])
    return np.flatnonzero(core), np.flatnonzero(core | _NEIGHBOURS[core].any(axis=0))
