"""All models by name, built as a scene would."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.sensors.sensor_effects import AreaAveraging, SensorEffects
from tests.support.touch import bar_skin

SKIN = bar_skin()
LOAD = sphere_load("bar", np.array([0.2, 0.0, 0.02]), np.array([0.0, 0, 1]), 5.0, 0.02)


def test_model_names_match_those_of_scenes():
    assert list(CONTACT_MODELS) == ["point", "water-fill", "punch", "half-space"]
    assert all(entry.name == name and entry.title and entry.tip.endswith(".") for name, entry in CONTACT_MODELS.items())


@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_every_model_keeps_the_force_with_whole_cells(name):
    pressures = CONTACT_MODELS[name].build(SKIN, ElasticLayer(), SensorEffects()).pressures([LOAD])
    assert pressures.shape == (len(SKIN),)
    assert pressures @ SKIN.areas == pytest.approx(5.0, rel=1e-9)


@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_pads_change_the_readings_of_every_model(name):
    cells = CONTACT_MODELS[name].build(SKIN, ElasticLayer(), SensorEffects())
    pads = CONTACT_MODELS[name].build(SKIN, ElasticLayer(), SensorEffects(area_averaging=AreaAveraging(0.004)))
    assert not np.allclose(cells.pressures([LOAD]), pads.pressures([LOAD]), rtol=0.01)
