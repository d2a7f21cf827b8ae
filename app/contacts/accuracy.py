"""How well a contact region is known: standard uncertainties of its place and its force.

Errors are independent between taxels and small, so they propagate by the first derivatives (JCGM 100:2008, Guide to the
Expression of Uncertainty in Measurement, 5.1.2). With pressures p_i, areas a_i, forces f_i = p_i a_i, F = sum f_i,
shares w_i = f_i / F and distances d_i from the centre:

    force²  = noise² sum a_i² + gain² sum f_i²
    place²  = (noise / F)² sum a_i² d_i²     the sensor's noise
            + gain² sum w_i² d_i²            taxels that are more or less sensitive than they should be
            + 2 calibration² sum w_i²        taxels that do not sit where they are said to
            + sum w_i² a_i / 6               nobody knows where in a taxel's area it is pressed: a square of that area
                                             has variance a_i / 12 along each side

``place`` is radial, the root of the two variances' sum: 63 % of centres lie within it. The last line takes the force in
every area for one lump anywhere in it. That is what a contact smaller than a taxel does; a wide smooth one is known
two to eight times better. There is no line for pixels: the centre is taken from taxels, not from an image's pixels.

Not in it: what all taxels of a module do together (a patch put on askew), the cover's blur, and force that stays below
the threshold outside the ring.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.arrays import FloatArray, dot
from app.errors import MapError
from app.touch.sensor.effects import SensorEffects

_LARGEST = 1e6


@dataclass(frozen=True)
class ReadingErrors:
    """How far the readings of a skin may be off.

    Attributes:
        noise: Standard deviation of a reading [Pa].
        gain: Standard deviation of the taxels' gains around 1.
        calibration: Standard deviation of a taxel's place along one axis [m]. Simulated taxels are where they are said
            to be; on real skins 0.002 (NAO, by self-touch) to 0.007 (iCub, by force sensors) were published.

    Raises:
        MapError: One is no such number.
    """

    noise: float = 0.0
    gain: float = 0.0
    calibration: float = 0.0

    def __post_init__(self) -> None:
        for name in ("noise", "gain", "calibration"):
            value = getattr(self, name)
            if not 0 <= value < _LARGEST:
                raise MapError("readings cannot be that far off", place=name, value=value, remedy="Choose 0 or more")

    @classmethod
    def of_sensor(cls, sensor: SensorEffects) -> ReadingErrors:
        """What the simulated sensor's noise, converter and gains make of readings.

        A converter's step is off by anything up to half of it: its deviation is step / sqrt(12).
        """
        noise = sensor.noise.sd if sensor.noise else 0.0
        step = sensor.quantisation.step if sensor.quantisation else 0.0
        return cls(math.hypot(noise, step / math.sqrt(12)), sensor.gain_spread.sd if sensor.gain_spread else 0.0)


def uncertainty(
    errors: ReadingErrors, forces: FloatArray, areas: FloatArray, squared: FloatArray
) -> tuple[float, float]:
    """Standard uncertainties of place [m], radial, and force [N]; the formula stands above.

    Args:
        errors: Of the readings.
        forces: (k,) on the taxels [N], of sum > 0.
        areas: (k,) theirs [m²].
        squared: (k,) squared distances from the centre [m²].

    Cost: 5 µs.
    """
    total, own = float(forces.sum()), forces * forces
    noise, gain = errors.noise**2, errors.gain**2
    square, area = dot(forces, forces), dot(areas, areas)
    place = noise * dot(areas * areas, squared) + gain * dot(own, squared) + 2 * errors.calibration**2 * square
    place += dot(own, areas) / 6
    return math.sqrt(place) / total, math.sqrt(noise * area + gain * square)
