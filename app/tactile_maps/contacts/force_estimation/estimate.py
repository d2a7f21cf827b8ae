"""Protocol, input and output of force estimators, and the default estimator: pressure times area.

Scenes, recordings and commands select estimators by ``EstimatorName``. The input is a ``ContactReading``, the output a
``ForceEstimate``. ``Rank`` is the number of unknowns that the readings determine. A ``Wrench`` is the force and torque
on a link.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeAlias

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, readonly, set_fields
from tactile_maps.core.codec import AnyFloat
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.skin.model.skin import Skin

EstimatorName: TypeAlias = str
"""Name of a built-in estimator (``ESTIMATORS``) or of a plug-in."""
ESTIMATORS: tuple[EstimatorName, ...] = ("area-sum", "local-nnls", "tikhonov", "lumped")
"""Built-in estimators; ``estimation.FORCE_ESTIMATORS`` also contains those of plug-ins."""


@dataclass(frozen=True, eq=False)
class Wrench:
    """Force and torque on a link, in its frame and about its origin.

    Attributes:
        force: (3,) force [N].
        torque: (3,) torque [N m].
        force_noise: Standard deviation of each force [N].
        torque_noise: Standard deviation of each torque [N m].
    """

    force: FloatArray
    torque: FloatArray
    force_noise: float = 0.0
    torque_noise: float = 0.0

    def __post_init__(self) -> None:
        for name in ("force", "torque"):
            value = readonly(getattr(self, name))
            if value.shape != (3,) or not np.isfinite(value).all():
                raise MapError("a wrench's force and torque are three finite numbers each", value=value.tolist())
            set_fields(self, **{name: value})


@dataclass(frozen=True, eq=False)
class ContactReading:
    """Data of one contact at one instant.

    Attributes:
        region: The region found by the detector.
        pressures: (taxels,) readings of the whole skin [Pa]; of ring taxels between several contacts the share of
            this one.
        noise: Standard deviation of a reading [Pa]; 0 for exact readings.
        gain: Standard deviation of the taxels' gains around 1.
        variances: (k,) variances of the region's readings [Pa²], independent; None computes them from noise and gain.
        wrench: Wrench on the region's link, for methods that do not use the skin; None without such a sensor.
    """

    region: ContactRegion
    pressures: FloatArray
    noise: float = 0.0
    gain: float = 0.0
    variances: FloatArray | None = None
    wrench: Wrench | None = None

    def variances_of(self, own: FloatArray) -> FloatArray:
        """Return the variances (k,) of the region's readings ``own`` (k,) [Pa²]."""
        return self.noise**2 + np.square(self.gain * own) if self.variances is None else self.variances


class EstimateRefusal(Enum):
    """Reason for an estimate without distribution or place."""

    RANK = "rank"
    """The effective rank is below half of the unknowns: the cover is too deep or the noise too large."""
    NO_FORCE = "no-force"
    WRENCH_RANK = "wrench-rank"
    """Too few of the six numbers of force and torque are known."""
    OFF_SKIN = "off-skin"
    """The line of action misses the skin of the link: several contacts, or a torsional moment."""
    PULL = "pull"
    """The estimated force would pull."""


@dataclass(frozen=True, eq=False)
class ForceEstimate(ArrayFields):
    """Result of an estimator. It is the normal force only: shear is not observable.

    Attributes:
        force: Total normal force [N].
        at: Place of the force; None if the method cannot determine it, for the reason in ``refused``.
        taxels: (k,) taxels of the distribution; empty without one.
        forces: (k,) forces on their areas [N]; the sum is ``force``.
        condition: Condition number of the equations: how many times relative errors may grow.
        effective_rank: Number of unknowns that the readings determine above their noise.
        unknowns: Number of unknowns.
        residual: Root mean square of the unexplained part of the readings [Pa].
        noise: Assumed standard deviation of a reading [Pa].
        peak: Highest pressure of the distribution [Pa]; 0 without one.
        mean: Mean pressure of its pressed taxels [Pa].
        force_error: Standard uncertainty of ``force`` [N], propagated from the variances of the readings.
        place_error: Standard uncertainty of ``at``, radial [m]; 0 if the place is that of the region.
        refused: Reason for a missing distribution or place; None if nothing is missing.
    """

    force: float
    at: SurfacePoint | None
    taxels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    forces: FloatArray = field(default_factory=lambda: np.zeros(0))
    condition: AnyFloat = 1.0
    effective_rank: int = 0
    unknowns: int = 0
    residual: float = 0.0
    noise: float = 0.0
    peak: float = 0.0
    mean: float = 0.0
    force_error: float = 0.0
    place_error: float = 0.0
    refused: EstimateRefusal | None = None

    @property
    def misfit(self) -> float:
        """Residual over noise: about 1 is the best possible, a much larger value means that the model is wrong."""
        return self.residual / self.noise if self.noise > 0 else float("inf") if self.residual > 0 else 0.0


class ForceEstimator(Protocol):
    """Estimator of force from readings. Net shear is not observable from taxels that measure normal stress."""

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """Estimate the force of a contact.

        Raises:
            MapError: The reading lacks what this method needs.
        """
        ...


_ROUNDING = 1e-12


@dataclass(frozen=True)
class Rank:
    """Numerical rank of a linear system with noise.

    Attributes:
        condition: Largest over smallest singular value.
        effective: Number of singular values above noise / rms(readings) times the largest. A contact that is spread
            evenly over all of them exceeds the noise in these; the others contribute only noise.
        unknowns: Number of unknowns.
    """

    condition: float
    effective: int
    unknowns: int

    @property
    def refusal(self) -> EstimateRefusal | None:
        """Reason for a missing distribution; None if it is determined."""
        return EstimateRefusal.RANK if 2 * self.effective < self.unknowns else None


def numerical_rank(values: FloatArray, readings: FloatArray, noise: float, *, unknowns: int) -> Rank:
    """Return the rank of a system with decreasing singular ``values`` (s,) for ``readings`` (m,) and ``noise`` [Pa]."""
    if not len(values) or values[0] <= 0:
        return Rank(float("inf"), 0, unknowns)
    strength = float(np.sqrt(np.mean(np.square(readings))))
    share = noise / strength if strength > 0 else float("inf")
    effective = int((values > max(share, _ROUNDING) * values[0]).sum())
    whole = len(values) >= unknowns and values[-1] > 0
    return Rank(float(values[0] / values[-1]) if whole else float("inf"), effective, unknowns)


class AreaSum:
    """Sum of pressure times area: each reading is taken as the pressure above its taxel. Built once for a skin.

    The sum is well-conditioned. The cover's blur moves force between taxels, but hardly out of the region and its ring,
    so that totals are within a few percent. The shape is lost: peaks are too low and too wide. Net shear is not
    observable.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        self._areas = skin.areas

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """Return the sum. Cost: 15 µs."""
        region = reading.region
        own = reading.pressures.take(region.taxels)
        areas = self._areas.take(region.taxels)
        forces = own * areas
        rank = numerical_rank(np.ones(len(own)), own, reading.noise, unknowns=len(own))
        variance = float(reading.variances_of(own) @ np.square(areas))
        return ForceEstimate(
            force=float(forces.sum()),
            at=region.at,
            taxels=region.taxels,
            forces=forces,
            condition=rank.condition,
            effective_rank=rank.effective,
            unknowns=rank.unknowns,
            noise=reading.noise,
            force_error=math.sqrt(variance),
        )
