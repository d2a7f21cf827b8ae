"""Readings of a contact on the bar under covers of different depth, as an estimator receives them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.force_estimation.estimate import ContactReading, Wrench
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import bar_map, bar_skin

SKIN = bar_skin(400)
MAP = bar_map(400)
PITCH = float(np.sqrt(np.median(SKIN.areas)))
PLACE = np.array([0.2, 0.005, 0.02])
UP = np.array([0.0, 0.0, 1.0])


def reading(
    *, depth: float = 0.0, noise: float = 0.0, force: float = 10.0, wrench: Wrench | None = None
) -> ContactReading:
    """A ball of 2 cm presses; a depth of 0 is a skin without a cover."""
    layer = ElasticLayer(depth=depth or 1e-3)
    felt = HalfSpaceModel(SKIN, layer=layer) if depth else WaterFillModel(SKIN, layer=layer)
    pressures = felt.pressures([sphere_load("bar", PLACE, UP, force, 0.02)])
    pressures = pressures + np.random.default_rng(0).normal(0, noise, len(pressures)) * (noise > 0)
    detector = ContactDetector(MAP, errors=SensorUncertainty(noise=noise))
    return ContactReading(detector.read(pressures)[0], pressures, noise, wrench=wrench)


def without_region(given: ContactReading) -> ContactReading:
    """The same, of a region that only its ring is left of."""
    return replace(given, pressures=np.zeros(len(SKIN)))
