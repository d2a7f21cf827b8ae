"""Whatever is set, asked for and poked, a whole session stays bounded and finite, and repeats itself bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.control.command import ControlChanged, ControlSettings
from app.control.reference import MAX_JOINT_SPEED
from app.control.settings_check import CHOICES, RANGES
from app.session.session import Session
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from app.touch.sensor.sampling import Sampling
from tests.touch import arm

PREPARED = arm()
HAND = 8.0
"""No finger pushes harder [N]."""
NUMBERS = {name: st.floats(low, min(high, 1e6)) for name, (low, high) in RANGES.items()}
BOUNDS = PREPARED.map.bounds
POINTS = st.tuples(*(st.floats(float(low), float(high)) for low, high in BOUNDS.T))
SETTINGS = st.builds(
    ControlSettings,
    **NUMBERS,
    **{name: st.sampled_from(known) for name, known in CHOICES.items()},
    path=st.lists(POINTS, max_size=4).map(tuple),
)
SENSORS = st.builds(
    SensorEffects,
    noise=st.none() | st.builds(Noise, sd=st.floats(0.0, 500.0)),
    sampling=st.none() | st.builds(Sampling, rate=st.floats(5.0, 500.0), delay=st.floats(0.0, 0.2)),
)
TAXELS = st.integers(0, len(PREPARED.skin) - 1)
ACTS = st.lists(
    st.one_of(
        st.builds(lambda k, taxel, v: (k, taxel, v), st.integers(1, 2), TAXELS, st.floats(0.005, 0.05)),
        st.tuples(st.integers(1, 2)),
        SETTINGS,
    ),
    min_size=1,
    max_size=4,
)


def start(first: ControlSettings, sensor: SensorEffects, seed: int) -> Session:
    prepared = replace(PREPARED, scene=replace(PREPARED.scene, seed=seed))
    effects = replace(prepared.scene.effects, sensor=sensor)
    return Session(prepared, scripted=False, settings=first, effects=effects)


def act(session: Session, what: object, down: dict[int, bool]) -> None:
    """A person changes settings, presses or moves a finger, or lifts it."""
    if isinstance(what, ControlSettings):
        session.submit(ControlChanged(what))
        return
    finger, *where = what
    if where and not down.get(finger):
        session.submit(PokePressed(finger, PREPARED.skin.taxel_point(where[0]), Finger(speed=where[1], max_force=HAND)))
    elif where:
        session.submit(PokeMoved(finger, PREPARED.skin.taxel_point(where[0])))
    elif down.get(finger):
        session.submit(PokeReleased(finger))
    down[finger] = bool(where)


def run(first, sensor, seed, acts):
    session, down, frames = start(first, sensor, seed), {}, []
    for what in acts:
        act(session, what, down)
        frames += [session.tick() for _ in range(25)]
    return session, frames


@settings(max_examples=40, deadline=None)
@given(SETTINGS, SENSORS, st.integers(0, 9), ACTS)
def test_a_session_is_finite_bounded_and_the_same_again(first, sensor, seed, acts):
    session, frames = run(first, sensor, seed, acts)
    _, again = run(first, sensor, seed, acts)
    fingers = 2 * HAND
    for frame, same in zip(frames, again, strict=True):
        assert np.isfinite(frame.posture).all()
        assert np.isfinite(frame.command.torque_at(frame.posture, frame.velocity)).all()
        assert np.abs(frame.velocity).max() < 4 * MAX_JOINT_SPEED
        assert all(frame.why_limited)
        assert np.array_equal(frame.posture, same.posture)
        assert frame.why_limited == same.why_limited
        assert sum(poke.force for poke in frame.pokes) <= fingers + 1e-6, "hands are all that presses"
    assert session.failure is None
