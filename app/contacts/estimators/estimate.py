"""What a force estimator gets, what it answers, and what it must be able to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.contacts.estimators.wrench import Wrench
from app.contacts.region import ContactRegion
from app.geometry.surface_point import SurfacePoint


@dataclass(frozen=True, eq=False)
class Reading:
    """All that is known of one contact at one moment.

    Attributes:
        region: As the contact reader found it.
        pressures: (taxels,) of the whole skin [Pa].
        noise: Standard deviation of a reading [Pa]; 0 where readings are exact.
        gain: Standard deviation of the taxels' gains around 1.
        wrench: At the region's link, for methods that do not use the skin's readings; None without such a sensor.
    """

    region: ContactRegion
    pressures: FloatArray
    noise: float = 0.0
    gain: float = 0.0
    wrench: Wrench | None = None


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
        force_error: Standard uncertainty of ``force`` [N], from the sensor alone.
        place_error: The same of ``at``, radial [m]; 0 where the region's own place is taken over.
        refused: Why there is no distribution or no place, in words; empty where nothing was refused.
    """

    force: float
    at: SurfacePoint | None
    taxels: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    forces: FloatArray = field(default_factory=lambda: np.zeros(0))
    condition: float = 1.0
    effective_rank: int = 0
    unknowns: int = 0
    residual: float = 0.0
    noise: float = 0.0
    peak: float = 0.0
    mean: float = 0.0
    force_error: float = 0.0
    place_error: float = 0.0
    refused: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "taxels", readonly(self.taxels, np.int64))
        object.__setattr__(self, "forces", readonly(self.forces))

    @property
    def misfit(self) -> float:
        """Residual over noise: about 1 is as good as can be, much more says that the model is wrong."""
        return self.residual / self.noise if self.noise > 0 else float("inf") if self.residual > 0 else 0.0


class ForceEstimator(Protocol):
    """A way from readings to force. Net shear is not observable from taxels that feel normal stress; none tells it."""

    def estimate(self, reading: Reading) -> ForceEstimate:
        """The contact's force.

        Raises:
            MapError: The reading lacks what this method needs.
        """
        ...
