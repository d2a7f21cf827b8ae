"""Self-organising map: taxels are placed on a sheet of units (Kohonen 1982).

Each unit of a square sheet has a prototype contact, one number per taxel. Each touch is assigned to the unit with the
most similar prototype and pulls the prototypes of that unit and its neighbours on the sheet towards itself; the
neighbourhood shrinks from a large part of the sheet to one unit. The position of a taxel is the mean of the units
weighted by their prototypes. All touches of a round are applied at once (Kohonen's batch map, 2013): a few dozen rounds
instead of many thousand steps, and no learning rate.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix, diags

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.maps.learned.embedding import connected_islands, island_findings, knn_graph, lay_side_by_side
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.learned.readings import TouchReadings, detect_touch

NAME = "self-organising"
SIDE = 20
ROUNDS = 60
_WIDEST = 0.2
_NARROWEST = 0.7
_SHARPNESS = 3.0
_LEAST_SIDE = 4
_GAP = 2.0


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = no_progress, side: int = SIDE) -> LearnedMap:
    """Build a map, see ``Builder``; deterministic.

    Args:
        readings: See ``Builder``.
        seed: See ``Builder``.
        progress: See ``Builder``.
        side: Units along each side of the sheet.

    Cost: 0.4 s for 3000 touches of 250 taxels.
    """
    started = time.perf_counter()
    touch = detect_touch(readings)
    parts = _islands(touch)
    points = np.zeros((len(touch.taxels), 2))
    for part in parts:
        own = max(round(side * np.sqrt(len(part) / len(points))), _LEAST_SIDE)
        points[part] = _placed(_normed(touch.pressures[:, part]), own, progress)
    points, known = touch.everywhere(lay_side_by_side(points, parts, _GAP))
    findings = touch.findings + island_findings(parts)
    return LearnedMap(points, known, NAME, time.perf_counter() - started, None, findings)


def _islands(touch: TouchReadings) -> list[IntArray]:
    """Return connected taxels, one sheet for each part: on a common sheet a small part is pushed into a corner."""
    likeness = _likeness(touch.pressures)
    return connected_islands(knn_graph(np.where(touch.together, 1 - likeness, np.inf)))


def _likeness(pressures: csr_matrix) -> FloatArray:
    """Return the cosine similarity (k, k) between taxels."""
    products = (pressures.T @ pressures).toarray()
    return products / np.sqrt(np.outer(products.diagonal(), products.diagonal()))


def _placed(contacts: csr_matrix, side: int, progress: Progress) -> FloatArray:
    """Return the mean position (m, 2) of the units weighted by their prototype of each taxel."""
    count = contacts.shape[1]
    if count < 3:
        return np.stack([np.arange(count), np.zeros(count)], axis=1)
    share = train_batch_som(contacts, side=side, progress=progress) ** _SHARPNESS
    return (share / share.sum(axis=0)).T @ _sheet(side)


def train_batch_som(contacts: csr_matrix, *, side: int, progress: Progress = no_progress) -> FloatArray:
    """Return the prototypes (side², k) of all units after training, >= 0.

    Args:
        contacts: Sparse (t, k) with rows of length 1.
        side: Units along each side.
        progress: Receives the share of rounds done.
    """
    sheet = _sheet(side)
    squared = ((sheet[:, None] - sheet[None]) ** 2).sum(axis=-1)
    units = _initial_units(contacts, sheet)
    for number, width in enumerate(np.geomspace(_WIDEST * side, _NARROWEST, ROUNDS)):
        progress("Training the self-organising map", number / ROUNDS)
        likeness = contacts @ (units / np.maximum(np.linalg.norm(units, axis=1, keepdims=True), 1e-30)).T
        claimed = likeness.argmax(axis=1)
        sums = csr_matrix((np.ones(len(claimed)), (claimed, np.arange(len(claimed)))), shape=(len(units), len(claimed)))
        near = np.exp(-0.5 * squared / width**2)
        units = near @ (sums @ contacts).toarray()
        units /= np.maximum(near @ np.bincount(claimed, minlength=len(near)), 1e-30)[:, None]
    return units


def _initial_units(contacts: csr_matrix, sheet: FloatArray) -> FloatArray:
    """Return initial prototypes (side², k): nearly equal, graded along the two slowest modes of touch diffusion.

    From random weights the sheet often stays folded (of 250 taxels after 3000 touches 0.6 to 0.8 of the neighbours are
    kept, instead of 0.86). The modes are those of a random walk between taxels by co-activation, Belkin and Niyogi's
    eigenmaps (2003): low-frequency waves over the skin, which a flat sheet can follow.
    """
    likeness = _likeness(contacts)
    root = np.sqrt(likeness.sum(axis=1))
    count = len(root)
    _, modes = eigh(likeness / np.outer(root, root), subset_by_index=[count - 3, count - 2])
    waves = (modes / root[:, None]).T[::-1]
    waves *= np.where((waves**3).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    return 1.0 + sheet @ (waves / np.abs(waves).max(axis=1, keepdims=True)) / np.ptp(sheet)


def _sheet(side: int) -> FloatArray:
    """Return the positions (side², 2) of the units, centred, with a spacing of 1."""
    along = np.arange(side) - 0.5 * (side - 1)
    return np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)


def _normed(pressures: csr_matrix) -> csr_matrix:
    """Return rows with a touch, normalised to length 1 so that the pressure does not matter."""
    length = np.sqrt(np.asarray(pressures.multiply(pressures).sum(axis=1)).ravel())
    touched = length > 0
    return (diags(1 / length[touched]) @ pressures[touched]).tocsr()
