"""The geodesic information map: taxels placed in space first, as a body is, and laid flat from there.

McGregor, Polani and Dautenhahn's ANISOMAP (PLoS ONE 6(11), 2011) reconstructs a tactile surface in three dimensions
from information alone, by a scaling of Isomap's kind that withstands sensor failure. Its exact steps are not known
here; this is a map of the same kind, not a copy of theirs: (1) information distance between taxels; (2) near neighbours
joined, each distance in units of what is near for its two ends, so that a taxel which tells little (touched less, at a
border, on a coarse part) is not pushed away; (3) paths; (4) scaling to three dimensions. Ours is the last step: (5) a
surface through the points, laid flat as a body's is.

Three dimensions first, because bodies are closed: in the plane a tube must be crushed at once. In space it is a tube,
which can be cut and unrolled. Of 250 taxels on a tube the plane keeps half of the neighbours, this way four fifths.
"""

from __future__ import annotations

import time

import numpy as np

from app.arrays import FloatArray
from app.errors import Finding, MapError
from app.maps.learned.classical_mds import classical_mds
from app.maps.learned.information_distance import unlikeness
from app.maps.learned.knn_graph import NEIGHBOURS
from app.maps.learned.lay_open import lay_open
from app.maps.learned.learned_map import LearnedMap, Progress, silent
from app.maps.learned.placing import in_plane, place
from app.maps.learned.readings import felt
from app.maps.learned.smacof import smacof

NAME = "geodesic-information"


def build(readings: FloatArray, *, seed: int = 0, progress: Progress = silent) -> LearnedMap:
    """See ``Builder``. There is no chance in it. Cost: 0.2 s for 250 taxels and 3000 touches, 2 s for 1000."""
    started = time.perf_counter()
    progress("Comparing taxels", 0.0)
    touch = felt(readings)
    placed = place(in_units_of_near(unlikeness(touch)), lay=through_space, progress=progress)
    points, known = touch.everywhere(placed.points)
    findings = touch.findings + placed.findings
    return LearnedMap(points, known, NAME, time.perf_counter() - started, placed.stress, findings)


def through_space(wanted: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Places (m, 2) for distances (m, m) by way of space; straight in the plane where no surface shows there."""
    try:
        opened = lay_open(in_space(wanted, progress=progress))
    except MapError as error:
        points, _ = in_plane(wanted, progress)
        return points, (Finding("no-learned-surface", NAME, f"{error.problem}; placed in the plane at once"),)
    return opened.points, opened.findings


def in_space(wanted: FloatArray, *, progress: Progress = silent) -> FloatArray:
    """(m, 3) points for distances (m, m) that all are known."""
    return smacof(wanted, classical_mds(wanted, dimensions=3), progress=progress).points


def in_units_of_near(unlike: FloatArray, *, neighbours: int = NEIGHBOURS) -> FloatArray:
    """(k, k) each distance divided by the geometric mean of what its two ends have for near.

    Zelnik-Manor and Perona 2004. Near is the distance to the neighbour of rank ``neighbours``, or the
    farthest known where a taxel has fewer.
    """
    known = np.where(np.isfinite(unlike), unlike, np.nan)
    np.fill_diagonal(known, np.nan)
    ordered = np.sort(known, axis=1)[:, :neighbours]
    ranks = np.maximum(np.isfinite(ordered).sum(axis=1), 1) - 1
    near = np.nan_to_num(ordered[np.arange(len(ordered)), ranks], nan=1.0)
    root = np.sqrt(np.where(near > 0, near, 1.0))
    return unlike / np.outer(root, root)
