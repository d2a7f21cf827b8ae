"""A session whose effects change while it runs, and what only some scenes have: stages, motion, objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.scene.bodies import make_bodies
from app.scene.motion import Waypoint
from app.scene.objects import ObjectSpec
from app.session.inputs import EffectsChanged
from app.session.session import Session
from app.stimuli.poke import Poke
from app.stimuli.stroke import Stroke
from app.touch.poke import PokePressed
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from tests.touch import prepared_bar

BAR = prepared_bar(stimuli=(Stroke(hold=0.1),))
AT = BAR.skin.taxel_point(30)


def quiet(prepared=BAR) -> Session:
    return Session(prepared, scripted=False)


def test_every_stage_is_timed_and_there_is_none_without_its_effect():
    session = quiet()
    assert list(session.tick().timings.ms) == ["physics", "touch", "contacts", "control"]
    noisy = replace(session.effects, sensor=SensorEffects(noise=Noise()))
    session.submit(EffectsChanged(noisy))
    assert list(session.tick().timings.ms) == ["physics", "touch", "noise", "contacts", "control"]
    session.submit(EffectsChanged(replace(noisy, skin="off")))
    frame = session.tick()
    assert list(frame.timings.ms) == ["physics", "control"]
    assert not frame.pressures.any()


def test_effects_change_at_the_next_tick_and_only_them():
    session, other = quiet(), quiet()
    for run in (session, other):
        run.submit(PokePressed(1, AT))
        for _ in range(30):
            run.tick()
    wanted = replace(session.effects, sensor=SensorEffects(noise=Noise()))
    session.submit(EffectsChanged(wanted))
    assert session.effects == BAR.scene.effects, "at the next tick, not now"
    frame, plain = session.tick(), other.tick()
    assert session.effects == wanted
    assert session.inputs[-1] == (31, EffectsChanged(wanted))
    assert np.array_equal(frame.posture, plain.posture), "the state stays"
    assert [poke.force for poke in frame.pokes] == [poke.force for poke in plain.pokes]
    assert not np.array_equal(frame.pressures, plain.pressures)
    session.reset()
    assert session.inputs[1:] == [(0, EffectsChanged(wanted))], "effects in force stay, and a replay knows them"


def test_a_finer_time_step_is_stepped_as_often_as_a_tick_needs():
    session = quiet()
    session.submit(EffectsChanged(replace(session.effects, timestep=0.0005)))
    for _ in range(20):
        session.tick()
    assert session._simulation.time == pytest.approx(session.frame.time)


def test_fingers_that_are_off_keep_the_scripted_hand_away():
    session = Session(BAR)
    assert session.tick().pokes
    off = replace(session.effects, fingers=False)
    session.submit(EffectsChanged(off))
    assert all(not session.tick().pokes for _ in range(300))
    session.submit(EffectsChanged(replace(off, fingers=True)))
    assert any(session.tick().pokes for _ in range(2000)), "the script went on meanwhile"


def test_fingers_switched_off_just_when_the_script_presses_are_no_failure():
    session = Session(prepared_bar(stimuli=(Poke(hold=0.01, rest=0.005),)))
    on = session.effects
    felt = 0
    for number in range(60):
        session.submit(EffectsChanged(replace(on, fingers=number % 4 < 2)))
        felt += len(session.tick().pokes)
    assert felt > 5


def test_a_motion_moves_what_the_controller_holds():
    session = Session(prepared_bar(motion=(Waypoint(posture=(0.5,), seconds=1.0, rest=5.0),)))
    assert session.frame.command.posture == [0.0]
    for _ in range(100):
        session.tick()
    assert session.frame.command.posture == pytest.approx([0.25]), "half way after half the time"
    for _ in range(400):
        session.tick()
    assert session.frame.posture == pytest.approx([0.5], abs=0.01)
    session.reset()
    assert session.frame.command.posture == [0.0]


def test_objects_have_poses_in_every_frame():
    ball = ObjectSpec("ball", "sphere", size=(0.05,), at=(1.0, 2.0, 3.0), mass=0.1)
    prepared = prepared_bar(objects=(ball,), task="push", wishes={"gravity": "on"})
    session = quiet(replace(prepared, objects=make_bodies(prepared.scene)))
    assert session.frame.objects.shape == (1, 4, 4)
    assert session.frame.objects[0, :3, 3] == pytest.approx([1, 2, 3])
    for _ in range(20):
        session.tick()
    assert session.frame.objects[0, 2, 3] == pytest.approx(3 - 0.5 * 9.81 * 0.1**2, abs=1e-3), "it falls"


def test_a_scripted_finger_that_is_refused_ends_the_show_and_time_goes_on():
    stiff = Stroke(start=(0.95, 0.5), end=(0.9, 0.5), stiffness=1e6)
    session = Session(prepared_bar(stimuli=(stiff,)))
    with pytest.raises(SimulationError, match="too stiff"):
        session.tick()
    assert not session.scripted
    assert [session.tick().tick for _ in range(3)] == [1, 2, 3]
