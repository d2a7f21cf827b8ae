"""A random hand: whatever it does in whatever order, frames mean something and can be repeated bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.control.command import ControlChanged, ControlSettings
from app.session.session import Session
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.touch import arm

fingers = st.builds(Finger, stiffness=st.floats(1, 2e3), max_force=st.floats(0, 50), speed=st.floats(0, 0.2))
places = st.integers(0, 299).map(lambda taxel: arm().skin.taxel_point(taxel))
ids = st.integers(0, 2)
changes = st.builds(
    ControlSettings, law=st.sampled_from(["impedance", "hold_force"]), stiffness=st.floats(0.5, 40),
    damping_ratio=st.floats(0.1, 3), force_goal=st.floats(0, 20), force_gain=st.floats(0, 0.05),
    integral_time=st.one_of(st.floats(0.05, 10), st.just(float("inf"))),
)  # fmt: skip
acts = st.one_of(
    st.builds(PokePressed, ids, places, fingers), st.builds(PokeMoved, ids, places), st.builds(PokeReleased, ids),
    st.builds(ControlChanged, changes), st.none(),
)  # fmt: skip


def play(script) -> list:
    session, frames = Session(replace(arm()), scripted=False), []
    for act in script:
        if act is not None:
            session.submit(act)
        frames += [session.tick() for _ in range(4)]
    return frames


@given(script=st.lists(acts, min_size=1, max_size=25))
@settings(max_examples=25, deadline=None)
def test_any_hand_gives_frames_that_mean_something_and_repeat(script):
    frames = play(script)
    areas = arm().skin.areas
    for frame in frames:
        for values in (frame.posture, frame.velocity, frame.pressures, frame.command.posture):
            assert np.isfinite(values).all()
        force = sum(poke.force for poke in frame.pokes)
        assert abs(frame.pressures @ areas - force) <= 1e-9 * max(force, 1e-6)
        assert all(0 <= poke.force <= 50 for poke in frame.pokes)
        assert len({region.id for region in frame.regions}) == len(frame.regions)
    for one, other in zip(frames, play(script), strict=True):
        assert np.array_equal(one.posture, other.posture)
        assert np.array_equal(one.pressures, other.pressures)
