"""What a session was told is kept in order and to the bit, and a stroke takes little."""

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
def test_it_reads_like_the_list_that_was_appended(told, start, end):
    log = InputLog(told)
    assert list(log) == told
    assert log == told
    assert len(log) == len(told)
    assert log[start:end] == told[start:end]
    assert list(reversed(log)) == told[::-1]
    for place in range(-len(told), len(told)):
        assert log[place] == told[place]
    with pytest.raises(IndexError, match="out of range"):
        log[len(told)]


def test_it_is_equal_to_what_says_the_same_and_to_nothing_else():
    told = [(1, PokeReleased(0)), (2, PokeMoved(0, SurfacePoint(0, 3, (0.25, 0.25, 0.5))))]
    assert InputLog(told) == InputLog(told)
    assert InputLog(told) != InputLog(told[:1])
    assert InputLog(told) != "told"
    assert "PokeReleased(id=0)" in repr(InputLog(told))


def test_a_stroke_of_an_hour_takes_megabytes():
    random = np.random.default_rng(0)
    log = InputLog()
    before = sys.getallocatedblocks()
    for tick in range(20_000):
        a, b = random.dirichlet([1, 1, 1])[:2].tolist()
        log.append(tick, PokeMoved(0, SurfacePoint(0, tick % 900, (a, b, 1 - a - b))))
    assert sys.getallocatedblocks() - before < 500
    held = sum(sys.getsizeof(part) for part in (log._ticks, log._moves, log._weights))
    assert held < 70 * len(log)
