"""Effects switched at random while a hand presses: frames mean something, and the same switches repeat the same run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.control.command import ControlSettings
from app.scene.bodies import make_bodies
from app.scene.effects import Effects
from app.scene.objects import ObjectSpec
from app.session.frame import Frame
from app.session.inputs import EffectsChanged
from app.session.prepare import Prepared
from app.session.session import Session
from app.touch.poke import PokePressed, PokeReleased
from app.touch.sensor.crosstalk import Crosstalk
from app.touch.sensor.dead_taxels import DeadTaxels
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.gain_spread import GainSpread
from app.touch.sensor.hysteresis import Hysteresis
from app.touch.sensor.noise import Noise
from app.touch.sensor.offset_drift import OffsetDrift
from app.touch.sensor.sampling import Sampling
from tests.touch import prepared_bar

TICKS = 4


BALL = ObjectSpec("ball", "sphere", size=(0.03,), at=(0.3, 0.0, 0.051), mass=0.2)


@cache
def bar() -> Prepared:
    """A ball 1 mm above the bar, which it falls on where there are gravity and contact."""
    prepared = prepared_bar(objects=(BALL,), wishes={"fingers": "on"})
    return replace(prepared, objects=make_bodies(prepared.scene))


sensors = st.builds(
    SensorEffects, noise=st.sampled_from([None, Noise(), Noise(sd=5.0)]),
    crosstalk=st.sampled_from([None, Crosstalk()]), hysteresis=st.sampled_from([None, Hysteresis()]),
    gain_spread=st.sampled_from([None, GainSpread()]),
    offset_drift=st.sampled_from([None, OffsetDrift()]), sampling=st.sampled_from([None, Sampling()]),
    dead_taxels=st.sampled_from([None, DeadTaxels(dead=0.3)]),
)  # fmt: skip
effects = st.builds(
    Effects, gravity=st.sampled_from(["off", "on", "compensated"]), contact=st.sampled_from(["off", "self", "all"]),
    joint_limits=st.booleans(), timestep=st.sampled_from([0.0005, 0.001]), dynamics=st.booleans(),
    fingers=st.booleans(), friction=st.booleans(), joint_friction=st.booleans(),
    skin=st.sampled_from(["off", "point", "water-fill", "punch", "foundation", "depth"]),
    integrator=st.sampled_from(["implicitfast", "discrete", "implicit"]), sensor=sensors,
)  # fmt: skip
switches = st.lists(effects, min_size=1, max_size=6)


def play(script: list[Effects], *, press: int) -> tuple[Session, list[Frame]]:
    """Four ticks under each of the effects, a finger down from ``press`` on wherever fingers can be."""
    session = Session(bar(), scripted=False, settings=ControlSettings(stiffness=20.0))
    frames = [session.tick() for _ in range(TICKS)]
    for number, wanted in enumerate(script):
        session.submit(EffectsChanged(wanted))
        if wanted.fingers and number >= press:
            session.submit(PokePressed(1, bar().skin.taxel_point(30)))
        frames += [session.tick() for _ in range(TICKS)]
        assert session.effects == wanted
    return session, frames


def repeat(played: Session) -> list[Frame]:
    """A fresh session given what the other one did at its ticks."""
    session, frames, waiting = Session(bar(), scripted=False), [], list(played.inputs)
    while session.frame.tick < played.frame.tick:
        while waiting and waiting[0][0] <= session.frame.tick + 1:
            session.submit(waiting.pop(0)[1])
        frames.append(session.tick())
    assert not waiting
    return frames


@given(script=switches, press=st.integers(0, 3))
@settings(max_examples=20, deadline=None)
def test_any_switches_give_frames_that_mean_something_and_repeat_bit_for_bit(script, press):
    session, frames = play(script, press=press)
    assert sum(isinstance(act, EffectsChanged) for _, act in session.inputs) == len(script)
    for frame, other in zip(frames, repeat(session), strict=True):
        for name in ("posture", "velocity", "pressures", "objects"):
            assert np.isfinite(getattr(frame, name)).all()
            assert getattr(frame, name).tobytes() == getattr(other, name).tobytes()


@given(script=switches, press=st.integers(0, 3))
@settings(max_examples=12, deadline=None)
def test_switching_effects_moves_nothing_by_itself(script, press):
    """Where the robot is when an effect is switched is where it goes on: within what a tick moves it."""
    session, _ = play(script[:-1] or script, press=press)
    session.submit(PokeReleased(1))
    before = session.tick()
    session.submit(EffectsChanged(script[-1]))
    after = session.tick()
    most = (np.abs(before.velocity).max() + 1.0) * bar().scene.tick
    assert not script[-1].dynamics or np.abs(after.posture - before.posture).max() <= most


@given(effects=effects)
@settings(max_examples=12, deadline=None)
def test_a_reset_repeats_what_a_fresh_session_with_these_effects_does(effects):
    session = Session(bar(), scripted=False)
    session.tick()
    session.submit(EffectsChanged(effects))
    for _ in range(TICKS):
        session.tick()
    session.reset()
    fresh = Session(bar(), scripted=False, effects=effects)
    assert session.effects == effects
    assert (effects == bar().scene.effects) == (len(session.inputs) == 1)
    for _ in range(TICKS):
        one, other = session.tick(), fresh.tick()
        assert one.posture.tobytes() == other.posture.tobytes()
        assert one.pressures.tobytes() == other.pressures.tobytes()
