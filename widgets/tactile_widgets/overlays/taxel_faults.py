"""Faults of taxels (dead, stuck, saturated, blind) and the shapes of their marks.

A broken taxel, dead or stuck, is blind if its reading is not estimated from working neighbours, see
``tactile_maps.contacts.detection.filled_readings``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactile_maps.contacts.detection.filled_readings import BlindArea, TaxelFill
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.scene.effects import Effects
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import NO_IDENTITY, Skin, TaxelIdentity, number_ranges
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import ALIVE, DEAD, STUCK, SensorEffects

_ROUNDING = 1e-6
"""Relative distance from the limit within which a reading is saturated."""


class Fault(Enum):
    """Fault of a taxel; the value is shown after a count."""

    DEAD = "dead"
    STUCK = "stuck"
    SATURATED = "saturated"
    BLIND = "blind"


_CROSS = [[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]
_SQUARE = [[[-1, -1], [1, -1]], [[1, -1], [1, 1]], [[1, 1], [-1, 1]], [[-1, 1], [-1, -1]]]
_HATCH = [[[-1, 0.1], [-0.1, -0.8]], [[-1, 1], [1, -1]], [[0.1, 0.8], [1, -0.1]]]
_ANGLES = np.linspace(0, 2 * np.pi, 25)
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_CHORDS = [[[at - half, at + half], [at + half, at - half]] for at, half in ((-0.4, 0.917), (0.4, 0.917))]
"""Diagonals of a circle: distance from its centre, and half the length."""
STROKES: dict[Fault, FloatArray] = {
    Fault.DEAD: np.array(_CROSS, float),
    Fault.STUCK: np.array(_SQUARE, float),
    Fault.SATURATED: np.array(_HATCH, float),
    Fault.BLIND: np.concatenate([np.stack([_CIRCLE[:-1], _CIRCLE[1:]], axis=1), np.sqrt(0.5) * np.array(_CHORDS)]),
}
"""(s, 2, 2) lines of a mark from -1 to 1, y down. The mark of a blind taxel is a hatched circle."""


@dataclass(frozen=True, eq=False)
class TaxelFaults:
    """Faults of single taxels.

    Attributes:
        broken: (taxels,) 0 alive, 1 dead, 2 stuck.
        most: Maximum reading [Pa]; infinite without saturation.
        blind: Areas of broken taxels with too few working neighbours for an estimate.
        estimated: Whether the readings of the other broken taxels are estimated from their neighbours.
    """

    broken: NDArray[np.int8] = field(default_factory=lambda: np.zeros(0, np.int8))
    most: float = np.inf
    blind: tuple[BlindArea, ...] = ()
    estimated: bool = False

    @property
    def any(self) -> bool:
        """Whether any taxel can be faulty."""
        return bool(np.isfinite(self.most)) or bool(np.any(self.broken))

    def of(self, pressures: FloatArray) -> dict[Fault, BoolArray]:
        """(taxels,) for each fault, whether a taxel has it at these readings [Pa]; broken taxels are not saturated."""
        broken = self.broken if len(self.broken) == len(pressures) else np.zeros(len(pressures), np.int8)
        full = (pressures >= self.most * (1 - _ROUNDING)) & (broken == 0)
        blind = np.zeros(len(pressures), bool)
        if len(broken) == len(self.broken):
            for area in self.blind:
                blind[area.taxels] = True
        return {Fault.DEAD: broken == DEAD, Fault.STUCK: broken == STUCK, Fault.SATURATED: full, Fault.BLIND: blind}

    def words(self, faults: Mapping[Fault, BoolArray], taxel: int) -> str:
        """Describe the faults that ``of`` found for a taxel; empty without any."""
        fault = next((one for one, has in faults.items() if one is not Fault.BLIND and has[taxel]), None)
        if fault is None:
            return ""
        if fault is Fault.SATURATED or not self.estimated:
            return fault.value
        blind = faults[Fault.BLIND][taxel]
        return f"{fault.value}, {'blind: too few working neighbours' if blind else 'estimated from its neighbours'}"

    def with_areas(self, skin: Skin, *, estimated: bool) -> TaxelFaults:
        """Return these faults with their blind areas on ``skin``, if readings are ``estimated``."""
        broken = self.broken != ALIVE
        if not estimated or not broken.any():
            return replace(self, blind=(), estimated=False)
        return replace(self, blind=TaxelFill(skin, broken).blind, estimated=True)


NO_FAULTS = TaxelFaults()


def faults_of(prepared: PreparedScene, effects: Effects) -> TaxelFaults:
    """Return the faults that effects cause in a scene. Cost: 0.2 ms for 1000 taxels."""
    sensor = effects.sensor
    scene = prepared.scene
    if sensor.dead_taxels is None and sensor.saturation is None:
        return NO_FAULTS
    made = partial(SensorChain, prepared.skin, tick=scene.tick, seed=scene.seed)
    most = np.inf
    if sensor.saturation is not None and len(prepared.skin):
        limited = SensorEffects(saturation=sensor.saturation, quantisation=sensor.quantisation)
        most = float(made(limited).read(np.full(len(prepared.skin), sensor.saturation.at))[0])
    return TaxelFaults(made(SensorEffects(dead_taxels=sensor.dead_taxels)).dead, most)


FaultLegend = tuple[tuple[Fault, str], ...]
"""Fault and text of each mark."""


_NAMED_MODULES = 2
_BROKEN = (Fault.DEAD, Fault.STUCK)
"""Faults of a channel rather than of the touch, reported by module."""


def fault_legend(faults: Mapping[Fault, BoolArray], identity: TaxelIdentity = NO_IDENTITY) -> FaultLegend:
    """Describe each kind of fault; broken taxels with module and channel, if known.

    Args:
        faults: (taxels,) for each fault, whether a taxel has it.
        identity: Identity of all taxels.
    """
    lines = []
    for fault, those in faults.items():
        count = int(those.sum())
        if count:
            where = broken_channels(those, identity) if fault in _BROKEN else ""
            text = f"{count} {'taxel' if count == 1 else 'taxels'} {fault.value}"
            lines.append((fault, f"{text}: {where}" if where else text))
    return tuple(lines)


def broken_channels(those: BoolArray, identity: TaxelIdentity) -> str:
    """Format as ``module 14 (channels 0-2, 5), module 15 (channel 3), 4 more modules``; empty if no module is known."""
    if identity.modules is None:
        return ""
    taxels = np.flatnonzero(those)
    modules = identity.modules[taxels]
    different = np.unique(modules)
    parts = []
    for module in different[:_NAMED_MODULES].tolist():
        on_module = taxels[modules == module]
        if identity.channels is None:
            parts.append(f"module {module}")
        else:
            word = "channel" if len(on_module) == 1 else "channels"
            parts.append(f"module {module} ({word} {number_ranges(identity.channels[on_module], most=4)})")
    left = len(different) - _NAMED_MODULES
    if left > 0:
        parts.append(f"{left} more {'module' if left == 1 else 'modules'}")
    return ", ".join(parts)
