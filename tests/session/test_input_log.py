"""The log of inputs keeps order and values exactly, and moves take little memory."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tests.support.examples import examples

POINTS = st.builds(
    lambda patch, face, a, b: SurfacePoint(patch, face, (a, (1 - a) * b, 1 - a - (1 - a) * b)),
    st.integers(0, 3),
    st.integers(0, 10**6),
    st.floats(0, 1),
    st.floats(0, 1),
)
FINGERS = st.integers(-(2**70), 2**70)
INPUTS = st.one_of(
    st.builds(PokeMoved, FINGERS, POINTS),
    st.builds(PokePressed, FINGERS, POINTS),
    st.builds(PokeReleased, FINGERS),
    st.just(ControlChanged(ControlSettings())),
)


@given(st.lists(st.tuples(st.integers(0, 10**9), INPUTS)), st.integers(-12, 12), st.integers(-12, 12))
@examples(200)
def test_log_reads_like_the_list_of_its_inputs(inputs, start, end):
    log = InputLog(inputs)
    assert list(log) == inputs
    assert log == inputs
    assert log != [*inputs, None]
    assert len(log) == len(inputs)
    assert log[start:end] == inputs[start:end]
    assert list(reversed(log)) == inputs[::-1]
    for place in range(-len(inputs), len(inputs)):
        assert log[place] == inputs[place]
    with pytest.raises(IndexError, match="out of range"):
        log[len(inputs)]


@pytest.mark.long
def test_move_takes_less_than_70_bytes():
    random = np.random.default_rng(0)
    log = InputLog()
    before = sys.getallocatedblocks()
    for tick in range(20_000):
        a, b = random.dirichlet([1, 1, 1])[:2].tolist()
        log.append(tick, PokeMoved(0, SurfacePoint(0, tick % 900, (a, b, 1 - a - b))))
    assert sys.getallocatedblocks() - before < 500
    held = sum(sys.getsizeof(part) for part in (log._ticks, log._moves, log._weights))
    assert held < 70 * len(log)
