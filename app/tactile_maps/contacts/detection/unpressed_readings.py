"""Readings of taxels that nothing presses: which readings next to a contact count as pressure.

Taxels beyond the ring of a contact are part of it if they are pressed and connected to it, see ``ContactDetector``. An
unpressed taxel may read a rest, to which three standard deviations of noise are added:

- Noise, and offsets that drift since a known time: sqrt(sd² + walk² t) for the offsets.
- Noise that is not stated is estimated from the quiet taxels of the same frame, those of no contact. The differences
  of neighbours have sqrt(2) times its standard deviation, and few of them are at the rim of a pressed area. Their
  median is 0.954 standard deviations of the noise (0.6745 sqrt(2)). The offset around which quiet taxels scatter is
  their 16 % quantile plus one standard deviation, so that up to five of six may be pressed. An offset of all taxels is
  therefore not pressure; neither is a body on nearly all of them.
- Creep of a sensor with hysteresis: a taxel that was pressed still reads a share of the delayed part q. With the
  reading y = (1 - share) p + share q and dq/dt = (p - q) / tau, q never exceeds the bound b that is the larger of y
  and of y + (b - y) exp(-dt / tau) from one reading to the next: p <= y where y <= q. The rest after a release is
  thus at most share b.

The row of taxels around a contact may be pressed although no reading exceeds its own noise. Its force is stated where
it exceeds two standard deviations of its noise; the readings are not added to the contact, because a common offset
would add row after row.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.error_budget import LeftOut
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, dot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.sensors.sensor_effects import Hysteresis

_LEAST = 1e-5
"""Share of the threshold below which a reading never counts, whatever the noise."""
_DEVIATIONS = 3.0
"""Standard deviations of the noise by which a reading exceeds the rest."""
_ROW_DEVIATIONS = 2.0
"""The same for the force on a row of taxels."""
_MEDIAN_DIFFERENCE = 0.954
"""Median difference of two readings per standard deviation of their noise, see the module."""
_LOW = 0.16
"""Share of a normal distribution below its mean less a standard deviation."""


class UnpressedReadings(NamedTuple):
    """Readings of taxels that nothing presses.

    Attributes:
        rest: (taxels,) largest reading without noise [Pa]: an offset and creep.
        noise: (taxels,) three standard deviations of noise and drift [Pa], or the threshold of the sensor.
        deviation: Standard deviation of noise that is not stated [Pa]; None where it is stated.
        offset: Offset of all taxels where noise is not stated [Pa].
    """

    rest: FloatArray
    noise: FloatArray
    deviation: float | None = None
    offset: float = 0.0

    def exceeded(self, pressures: FloatArray) -> BoolArray:
        """Return whether each reading (taxels,) [Pa] is pressure."""
        return np.asarray(pressures >= self.rest + self.noise)

    def row_force(self, pressures: FloatArray, taxels: IntArray, areas: FloatArray) -> LeftOut:
        """Return the force on a row of ``taxels`` (k,) with ``areas`` (k,) [m²]."""
        limits = self.noise.take(taxels) * areas
        force = dot(pressures.take(taxels) - self.rest.take(taxels), areas)
        noise = math.sqrt(dot(limits, limits)) / _DEVIATIONS
        seen = force if force > _ROW_DEVIATIONS * noise else 0.0
        level = float(self.noise.take(taxels).max(initial=0.0))
        return LeftOut(float(limits.sum()), seen, level, self.offset)


class UnpressedTaxels:
    """Finds the readings of unpressed taxels; see the module. Mutable: it follows the creep.

    Args:
        skin: The skin.

    Cost: 5 µs; 15 µs for 1000 taxels with hysteresis, 60 µs with unknown noise.
    """

    def __init__(self, skin: Skin) -> None:
        self._pairs = skin.neighbours
        self._bound = np.zeros(len(skin))
        self._time = 0.0

    def reset(self) -> None:
        """Forget earlier readings."""
        self._bound = np.zeros(len(self._bound))

    def observe(self, hysteresis: Hysteresis | None, pressures: FloatArray, time: float) -> None:
        """Follow the readings ``pressures`` (taxels,) [Pa] at ``time`` [s]."""
        if hysteresis is None:
            return
        decay = math.exp(-max(time - self._time, 0.0) / hysteresis.seconds)
        self._time = time
        self._bound = pressures + np.maximum(self._bound - pressures, 0.0) * decay

    def readings(
        self, errors: SensorUncertainty, thresholds: FloatArray, pressures: FloatArray, contacts: BoolArray
    ) -> UnpressedReadings:
        """Return the readings of unpressed taxels.

        Args:
            errors: Uncertainty of the readings.
            thresholds: (taxels,) pressure from which a taxel is touched [Pa].
            pressures: (taxels,) finite readings [Pa].
            contacts: (taxels,) taxels of contacts and their rings.
        """
        effects = errors.effects
        least = _LEAST * thresholds
        if effects.threshold is not None:
            least = np.maximum(least, effects.threshold.at)
        share = effects.hysteresis.share if effects.hysteresis else 0.0
        rest = share * self._bound
        if errors.unknown:
            deviation, offset = self._of_quiet_taxels(pressures, contacts)
            return UnpressedReadings(rest + offset, np.maximum(least, _DEVIATIONS * deviation), deviation, offset)
        noise = np.asarray(errors.noise if errors.taxels is None else errors.taxels.limits(_DEVIATIONS) / _DEVIATIONS)
        if effects.offset_drift is not None:
            drift = effects.offset_drift
            noise = np.hypot(noise, math.sqrt(drift.sd**2 + drift.walk**2 * errors.elapsed))
        return UnpressedReadings(rest, np.maximum(least, _DEVIATIONS * noise))

    def _of_quiet_taxels(self, pressures: FloatArray, contacts: BoolArray) -> tuple[float, float]:
        """Return standard deviation and offset [Pa] of the readings of taxels of no contact."""
        first, second = self._pairs[~contacts[self._pairs].any(axis=1)].T
        if not len(first):
            return 0.0, 0.0
        deviation = float(np.median(np.abs(pressures[first] - pressures[second]))) / _MEDIAN_DIFFERENCE
        offset = float(np.quantile(pressures[~contacts], _LOW)) + deviation
        return deviation, max(offset, 0.0)
