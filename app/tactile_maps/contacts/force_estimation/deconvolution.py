"""Estimators that remove the cover's blur: pressures on a region and its ring that explain its readings.

``ContactOperator`` is the blur as a matrix (``BlurMatrix``): readings are the matrix times the pressures above the
taxels. ``Deconvolution`` sets up the equations of a region, solves them for the distribution, computes the total from
the balance of forces, and reports how well the result is determined. The solvers are ``nonnegative_least_squares``
(Lawson and Hanson, 1974) and ``tikhonov`` (regularization with the discrepancy principle, Morozov 1966).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_matrix

from tactile_maps.contacts.force_estimation.estimate import (
    ContactReading,
    EstimateRefusal,
    ForceEstimate,
    numerical_rank,
)
from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.half_space_stress import subsurface_field
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points


@dataclass(frozen=True, eq=False)
class BlurMatrix:
    """A matrix (m, n) with its singular value decomposition: matrix = left diag(values) right.

    Attributes:
        matrix: (m, n) readings per pressure.
        left: (m, r), r = min(m, n).
        values: (r,) singular values, decreasing.
        right: (r, n).
    """

    matrix: FloatArray
    left: FloatArray
    values: FloatArray
    right: FloatArray

    @classmethod
    def of(cls, matrix: FloatArray) -> BlurMatrix:
        """Return the decomposition of a matrix. Cost: 0.2 ms for 30 x 30."""
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        return cls(readonly(matrix), readonly(left), readonly(values), readonly(right))


_KEPT = 32
"""Number of regions whose equations are stored."""


class ContactOperator:
    """Mean stress over each taxel's area for unit pressure on each taxel's area. Built once for a skin.

    Love's formula under many small squares in every area, by the same table as the half-space model of touch. It
    averages areas over areas: point forces above point taxels give well-conditioned equations but wrong forces where
    the cover is shallower than the pitch, 47 % too low at half the pitch and 85 % at a quarter.

    Args:
        skin: The skin.
        depth: Depth of the taxels below the surface [m], > 0.

    Raises:
        MapError: The depth is out of range.
        SimulationError: The cover is too deep for so fine a skin.

    Cost: that of ``subsurface_field``, 0.15 s for 1000 taxels 2 mm below the arm's surface, 2.2 s for 10,000.
    """

    def __init__(self, skin: Skin, depth: float) -> None:
        if not 0 < depth < 1:
            raise MapError("the taxel depth is out of range", value=f"{depth} m", remedy="Choose 0.0001 to 0.05 m")
        points = quadrature_points(skin)
        table = subsurface_field(skin, depth)
        clusters, width = table.taxels.shape
        areas = np.bincount(table.cluster, points.areas, minlength=clusters)
        owner = np.zeros(clusters, dtype=np.int64)
        owner[table.cluster] = points.taxel  # all points of a cluster belong to one taxel
        rows = table.taxels.ravel()
        columns = np.repeat(owner, width)
        felt = table.weights.ravel() * np.repeat(areas, width)
        self._blur = csr_matrix((felt, (rows, columns)), shape=(len(skin), len(skin)))
        self._kept: dict[bytes, BlurMatrix] = {}

    def blur(self, taxels: IntArray) -> BlurMatrix:
        """Return the blur of the areas of ``taxels`` (k,) over the same taxels.

        Cost: 0.5 ms for 30 taxels; none for a recently used region.
        """
        key = taxels.tobytes()
        found = self._kept.get(key)
        if found is None:
            if len(self._kept) >= _KEPT:
                del self._kept[next(iter(self._kept))]
            whole = np.asarray(self._blur[taxels][:, taxels].toarray(), dtype=np.float64)
            found = self._kept[key] = BlurMatrix.of(whole)
        return found


Solver: TypeAlias = Callable[[BlurMatrix, FloatArray, float], FloatArray]
"""Function of the blur of n areas over m taxels, readings (m,) [Pa] and their noise [Pa]: pressures (n,) [Pa]."""


class Deconvolution:
    """Force from the pressures on a region and its ring that explain its readings. Built once for a skin.

    Taxels farther away add only noise, see the solvers.

    The solver's own total is biased, even without noise: its pressures are constant within each area, but a contact
    smaller than an area reaches the neighbours less than such a pressure would. Non-negative pressures cannot make up
    for it (their total was 3 to 14 % too large), and negative ones at the rim take 1 % away. The total therefore comes
    from the balance of forces, which holds for any distribution within the areas: the cover passes on all force, so the
    readings times areas sum to the force, except for the share that passes beyond the region and its ring. That share
    follows from the non-negative distribution, and the solver's distribution is scaled to the total.

    Against exact half-space stress (flat skins with pitches of 3 to 10 mm at depths of 1 to 4 mm, balls of 3 to 30 mm,
    1 to 20 N) the median of the total is within 1 %; the sum of pressure times area alone loses up to 2.7 %.

    The force is reported even where its distribution is refused. Net shear is not observable.

    Args:
        skin: The skin.
        solver: Solver of the equations.
        depth: Depth of the taxels below the surface [m], > 0.

    Raises:
        MapError: The depth is out of range.
        SimulationError: The cover is too deep for so fine a skin.

    Cost: that of ``ContactOperator`` to build.
    """

    def __init__(self, skin: Skin, solver: Solver, *, depth: float) -> None:
        self._areas = skin.areas
        self._solver = solver
        self._operator = ContactOperator(skin, depth)

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """Return the force and, unless refused, its distribution. Cost: 0.15 ms for 30 taxels touched before."""
        taxels = reading.region.taxels
        blur = self._operator.blur(taxels)
        own = reading.pressures.take(taxels)
        areas = self._areas.take(taxels)
        pressures = self._solver(blur, own, reading.noise)
        rank = numerical_rank(blur.values, own, reading.noise, unknowns=len(own))
        missed = blur.matrix @ pressures - own
        share = share_inside(blur, areas, own, pressures)
        force = float(areas @ own) / share
        bearing = float(areas @ pressures)
        variance = np.square(areas / share) @ reading.variances_of(own)
        refused = rank.refusal or (EstimateRefusal.PULL if min(force, bearing) <= 0 else None)
        estimate = ForceEstimate(
            force=force,
            at=reading.region.at,
            condition=rank.condition,
            effective_rank=rank.effective,
            unknowns=rank.unknowns,
            residual=float(np.sqrt(missed @ missed / len(own))),
            noise=reading.noise,
            force_error=float(np.sqrt(variance)),
            refused=refused,
        )
        if refused is not None:
            return estimate
        pressures = pressures * (force / bearing)
        forces = pressures * areas
        pressed = pressures > 0
        mean = float(forces[pressed].sum() / areas[pressed].sum())
        return replace(estimate, taxels=taxels, forces=forces, peak=float(pressures.max()), mean=mean)


def share_inside(blur: BlurMatrix, areas: FloatArray, readings: FloatArray, pressures: FloatArray) -> float:
    """Return the share of a region's force that passes through its own areas at the taxels' depth.

    Negative pressures at the rim would distort it: then the non-negative solution is used.

    Args:
        blur: Blur of the region.
        areas: (n,) areas of its taxels [m²].
        readings: (n,) their readings [Pa].
        pressures: (n,) pressures that a solver found for them [Pa].
    """
    if pressures.min() < 0:
        pressures = nonnegative_least_squares(blur, readings, 0.0)
    force = float(areas @ pressures)
    return float(areas @ (blur.matrix @ pressures)) / force if force > 0 else 1.0


def nonnegative_least_squares(blur: BlurMatrix, readings: FloatArray, _noise: float) -> FloatArray:
    """Solve by non-negative least squares (Lawson and Hanson, 1974).

    The constraint regularizes the inverse of the blur. It is used on a region and its ring only: over a whole map it
    would turn noise into force, up to 80 % too much.

    Cost: 0.1 ms for 30 x 30.
    """
    from scipy.optimize import nnls  # 0.07 s to import, and few sessions need it

    return np.asarray(nnls(blur.matrix, readings)[0], dtype=np.float64)


_ROUNDS = 45
_ROUNDING = 1e-14


def tikhonov(blur: BlurMatrix, readings: FloatArray, noise: float) -> FloatArray:
    """Solve by least squares with a penalty on the difference from the readings.

    The weight is the largest for which the solution explains the readings to within their noise (Morozov, 1966). With
    exact readings it is 0, which is ordinary least squares. Where the noise exceeds the blur, the solution is the
    readings; a penalty on the norm of the solution would lower the total, by 20 to 30 % at 5 % noise. Pressures may be
    negative at the rim.

    Cost: 0.1 ms for 30 x 30.
    """
    beyond = readings - blur.matrix @ readings
    return readings + tikhonov_inverse(blur, beyond, noise) @ beyond


def tikhonov_inverse(blur: BlurMatrix, readings: FloatArray, noise: float) -> FloatArray:
    """Return the inverse B (n, m) for which x = B y minimises |A x - y|² + weight |x|² with |A x - y| = noise sqrt(m).

    B is 0 if x = 0 explains the readings to within their noise. The weight is 0 if no weight does.

    Args:
        blur: The blur A (m, n).
        readings: Readings y (m,) [Pa].
        noise: Standard deviation of a reading [Pa].
    """
    values = blur.values
    seen = blur.left.T @ readings
    size = float(readings @ readings)
    allowed = noise**2 * len(readings)
    if allowed >= size:
        return np.zeros(blur.matrix.T.shape)
    weight = _regularization_weight(values, seen, allowed - max(size - float(seen @ seen), 0.0))
    scale = np.divide(values, values**2 + weight, out=np.zeros_like(values), where=values > _ROUNDING * values[0])
    inverse: FloatArray = (blur.right.T * scale) @ blur.left.T
    return inverse


def _regularization_weight(values: FloatArray, seen: FloatArray, allowed: float) -> float:
    """Return the weight at which the squared residual is ``allowed``, by bisection of its logarithm; 0 if none is."""

    def missed(weight: float) -> float:
        return float(np.square(weight / (values**2 + weight) * seen).sum())

    low = 1e-20 * values[0] ** 2
    high = 1e8 * values[0] ** 2
    if allowed <= missed(low):
        return 0.0
    for _ in range(_ROUNDS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if missed(middle) < allowed else (low, middle)
    return high
