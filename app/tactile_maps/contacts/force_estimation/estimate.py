"""What a force estimator gets, what it answers and what it must be able to do; and the default one, pressure times
area.

Estimators are called by ``EstimatorName`` in scenes, recordings and commands. A ``ContactReading`` goes in, a
``ForceEstimate`` comes out, with the ``Rank`` that says how much of a distribution the readings tell. A ``Wrench`` is
the force and torque of a contact on a link, and how joint torques tell it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeAlias

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays, readonly, set_fields
from tactile_maps.core.codec import AnyFloat
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.skin.model.skin import Skin

EstimatorName: TypeAlias = str
"""One of ``ESTIMATORS``, or that of a plug-in."""
ESTIMATORS: tuple[EstimatorName, ...] = ("area-sum", "local-nnls", "tikhonov", "lumped")
"""The built-in ones; ``estimation.FORCE_ESTIMATORS`` knows all."""


@dataclass(frozen=True, eq=False)
class Wrench:
    """What acts on a link, in its frame and about its origin.

    Attributes:
        force: (3,) [N].
        torque: (3,) [N m].
        rank: How many of its six numbers are known; a sensor in the link tells all, few joints tell fewer.
        condition: How many times relative errors of what it was found from may have grown.
        force_noise: Standard deviation of each force [N].
        torque_noise: Standard deviation of each torque [N m].
    """

    force: FloatArray
    torque: FloatArray
    rank: int = 6
    condition: float = 1.0
    force_noise: float = 0.0
    torque_noise: float = 0.0

    def __post_init__(self) -> None:
        for name in ("force", "torque"):
            value = readonly(getattr(self, name))
            if value.shape != (3,) or not np.isfinite(value).all():
                raise MapError("a wrench's force and torque are three finite numbers each", value=value.tolist())
            set_fields(self, **{name: value})


_KNOWN = 1e-6
"""Singular values below this share of the largest tell nothing."""


def wrench_of_torques(configuration: Configuration, link: str, torques: FloatArray) -> Wrench:
    """The smallest wrench on ``link`` that the joints' ``torques`` (joints,) [N m, N] are due to: J' w = torques.

    Torques are those that contact alone causes: motors, gravity and inertia taken off. Lengths count in decimetres, so
    that forces and torques of touch have like weight. Cost: 60 µs.

    Raises:
        MapError: There is not one finite number for each joint.
        RobotError: There is no such link.
    """
    jacobian = _jacobian(configuration, link)
    torques = np.asarray(torques, dtype=np.float64)
    if torques.shape != jacobian.shape[1:] or not np.isfinite(torques).all():
        raise MapError(f"expected the torques of {jacobian.shape[1]} joints", value=torques.tolist())
    scale = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    left, values, right = np.linalg.svd((jacobian * scale[:, None]).T, full_matrices=False)
    known = values > _KNOWN * max(float(values.max(initial=0.0)), 1e-300)
    wrench = scale * (right[known].T @ ((left.T @ torques)[known] / values[known]))
    condition = float(values[known].max() / values[known].min()) if known.any() else float("inf")
    return Wrench(wrench[:3], wrench[3:], int(known.sum()), condition)


def _jacobian(configuration: Configuration, link: str) -> FloatArray:
    """(6, joints) velocity of the link's origin over angular velocity, link frame, per joint velocity."""
    turn = configuration.pose(link).rotation.T
    origin = turn @ configuration.jacobian(link, np.zeros(3))
    along_x = turn @ configuration.jacobian(link, np.array([1.0, 0.0, 0.0])) - origin  # omega x e_x = (0, wz, -wy)
    along_y = turn @ configuration.jacobian(link, np.array([0.0, 1.0, 0.0])) - origin  # omega x e_y = (-wz, 0, wx)
    return np.vstack([origin, along_y[2], -along_x[2], along_x[1]])


@dataclass(frozen=True, eq=False)
class ContactReading:
    """All that is known of one contact at one moment.

    Attributes:
        region: As the contact reader found it.
        pressures: (taxels,) of the whole skin [Pa].
        noise: Standard deviation of a reading [Pa]; 0 where readings are exact.
        gain: Standard deviation of the taxels' gains around 1.
        variances: (k,) variances of the region's readings [Pa²], independent; None to take those of noise and gain.
        wrench: At the region's link, for methods that do not use the skin's readings; None without such a sensor.
    """

    region: ContactRegion
    pressures: FloatArray
    noise: float = 0.0
    gain: float = 0.0
    variances: FloatArray | None = None
    wrench: Wrench | None = None

    def variances_of(self, own: FloatArray) -> FloatArray:
        """Variances (k,) of the region's readings ``own`` (k,) [Pa²]."""
        return self.noise**2 + np.square(self.gain * own) if self.variances is None else self.variances


class EstimateRefusal(Enum):
    """Why an estimate has no distribution or no place."""

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
class ForceEstimate:
    """An answer. Normal force only: shear is not observable.

    Attributes:
        force: Total normal force [N].
        at: Where it acts as far as the method can tell; None where it cannot, and ``refused`` says why.
        taxels: (k,) whose areas the distribution is over; empty where there is none.
        forces: (k,) on these areas [N]; their sum is ``force``.
        condition: Of the equations that were solved: how many times relative errors may grow.
        effective_rank: How many of the unknowns the readings tell apart above their noise.
        unknowns: How many there are.
        residual: Root mean square of what the answer leaves unexplained of the readings [Pa].
        noise: Standard deviation of a reading that was reckoned with [Pa].
        peak: Highest pressure of the distribution [Pa]; 0 without one.
        mean: Its mean pressure, where it presses [Pa].
        force_error: Standard uncertainty of ``force`` [N]; an estimator states what the readings' variances make of it.
        place_error: The same of ``at``, radial [m]; 0 where the region's own place is taken over.
        refused: Why there is no distribution or no place; None where nothing was refused.
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

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxels", dtype=np.int64)
        freeze_arrays(self, "forces")

    @property
    def misfit(self) -> float:
        """Residual over noise: about 1 is as good as can be, much more says that the model is wrong."""
        return self.residual / self.noise if self.noise > 0 else float("inf") if self.residual > 0 else 0.0


class ForceEstimator(Protocol):
    """A way from readings to force. Net shear is not observable from taxels that feel normal stress; none tells it."""

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """The contact's force.

        Raises:
            MapError: The reading lacks what this method needs.
        """
        ...


_ROUNDING = 1e-12


@dataclass(frozen=True)
class Rank:
    """Of a linear system, seen through noise.

    Attributes:
        condition: Largest over smallest singular value.
        effective: How many singular values lie above noise / rms(readings) times the largest: a contact that is spread
            evenly over all of them stands out of the noise in these, and what lies below comes out as noise.
        unknowns: How many there are.
    """

    condition: float
    effective: int
    unknowns: int

    @property
    def refusal(self) -> EstimateRefusal | None:
        """Why no distribution can be told; None where it can."""
        return EstimateRefusal.RANK if 2 * self.effective < self.unknowns else None


def numerical_rank(values: FloatArray, readings: FloatArray, noise: float, *, unknowns: int) -> Rank:
    """The rank of a system with singular ``values`` (s,), falling, for these ``readings`` (m,) [Pa] and ``noise``."""
    if not len(values) or values[0] <= 0:
        return Rank(float("inf"), 0, unknowns)
    strength = float(np.sqrt(np.mean(np.square(readings))))
    share = noise / strength if strength > 0 else float("inf")
    effective = int((values > max(share, _ROUNDING) * values[0]).sum())
    whole = len(values) >= unknowns and values[-1] > 0
    return Rank(float(values[0] / values[-1]) if whole else float("inf"), effective, unknowns)


class AreaSum:
    """Takes readings for what presses right above. Built once for a skin.

    Every taxel is its own equation, so nothing is ill-conditioned. A cover's blur moves force from taxel to taxel, but
    hardly out of the region and its ring: totals stay within a few percent. What is lost is the shape: peaks come out
    too low and too wide. Net shear is not observable.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        self._areas = skin.areas

    def estimate(self, reading: ContactReading) -> ForceEstimate:
        """The sum. Cost: 15 µs."""
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
