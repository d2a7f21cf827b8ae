"""Embedding of dissimilarities: near neighbours, paths between the rest, and positions that fit.

Classical multidimensional scaling computes positions whose scalar products match the distances. SMACOF moves them until
their distances fit the target distances best, by a majorant that never overshoots. The neighbour graph keeps only
reliable distances, those between near neighbours, and replaces the rest by path lengths. ``embed`` combines all steps,
island by island.
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
    """Return centred points (n, dimensions) along their principal axes; exact for distances in that dimension.

    Torgerson 1952. Each axis points to the side where the points extend farther from their mean (by the third moment),
    so that the result does not depend on the order of the points.

    Args:
        distances: (n, n) symmetric, finite.
        dimensions: Number of dimensions; axes that the distances do not fill are zero.

    Cost: 0.2 s for 1000 points.
    """
    count = len(distances)
    products = -0.5 * distances**2
    products -= products.mean(axis=0)
    products -= products.mean(axis=1, keepdims=True)
    used = min(dimensions, count)
    values, axes = eigh(products, subset_by_index=[count - used, count - 1])
    points = np.zeros((count, dimensions))
    points[:, :used] = (axes * np.sqrt(np.maximum(values, 0.0)))[:, ::-1]
    return points * np.where((points**3).sum(axis=0) < 0, -1.0, 1.0)


def smacof(
    distances: FloatArray,
    start: FloatArray,
    *,
    rounds: int = 300,
    tolerance: float = 1e-6,
    progress: Progress = no_progress,
) -> FloatArray:
    """Minimise  sum_ij w_ij (|x_i - x_j| - d_ij)²  with  w = 1 / d², so that relative errors count alike.

    De Leeuw 1977; Borg and Groenen, Modern Multidimensional Scaling, 8.6. Each round is the exact minimum of a
    quadratic majorant of the loss, so the loss never increases. Without the weights the many long distances, which are
    the least certain, would dominate the positions of neighbours.

    Args:
        distances: (n, n) symmetric, > 0 off the diagonal.
        start: (n, d) initial points.
        rounds: Largest number of rounds.
        tolerance: Relative decrease of the loss below which iteration stops.
        progress: Receives the share of ``rounds`` done.

    Cost: 0.1 s once and 20 ms a round for 1000 points.
    """
    weights = np.divide(1.0, distances**2, out=np.zeros_like(distances), where=distances > 0)
    laplacian = np.diag(weights.sum(axis=1)) - weights
    # A constant added to all entries fixes the remaining degree of freedom, the common translation.
    inverse = np.linalg.inv(laplacian + laplacian.trace() / len(distances) ** 2)
    points = start - start.mean(axis=0)
    last = np.inf
    for number in range(rounds):
        apart = cdist(points, points)
        loss = 0.5 * float((weights * (apart - distances) ** 2).sum())
        if last - loss <= tolerance * loss:
            break
        last = loss
        progress("Fitting distances", number / rounds)
        pull = -weights * np.divide(distances, apart, out=np.zeros_like(apart), where=apart > 0)
        pull[np.diag_indices_from(pull)] -= pull.sum(axis=1)
        points = inverse @ (pull @ points)
    return points


def kruskal_stress(points: FloatArray, distances: FloatArray) -> float | None:
    """Return Kruskal's stress-1 of the points' distances against ``distances`` (n, n), at the best common scale.

    None if all points coincide, where no scale exists.
    """
    apart = cdist(points, points)
    square = (apart**2).sum()
    if square == 0:
        return None
    scale = (apart * distances).sum() / square
    return float(np.sqrt(((scale * apart - distances) ** 2).sum() / (distances**2).sum()))


NEIGHBOURS = 6
_TIE = 1e-9


def knn_graph(distances: FloatArray, *, neighbours: int = NEIGHBOURS) -> csr_matrix:
    """Return a sparse symmetric graph (n, n) that joins each node to its nearest ``neighbours``, in either direction.

    All ties are included, so that the graph does not depend on the order of the nodes.

    Args:
        distances: (n, n) symmetric, >= 0; inf for a pair that must not be joined.
        neighbours: Number of neighbours, at least 1.
    """
    apart = distances.copy()
    np.fill_diagonal(apart, np.inf)
    count = len(apart)
    place = min(neighbours, count - 1) - 1
    reach = np.partition(apart, place, axis=1)[:, place] if count > 1 else np.full(count, np.inf)
    near = np.isfinite(apart) & (apart <= reach[:, None] * (1 + _TIE))
    i, j = np.nonzero(near | near.T)
    # Edge lengths must be positive: two taxels with equal readings are still distinct.
    least = _TIE * float(np.max(apart[i, j], initial=0.0)) or _TIE
    return csr_matrix((np.maximum(apart[i, j], least), (i, j)), shape=apart.shape)


def connected_islands(graph: csr_matrix) -> list[IntArray]:
    """Return the nodes of each connected component, the largest first."""
    _, label = connected_components(graph, directed=False)
    parts = [np.flatnonzero(label == number) for number in range(label.max(initial=-1) + 1)]
    return sorted(parts, key=lambda part: (-len(part), int(part[0])))


_GAP = 3.0


@dataclass(frozen=True, eq=False)
class Embedding:
    """Points (k, 2), Kruskal's stress-1 against the completed distances, and findings."""

    points: FloatArray
    stress: float | None
    findings: tuple[Finding, ...]


Embedder = Callable[[FloatArray, Progress], tuple[FloatArray, tuple[Finding, ...]]]
"""Function from complete distances (m, m) to points (m, 2) and findings."""


def embed_in_plane(distances: FloatArray, progress: Progress) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Embed by classical scaling to the plane, improved by SMACOF."""
    start = classical_mds(distances)
    return (smacof(distances, start, progress=progress) if len(distances) > 2 else start), ()


def embed(
    unlike: FloatArray,
    *,
    neighbours: int = NEIGHBOURS,
    lay: Embedder = embed_in_plane,
    progress: Progress = no_progress,
) -> Embedding:
    """Embed taxels like Isomap (Tenenbaum, de Silva and Langford 2000), with SMACOF instead of its last step.

    Two taxels that are never touched together are equally dissimilar whether near or far, so only near neighbours are
    used; longer distances are paths between them. Taxels without a path between them, as those of two hands that never
    touch, are islands: their distance is unknown, so they are placed side by side, and a finding reports it.

    Args:
        unlike: (k, k) dissimilarities, symmetric, >= 0; inf if unknown.
        neighbours: Number of near neighbours of each taxel.
        lay: Embeds an island once all its distances are known.
        progress: Receives the progress.

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
        distances = lengths[np.ix_(part, part)]
        points[part], notes = lay(distances, progress)
        findings += notes
        losses.append(kruskal_stress(points[part], distances) if len(part) > 2 else 0.0)
    known = [loss for loss in losses if loss is not None]
    weights = [len(part) for part in parts]
    stress = float(np.average(known, weights=weights)) if len(known) == len(losses) else None
    return Embedding(lay_side_by_side(points, parts, _GAP * spacing), stress, findings)


def lay_side_by_side(points: FloatArray, parts: list[IntArray], gap: float) -> FloatArray:
    """Move each part to the right of the previous ones."""
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
