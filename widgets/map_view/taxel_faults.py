"""Which taxels do not read what touches them: dead, stuck or saturated; and the strokes that mark each. No Qt."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from functools import partial

import numpy as np
from numpy.typing import NDArray

from app.arrays import BoolArray, FloatArray
from app.scene.effects import Effects
from app.session.prepare import Prepared
from app.touch.sensor.chain import SensorChain
from app.touch.sensor.effects import SensorEffects

_ROUNDING = 1e-6
"""A reading this share below the limit is at it."""


class Fault(Enum):
    """What is wrong with a taxel; the value is how it is called after a number."""

    DEAD = "dead"
    STUCK = "stuck"
    SATURATED = "saturated"


_CROSS = [[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]
_SQUARE = [[[-1, -1], [1, -1]], [[1, -1], [1, 1]], [[1, 1], [-1, 1]], [[-1, 1], [-1, -1]]]
_HATCH = [[[-1, 0.1], [-0.1, -0.8]], [[-1, 1], [1, -1]], [[0.1, 0.8], [1, -0.1]]]
STROKES: dict[Fault, FloatArray] = {
    Fault.DEAD: np.array(_CROSS, float),
    Fault.STUCK: np.array(_SQUARE, float),
    Fault.SATURATED: np.array(_HATCH, float),
}
"""(s, 2, 2) lines of a mark that reaches from -1 to 1; y runs downwards."""


@dataclass(frozen=True, eq=False)
class TaxelFaults:
    """What the sensor's effects do to single taxels.

    Attributes:
        broken: (taxels,) 0 alive, 1 dead, 2 stuck.
        most: The highest reading there is [Pa]; infinite without saturation.
    """

    broken: NDArray[np.int8] = field(default_factory=lambda: np.zeros(0, np.int8))
    most: float = np.inf

    @property
    def any(self) -> bool:
        """Whether there may be any at all."""
        return bool(np.isfinite(self.most)) or bool(np.any(self.broken))

    def of(self, pressures: FloatArray) -> dict[Fault, BoolArray]:
        """(taxels,) which have which fault at these readings [Pa]; what is broken is not called saturated."""
        broken = self.broken if len(self.broken) == len(pressures) else np.zeros(len(pressures), np.int8)
        full = (pressures >= self.most * (1 - _ROUNDING)) & (broken == 0)
        return {Fault.DEAD: broken == 1, Fault.STUCK: broken == 2, Fault.SATURATED: full}


NO_FAULTS = TaxelFaults()


def faults_of(prepared: Prepared, effects: Effects) -> TaxelFaults:
    """What these effects do to the taxels of a scene. Cost: 0.2 ms for 1000 taxels."""
    sensor, scene = effects.sensor, prepared.scene
    if sensor.dead_taxels is None and sensor.saturation is None:
        return NO_FAULTS
    made = partial(SensorChain, prepared.skin, tick=scene.tick, seed=scene.seed)
    most = np.inf
    if sensor.saturation is not None and len(prepared.skin):
        limited = SensorEffects(saturation=sensor.saturation, quantisation=sensor.quantisation)
        most = float(made(limited).read(np.full(len(prepared.skin), sensor.saturation.at))[0])
    return TaxelFaults(made(SensorEffects(dead_taxels=sensor.dead_taxels)).dead, most)
