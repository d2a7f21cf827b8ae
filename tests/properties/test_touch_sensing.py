"""Whatever presses the skin, force is conserved and every number means something."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.simulation.loads import Load
from app.simulation.sensing import WaterFill, fill
from tests.touch import arm

FELT = WaterFill(arm().skin)
forces = st.one_of(st.just(0.0), st.just(5e-324), st.floats(1e-300, 1e-6), st.floats(1e-6, 1e3), st.floats(1e3, 1e290))


@st.composite
def loads(draw, forces=forces):
    """A finger of any size and force anywhere on the skin."""
    skin = arm().skin
    at = skin.taxel_point(draw(st.integers(0, len(skin) - 1)))
    return Load(skin.link(at), skin.position(at), skin.normal(at), draw(forces), draw(st.floats(1e-4, 0.1)))


@given(load=loads())
@settings(max_examples=200, deadline=None)
def test_the_sum_of_pressure_times_area_is_the_force(load):
    pressures = FELT.pressures([load])
    assert np.isfinite(pressures).all()
    assert (pressures >= 0).all()
    if load.force > 1e-290:  # below, rounding is no longer relative
        assert abs(pressures @ arm().skin.areas / load.force - 1) < 1e-12


@given(several=st.lists(loads(st.floats(1e-3, 1e3)), min_size=1, max_size=6))
@settings(max_examples=60, deadline=None)
def test_several_loads_add_up(several):
    together = FELT.pressures(several) @ arm().skin.areas
    assert abs(together / sum(load.force for load in several) - 1) < 1e-12


@given(
    floors=st.lists(st.tuples(st.floats(0, 0.1), st.floats(1e-9, 1e-3)), min_size=1, max_size=60),
    volume=st.floats(1e-12, 1.0),
)
@settings(max_examples=300, deadline=None)
def test_the_level_of_water_is_that_of_bisection(floors, volume):
    gaps, areas = np.array(floors).T
    low, high = gaps.min(), gaps.max() + volume / areas.min() + 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if areas @ np.maximum(middle - gaps, 0) < volume else (low, middle)
    level = fill(gaps, areas, volume)
    assert abs(level - high) <= 1e-9 * max(abs(high), 1.0)
    assert abs(areas @ np.maximum(level - gaps, 0) - volume) <= 1e-9 * max(volume, areas.sum())
