"""How contacts are read: from which pressure on a taxel counts as touched, and which way leads to a force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from app.contacts.accuracy import ReadingErrors
from app.contacts.estimators.names import ESTIMATORS, EstimatorName
from app.contacts.reader import THRESHOLD
from app.errors import SceneError
from app.toml.nearest import nearest

ABOVE_NOISE = 3.0
"""Standard deviations of a reading's noise that the threshold is at least."""
THRESHOLDS = (1.0, 1e6)
"""What a person may set, lowest and highest [Pa]."""
NOISIEST_SENSOR = 10.0
"""Of a force-torque sensor [N]."""


@dataclass(frozen=True)
class ReadingSettings:
    """What a scene, a person or a recording may say of how contacts are read.

    Attributes:
        estimator: The way from readings to a contact's force.
        threshold: A taxel is touched from here [Pa]; None for the usual one, or what stands out of the noise if that
            is more.
        wrench_noise: Standard deviation of each force that the force-torque sensor of ``lumped`` reports [N], and 2 cm
            times as much of each torque. 0 is a perfect one; an ATI Mini45 (SI-145-5) resolves 1/16 N and 1/752 N m.

    Raises:
        SceneError: Naming what is wrong, and what is allowed there.
    """

    estimator: EstimatorName = "area-sum"
    threshold: float | None = None
    wrench_noise: float = 0.0

    def __post_init__(self) -> None:
        if self.estimator not in ESTIMATORS:
            raise SceneError(
                "there is no such force estimator",
                place="contacts.estimator",
                value=self.estimator,
                remedy=nearest(str(self.estimator), ESTIMATORS),
            )
        if self.threshold is not None:
            self._check("threshold", *THRESHOLDS, unit="Pa")
        self._check("wrench_noise", 0.0, NOISIEST_SENSOR, unit="N")

    def _check(self, name: str, low: float, high: float, *, unit: str) -> None:
        value = getattr(self, name)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and low <= value <= high):  # NaN is in no range
            raise SceneError(
                "contacts cannot be read so",
                place=f"contacts.{name}",
                value=value,
                remedy=f"Choose {low:g} to {high:g} {unit}",
            )
        object.__setattr__(self, name, float(value))

    def threshold_for(self, errors: ReadingErrors) -> float:
        """The threshold in force [Pa] with readings that are so far off.

        What a person sets stands, whatever the noise. Theory has max(3 sigma, a tenth of the peak); the tenth is left
        out: it is there to cut one contact out of a whole image, and would let a firm contact erase a light one beside
        it. What it is good for, keeping the cover's blur out of the inversion, the region with its one ring does.
        """
        return self.threshold if self.threshold is not None else max(THRESHOLD, ABOVE_NOISE * errors.noise)


def reading_from(values: Mapping[str, object]) -> ReadingSettings:
    """Settings from a scene's table.

    Raises:
        SceneError: An unknown key, or a value that is none of those allowed.
    """
    known = tuple(field.name for field in fields(ReadingSettings))
    for key in values:
        if key not in known:
            raise SceneError(
                "there is no such setting of how contacts are read",
                place=f"contacts.{key}",
                value=key,
                remedy=nearest(key, known),
            )
    return ReadingSettings(**values)  # type: ignore[arg-type]
