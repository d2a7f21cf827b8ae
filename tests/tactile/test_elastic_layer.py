"""The cover and its stiffness."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer


def test_default_cover_is_four_millimetres_of_soft_foam():
    assert ElasticLayer().foundation == pytest.approx(3e7)


def test_thicker_cover_is_softer_and_laterally_free_cover_is_as_stiff_as_a_rod():
    layer = ElasticLayer()
    assert replace(layer, thickness=2 * layer.thickness).foundation == pytest.approx(0.5 * layer.foundation)
    assert replace(layer, poisson=0.0).foundation == pytest.approx(layer.modulus / layer.thickness)
    assert replace(layer, poisson=0.45).foundation > 2 * layer.foundation, "what cannot yield sideways is stiff"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("poisson", 0.5),
        ("poisson", -0.1),
        ("modulus", 0.0),
        ("thickness", 0.0),
        ("stiffness", float("nan")),
        ("depth", 1.0),
        ("friction", -0.1),
        ("friction", float("inf")),
    ],
)
def test_invalid_cover_is_rejected_by_name(name, value):
    with pytest.raises(SimulationError, match=rf"layer\.{name}"):
        replace(ElasticLayer(), **{name: value})
