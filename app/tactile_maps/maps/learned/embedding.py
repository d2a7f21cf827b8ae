"""From how unlike taxels are to where they lie: near neighbours, paths between the rest, places that fit.

Classical multidimensional scaling gives places whose scalar products are those that the distances ask for. SMACOF moves
them until their distances fit the wanted ones best, by a majorant that never overshoots. The neighbour graph keeps the
distances that can be trusted, those between near neighbours, and gives the rest as paths along them. ``embed`` does all
of it in a row, island by island.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.geometry.geodesics import all_path_lengths


def classical_mds(distances: FloatArray, *, dimensions: int = 2) -> FloatArray:
    """(n, dimensions) centred points along their principal axes; exact for distances of points in so few dimensions.

    Torgerson 1952. Each axis points to where the points reach farther from their mean (by the third moment), so that
    the same distances give the same points however they are numbered.

    Args:
        distances: (n, n) symmetric, finite.
        dimensions: How many; axes that the distances do not fill are zero.

    Cost: 0.2 s for 1000 points.
    """
    count = len(distances)
    products = -0.5 * distances**2
    products -= products.mean(axis=0)
    products -= products.mean(axis=1, keepdims=True)
    wanted = min(dimensions, count)
    values, axes = eigh(products, subset_by_index=[count - wanted, count - 1])
    points = np.zeros((count, dimensions))
    points[:, :wanted] = (axes * np.sqrt(np.maximum(values, 0.0)))[:, ::-1]
    return points * np.where((points**3).sum(axis=0) < 0, -1.0, 1.0)


@dataclass(frozen=True, eq=False)
class SmacofResult:
    """Points (n, d) and the weighted sum of squared misfits after each round, falling."""

    points: FloatArray
    losses: tuple[float, ...]


def smacof(
    wanted: FloatArray,
    start: FloatArray,
    *,
    rounds: int = 300,
    tolerance: float = 1e-6,
    progress: Progress = no_progress,
) -> SmacofResult:
    """Minimise  sum_ij w_ij (|x_i - x_j| - d_ij)²  with  w = 1 / d², so that relative errors count alike.

    De Leeuw 1977; Borg and Groenen, Modern Multidimensional Scaling, 8.6. Each round is the exact minimum of a
    quadratic that touches the loss and nowhere lies below it, so the loss never rises. Without the weights the many
    long distances, which are the least certain, would decide where neighbours lie.

    Args:
        wanted: (n, n) symmetric, > 0 off the diagonal.
        start: (n, d).
        rounds: At most.
        tolerance: Stop when a round lowers the loss by less than this share.
        progress: Told the share of ``rounds`` done.

    Cost: 0.1 s once and 20 ms a round for 1000 points.
    """
    weights = _weights(wanted)
    laplacian = np.diag(weights.sum(axis=1)) - weights
    # Adding a constant to all entries fixes the one direction it leaves free, all points moved alike.
    inverse = np.linalg.inv(laplacian + laplacian.trace() / len(wanted) ** 2)
    points = start - start.mean(axis=0)
    losses = [np.inf]
    for number in range(rounds):
        apart = cdist(points, points)
        losses.append(0.5 * float((weights * (apart - wanted) ** 2).sum()))
        if losses[-2] - losses[-1] <= tolerance * losses[-1]:
            break
        progress("Fitting distances", number / rounds)
        pull = -weights * np.divide(wanted, apart, out=np.zeros_like(apart), where=apart > 0)
        pull[np.diag_indices_from(pull)] -= pull.sum(axis=1)
        points = inverse @ (pull @ points)
    return SmacofResult(points, tuple(losses[1:]))


def _weights(wanted: FloatArray) -> FloatArray:
    return np.divide(1.0, wanted**2, out=np.zeros_like(wanted), where=wanted > 0)


def kruskal_stress(points: FloatArray, wanted: FloatArray) -> float | None:
    """Kruskal's stress-1 of the points' distances against ``wanted`` (n, n), at the best common scale.

    None where all points are one: no scale makes that another.
    """
    apart = cdist(points, points)
    square = (apart**2).sum()
    if square == 0:
        return None
    scale = (apart * wanted).sum() / square
    return float(np.sqrt(((scale * apart - wanted) ** 2).sum() / (wanted**2).sum()))


NEIGHBOURS = 6
_TIE = 1e-9


def knn_graph(distances: FloatArray, *, neighbours: int = NEIGHBOURS) -> csr_matrix:
    """Sparse symmetric (n, n): each node joined to its nearest ``neighbours``, whichever of the two found the other.

    Ties are all taken, so that the graph does not depend on how the nodes are numbered.

    Args:
        distances: (n, n) symmetric, >= 0; inf for a pair that must not be joined.
        neighbours: At least 1.
    """
    apart = distances.copy()
    np.fill_diagonal(apart, np.inf)
    count = len(apart)
    place = min(neighbours, count - 1) - 1
    reach = np.partition(apart, place, axis=1)[:, place] if count > 1 else np.full(count, np.inf)
    near = np.isfinite(apart) & (apart <= reach[:, None] * (1 + _TIE))
    i, j = np.nonzero(near | near.T)
    # A path may not be free: two taxels that always read the same still are two.
    least = _TIE * float(np.max(apart[i, j], initial=0.0)) or _TIE
    return csr_matrix((np.maximum(apart[i, j], least), (i, j)), shape=apart.shape)


def connected_islands(graph: csr_matrix) -> list[IntArray]:
    """Nodes of each connected part, the largest first."""
    _, label = connected_components(graph, directed=False)
    parts = [np.flatnonzero(label == number) for number in range(label.max(initial=-1) + 1)]
    return sorted(parts, key=lambda part: (-len(part), int(part[0])))


_GAP = 3.0


@dataclass(frozen=True, eq=False)
class Embedding:
    """Points (k, 2), Kruskal's stress-1 against the completed distances, and what was noticed."""

    points: FloatArray
    stress: float | None
    findings: tuple[Finding, ...]


Embedder = Callable[[FloatArray, Progress], tuple[FloatArray, tuple[Finding, ...]]]
"""Points (m, 2) for distances (m, m) that all are known, and what was noticed."""


def embed_in_plane(wanted: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Classical scaling to the plane, improved by SMACOF."""
    start = classical_mds(wanted)
    return (smacof(wanted, start, progress=progress).points if len(wanted) > 2 else start), ()


def embed(
    unlike: FloatArray,
    *,
    neighbours: int = NEIGHBOURS,
    lay: Embedder = embed_in_plane,
    progress: Progress = no_progress,
) -> Embedding:
    """Isomap's way (Tenenbaum, de Silva and Langford 2000), with SMACOF in the place of its last step.

    Two taxels that are never touched together are equally unlike whether near or far, so only near neighbours are
    believed; longer distances are paths between them. Taxels with no path between them, as those of two hands that
    never touch, are islands: nothing is known of their distance, so they are laid side by side, and a finding says so.

    Args:
        unlike: (k, k) symmetric, >= 0; inf for a pair of which nothing is known.
        neighbours: How many each taxel is believed to have.
        lay: How an island is flattened once all its distances are known.
        progress: Told how far it is.

    Cost: 30 ms for 250 taxels, 0.5 s for 1000, with an idle processor.
    """
    graph = knn_graph(unlike, neighbours=neighbours)
    parts = connected_islands(graph)
    lengths = all_path_lengths(graph)
    spacing = float(np.median(graph.data)) if graph.nnz else 1.0
    points = np.zeros((len(unlike), 2))
    findings = island_findings(parts)
    losses: list[float | None] = []
    for part in parts:
        wanted = lengths[np.ix_(part, part)]
        points[part], notes = lay(wanted, progress)
        findings += notes
        losses.append(kruskal_stress(points[part], wanted) if len(part) > 2 else 0.0)
    known = [loss for loss in losses if loss is not None]
    weights = [len(part) for part in parts]
    stress = float(np.average(known, weights=weights)) if len(known) == len(losses) else None
    return Embedding(lay_side_by_side(points, parts, _GAP * spacing), stress, findings)


def lay_side_by_side(points: FloatArray, parts: list[IntArray], gap: float) -> FloatArray:
    """Each part moved to the right of those before."""
    moved = points.copy()
    right = 0.0
    for part in parts:
        low = points[part].min(axis=0)
        high = points[part].max(axis=0)
        moved[part] += [right - low[0], -0.5 * (low[1] + high[1])]
        right += high[0] - low[0] + gap
    return moved


def island_findings(parts: list[IntArray]) -> tuple[Finding, ...]:
    if len(parts) < 2:
        return ()
    sizes = ", ".join(str(len(part)) for part in parts[:12]) + (", ..." if len(parts) > 12 else "")
    action = "no contact touched two of them at once, so their relative positions are unknown; placed side by side"
    return (Finding("islands", f"parts of {sizes} taxels", action, len(parts)),)
