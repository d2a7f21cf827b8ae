"""Skins with taxels in a row, large enough for statistics, and sensor effects."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels
from tactile_maps.tactile.sensors.sensor_effects import (
    STAGE_KEYS,
    AreaAveraging,
    AxisCrosstalk,
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Misorientation,
    Noise,
    OffsetDrift,
    Quantisation,
    Readout,
    Sampling,
    Saturation,
    SensorEffects,
    Threshold,
)
from tests.support.surfaces import sheet

ALL_ON = SensorEffects(
    AreaAveraging(),
    Misorientation(),
    AxisCrosstalk(),
    Crosstalk(),
    Hysteresis(),
    GainSpread(),
    OffsetDrift(),
    Noise(),
    Saturation(),
    Threshold(),
    Quantisation(),
    DeadTaxels(dead=0.05, stuck=0.05),
    Sampling(),
)
"""All effects, with values of a ROBOSKIN-like skin and a few stuck taxels."""
STAGES = STAGE_KEYS
"""Field names of the effects that are stages of the sensor chain."""


def only(effects: SensorEffects) -> dict[str, SensorEffects]:
    """Return one set of effects for each effect that is on."""
    return {name: SensorEffects(**{name: getattr(effects, name)}) for name in STAGES if getattr(effects, name)}


def row(count: int, *, areas=None, neighbours=None) -> Skin:
    """Return a patch of adjacent taxels in a row, 1 cm² each by default."""
    surface = sheet(1, 1)
    own = np.arange(count)
    areas = np.full(count, 1e-4) if areas is None else np.asarray(areas)
    points = np.tile(surface.point(0, (1.0, 0.0, 0.0)), (count, 1))
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    pairs = np.stack([own[:-1], own[1:]], axis=1) if neighbours is None else np.asarray(neighbours).reshape(-1, 2)
    weights = np.tile([1.0, 0.0, 0.0], (count, 1))
    quadrature = Quadrature(points, up, areas, own)
    return Skin((Patch("row", "link", surface, Taxels(points, up, 0 * own, weights, areas, pairs, quadrature)),))


def stage(spec, count: int = 1, *, tick: float = 0.01, seed: int = 0, skin: Skin | None = None):
    """Return the stage of one effect on a row of taxels."""
    return spec.stage(spec, Readout(skin or row(count), tick, seed))


def readings(of, pressures) -> np.ndarray:
    """Return the outputs of a stage or chain for a sequence of pressures (taxels,)."""
    return np.array([of.read(np.asarray(p, float)) for p in pressures])


def refuses(spec, field: str, *values) -> None:
    """Assert that a field rejects the values and non-numbers, and that the error names the field."""
    for value in (*values, float("nan"), float("inf"), float("-inf"), "0.1", None, True):
        with pytest.raises(SimulationError, match=rf"sensor\.\w+[.,].*{field}.*\d to \d"):
            spec(**{field: value})
