"""One contact on the bar, under covers of different depth, as an estimator is given it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.contacts.estimators.estimate import Reading
from app.contacts.estimators.wrench import Wrench
from app.contacts.reader import ContactReader
from app.maps.build import build_map
from app.touch.layer import Layer
from app.touch.load import ball_load
from app.touch.models.half_space import HalfSpace
from app.touch.models.water_fill import WaterFill
from tests.touch import bar_skin

SKIN = bar_skin(400)
MAP = build_map(SKIN)
PITCH = float(np.sqrt(np.median(SKIN.areas)))
PLACE = np.array([0.2, 0.005, 0.02])
UP = np.array([0.0, 0.0, 1.0])


def reading(*, depth: float = 0.0, noise: float = 0.0, force: float = 10.0, wrench: Wrench | None = None) -> Reading:
    """A ball of 2 cm presses; a depth of 0 is a skin without a cover."""
    layer = Layer(depth=depth or 1e-3)
    felt = HalfSpace(SKIN, layer=layer) if depth else WaterFill(SKIN, stiffness=layer.foundation)
    pressures = felt.pressures([ball_load("bar", PLACE, UP, force, 0.02)])
    pressures = pressures + np.random.default_rng(0).normal(0, noise, len(pressures)) * (noise > 0)
    return Reading(ContactReader(MAP).read(pressures)[0], pressures, noise, wrench=wrench)


def without_region(given: Reading) -> Reading:
    """The same, of a region that only its ring is left of."""
    return replace(given, pressures=np.zeros(len(SKIN)))
