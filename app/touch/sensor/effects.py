"""Which effects of the sensor are on, and how strong each is."""

from __future__ import annotations

from dataclasses import dataclass

from app.touch.sensor.area_averaging import AreaAveraging
from app.touch.sensor.crosstalk import Crosstalk
from app.touch.sensor.dead_taxels import DeadTaxels
from app.touch.sensor.gain_spread import GainSpread
from app.touch.sensor.hysteresis import Hysteresis
from app.touch.sensor.noise import Noise
from app.touch.sensor.offset_drift import OffsetDrift
from app.touch.sensor.quantisation import Quantisation
from app.touch.sensor.sampling import Sampling
from app.touch.sensor.saturation import Saturation
from app.touch.sensor.threshold import Threshold


@dataclass(frozen=True)
class SensorEffects:
    """An option for each effect, or None where it is off. The fields stand in the order of the signal."""

    area_averaging: AreaAveraging | None = None
    crosstalk: Crosstalk | None = None
    hysteresis: Hysteresis | None = None
    gain_spread: GainSpread | None = None
    offset_drift: OffsetDrift | None = None
    noise: Noise | None = None
    saturation: Saturation | None = None
    threshold: Threshold | None = None
    quantisation: Quantisation | None = None
    dead_taxels: DeadTaxels | None = None
    sampling: Sampling | None = None
