"""Random settings and readings: commands are finite and bounded, and a session repeats itself bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.motion.command import CHOICES, RANGES, ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, MAX_LEAD
from tactile_maps.control.motion.observation import Observation
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Noise, Sampling, SensorEffects
from tests.control.contacts import TICK, touch_on
from tests.support.examples import examples
from tests.support.touch import arm

pytestmark = pytest.mark.long

PREPARED = arm()
NUMBERS = {name: st.floats(low, min(high, 1e6)) for name, (low, high) in RANGES.items()}
PATHS = st.lists(st.tuples(st.floats(-0.5, 1.5), st.floats(-0.5, 1.5)), max_size=4).map(tuple)
SETTINGS = st.builds(
    ControlSettings, **NUMBERS, **{name: st.sampled_from(known) for name, known in CHOICES.items()}, path=PATHS
)
CONTACT = st.tuples(st.integers(0, len(PREPARED.skin) - 1), st.floats(0.0, 300.0) | st.just(float("nan")))
TICKS = st.lists(st.lists(CONTACT, max_size=3), min_size=1, max_size=12)


def run(first, second, ticks):
    controller = ControllerManager(PREPARED.robot, PREPARED.map, first)
    posture = PREPARED.robot.home
    velocity = np.zeros(7)
    commands = []
    for tick, contacts in enumerate(ticks):
        regions = tuple(touch_on(PREPARED.map, taxel, force, id_=k + 1) for k, (taxel, force) in enumerate(contacts))
        command = controller.command(Observation(posture, velocity, regions, TICK))
        commands.append((posture, command))
        posture = posture + 0.5 * (command.posture - posture)
        if tick == len(ticks) // 2:
            controller.settings = second
    return commands, controller.why_limited


@examples(150)
@given(SETTINGS, SETTINGS, TICKS)
def test_commands_are_finite_bounded_and_deterministic(first, second, ticks):
    commands, why = run(first, second, ticks)
    again, _ = run(first, second, ticks)
    for (posture, command), (_, same) in zip(commands, again, strict=True):
        assert np.isfinite(command.torque_at(posture, np.zeros(7))).all()
        assert np.array_equal(command.posture, same.posture)
        if "impedance" not in (first.controller, second.controller):
            assert np.abs(command.posture - posture).max() <= MAX_LEAD + 1e-9
    assert all(why)


HAND = 8.0
"""Largest force of a finger [N]."""
BOUNDS = PREPARED.map.bounds
POINTS = st.tuples(*(st.floats(float(low), float(high)) for low, high in BOUNDS.T))
SESSION_SETTINGS = st.builds(
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
        SESSION_SETTINGS,
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


def run_session(first, sensor, seed, acts):
    session = start(first, sensor, seed)
    down = {}
    frames = []
    for what in acts:
        act(session, what, down)
        frames += [session.tick() for _ in range(25)]
    return session, frames


@examples(40)
@given(SESSION_SETTINGS, SENSORS, st.integers(0, 9), ACTS)
def test_session_is_finite_bounded_and_deterministic(first, sensor, seed, acts):
    session, frames = run_session(first, sensor, seed, acts)
    _, again = run_session(first, sensor, seed, acts)
    fingers = 2 * HAND
    for frame, same in zip(frames, again, strict=True):
        assert np.isfinite(frame.posture).all()
        assert np.isfinite(frame.command.torque_at(frame.posture, frame.velocity)).all()
        assert np.abs(frame.velocity).max() < 4 * MAX_JOINT_SPEED
        assert np.array_equal(frame.posture, same.posture)
        assert frame.why_limited == same.why_limited
        assert sum(poke.force for poke in frame.pokes) <= fingers + 1e-6, "hands are all that presses"
    assert session.failure is None
