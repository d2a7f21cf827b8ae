"""From how unlike taxels are to where they lie: near neighbours, paths between the rest, places that fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import Finding
from app.maps.learned.classical_mds import classical_mds
from app.maps.learned.knn_graph import NEIGHBOURS, islands, knn_graph, path_lengths
from app.maps.learned.learned_map import Progress, silent
from app.maps.learned.smacof import kruskal_stress, smacof

_GAP = 3.0


@dataclass(frozen=True, eq=False)
class Placed:
    """Points (k, 2), Kruskal's stress-1 against the completed distances, and what was noticed."""

    points: FloatArray
    stress: float
    findings: tuple[Finding, ...]


Layer = Callable[[FloatArray, Progress], tuple[FloatArray, tuple[Finding, ...]]]
"""Points (m, 2) for distances (m, m) that all are known, and what was noticed."""


def in_plane(wanted: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Classical scaling to the plane, improved by SMACOF."""
    start = classical_mds(wanted)
    return (smacof(wanted, start, progress=progress).points if len(wanted) > 2 else start), ()


def place(
    unlike: FloatArray, *, neighbours: int = NEIGHBOURS, lay: Layer = in_plane, progress: Progress = silent
) -> Placed:
    """Isomap's way (Tenenbaum, de Silva and Langford 2000), with SMACOF in the place of its last step.

    Two taxels that are never touched together are equally unlike whether near or far, so only near neighbours are
    believed; longer distances are paths between them. Taxels with no path between them, as those of two hands that
    never touch, are islands: nothing is known of their distance, so they are laid side by side, and a finding says so.

    Args:
        unlike: (k, k) symmetric, >= 0; inf for a pair of which nothing is known.
        neighbours: How many each taxel is believed to have.
        lay: How an island is laid flat once all its distances are known.
        progress: Told how far it is.

    Cost: 30 ms for 250 taxels, 0.5 s for 1000, with an idle processor.
    """
    graph = knn_graph(unlike, neighbours=neighbours)
    parts = islands(graph)
    lengths = path_lengths(graph)
    spacing = float(np.median(graph.data)) if graph.nnz else 1.0
    points, losses, findings = np.zeros((len(unlike), 2)), [], island_findings(parts)
    for part in parts:
        wanted = lengths[np.ix_(part, part)]
        points[part], notes = lay(wanted, progress)
        findings += notes
        losses.append(kruskal_stress(points[part], wanted) if len(part) > 2 else 0.0)
    stress = float(np.average(losses, weights=[len(part) for part in parts]))
    return Placed(side_by_side(points, parts, _GAP * spacing), stress, findings)


def side_by_side(points: FloatArray, parts: list[IntArray], gap: float) -> FloatArray:
    """Each part moved to the right of those before."""
    moved, right = points.copy(), 0.0
    for part in parts:
        low, high = points[part].min(axis=0), points[part].max(axis=0)
        moved[part] += [right - low[0], -0.5 * (low[1] + high[1])]
        right += high[0] - low[0] + gap
    return moved


def island_findings(parts: list[IntArray]) -> tuple[Finding, ...]:
    if len(parts) < 2:
        return ()
    sizes = ", ".join(str(len(part)) for part in parts[:12]) + (", ..." if len(parts) > 12 else "")
    action = "nothing was felt on two of them at once, so their places to each other are not known; laid side by side"
    return (Finding("islands", f"parts of {sizes} taxels", action, len(parts)),)
