"""All models by name, built as a scene would."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.touch.layer import Layer
from app.touch.load import ball_load
from app.touch.models.table import MODELS
from app.touch.sensor.area_averaging import AreaAveraging
from app.touch.sensor.effects import SensorEffects
from tests.touch import bar_skin

SKIN = bar_skin()
LOAD = ball_load("bar", np.array([0.2, 0.0, 0.02]), np.array([0.0, 0, 1]), 5.0, 0.02)


def test_the_names_are_those_of_scenes():
    assert list(MODELS) == ["point", "water-fill", "punch", "half-space"]
    assert all(entry.name == name and entry.title and entry.tip.endswith(".") for name, entry in MODELS.items())


@pytest.mark.parametrize("name", MODELS)
def test_every_model_keeps_the_force_with_whole_cells(name):
    pressures = MODELS[name].build(SKIN, Layer(), SensorEffects()).pressures([LOAD])
    assert pressures.shape == (len(SKIN),)
    assert pressures @ SKIN.areas == pytest.approx(5.0, rel=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_pads_change_what_every_model_reads(name):
    cells = MODELS[name].build(SKIN, Layer(), SensorEffects())
    pads = MODELS[name].build(SKIN, Layer(), SensorEffects(area_averaging=AreaAveraging(0.004)))
    assert not np.allclose(cells.pressures([LOAD]), pads.pressures([LOAD]), rtol=0.01)


def test_a_softer_layer_spreads_the_force_farther():
    skin, felt = bar_skin(400), []
    for modulus in (1e6, 1e4):
        model = MODELS["water-fill"].build(skin, replace(Layer(), modulus=modulus), SensorEffects())
        felt.append(np.count_nonzero(model.pressures([LOAD])))
    assert felt[1] > 2 * felt[0] > 0
