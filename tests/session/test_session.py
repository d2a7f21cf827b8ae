"""A session tick by tick: inputs, script, reproducibility, failures."""

from __future__ import annotations

import gc
import math
import weakref
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings, JointCommand
from tactile_maps.control.path_following import clearance
from tactile_maps.core.errors import RecordingError, SceneError, SimulationError, SkinError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.recording.encoding.frame_codec import decode_frame, encode_frame
from tactile_maps.robots.library import load_robot
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame, MeasuredValues
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.session import Session, skin_readings
from tactile_maps.stimuli.stimulus_kinds import Poke
from tactile_maps.stimuli.stimulus_player import FIRST_SCRIPTED_FINGER
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Sampling, Saturation, SensorEffects
from tests.support.sessions import run, same
from tests.support.touch import arm, prepared_bar

BAR = prepared_bar()
AT = BAR.skin.taxel_point(30)
OTHER = BAR.skin.taxel_point(31)
FOLLOWS_PATH = ControlSettings(controller="hybrid", task="follow_path", path_kind="lemniscate", path_size=0.03)


@pytest.mark.parametrize(
    ("sensor", "averaged", "timing"),
    [
        ({}, False, SensorTiming(0.005, 0.0, math.inf)),
        ({"sampling": Sampling(20.0, 0.1)}, False, SensorTiming(0.05, 0.1, math.inf)),
        ({"sampling": Sampling(1000.0, 0.0)}, False, SensorTiming(0.005, 0.0, math.inf)),
        ({"saturation": Saturation(1e5)}, False, SensorTiming(0.005, 0.0, 1e5)),
        ({"sampling": Sampling(20.0, 0.1)}, True, SensorTiming(0.05, pytest.approx(0.125), averaged=True)),
        ({}, True, SensorTiming(0.005, averaged=True)),
    ],
)
def test_timing_of_the_readings_follows_from_the_effects(sensor, averaged, timing):
    assert skin_readings(Effects(sensor=SensorEffects(**sensor), time_averaging=averaged), 0.005) == timing


def test_shapes_for_a_path_are_built_when_it_is_requested(monkeypatch):
    built = Mock(wraps=clearance.compile_spec)
    monkeypatch.setattr(clearance, "compile_spec", built)
    session = Session(replace(BAR, robot=replace(BAR.robot)))
    assert built.call_count == 0
    session.submit(ControlChanged(FOLLOWS_PATH))
    assert built.call_count == 1, "they take longer than a tick"


def test_nothing_keeps_the_robot_and_skin_of_a_session_that_is_closed():
    skin = replace(BAR.skin)
    opened = replace(BAR, robot=replace(BAR.robot), skin=skin, map=replace(BAR.map, skin=skin))
    session = Session(opened)
    session.submit(PokePressed(1, AT))
    session.submit(ControlChanged(FOLLOWS_PATH))
    session.tick()
    kept = weakref.ref(opened.robot), weakref.ref(skin)
    del opened, session, skin
    gc.collect()
    assert [one() for one in kept] == [None, None]


def test_poke_is_measured_located_and_released():
    session = Session(BAR, settings=ControlSettings(stiffness=40.0))
    session.submit(PokePressed(1, AT))
    assert session.frame.pokes == (), "inputs take effect at the next tick"
    frame = run(session, 60)[-1]
    (poke,), (region,) = frame.pokes, frame.regions
    assert poke.force > 1
    assert frame.pressures @ BAR.skin.areas == pytest.approx(poke.force, rel=1e-12)
    assert region.force == pytest.approx(poke.force, rel=1e-9)
    assert np.linalg.norm(region.link_position - BAR.skin.position(AT)) < 0.012
    (frame,) = run(session, 1, {0: [PokeReleased(1)]})
    assert not frame.pressures.any()
    assert frame.regions == frame.pokes == ()


@pytest.mark.parametrize(
    ("effects", "finger", "part", "share"),
    [
        ({}, Finger(), "sampling", 0.0),
        ({"time_averaging": True}, Finger(), "sampling", 1.2),
        ({"skin": "depth"}, Finger(radius=0.05, speed=0.1), "contact_model", math.inf),
    ],
)
def test_force_error_of_the_first_contact_follows_from_the_effects(effects, finger, part, share):
    session = Session(BAR, effects=replace(BAR.scene.effects, **effects))
    session.submit(PokePressed(1, AT, finger))
    while not (frame := session.tick()).regions:
        pass
    (region,) = frame.regions
    assert region.force_parts.get(part, 0.0) == pytest.approx(share * region.force)
    assert (region.force_error == math.inf) == (share == math.inf)


def test_script_plays_until_the_user_presses_and_all_its_fingers_lift():
    session = Session(prepared_bar(stimuli=(Poke(at=(0.2, 0.25)), Poke(at=(0.8, 0.25), begin=0.0))))
    frame = run(session, 20)[-1]
    assert [poke.id for poke in frame.pokes] == [FIRST_SCRIPTED_FINGER, FIRST_SCRIPTED_FINGER - 1]
    run(session, 1, {0: [PokeReleased(5), ControlChanged(ControlSettings(stiffness=9.0))]})
    assert session.scripted, "only a press ends the script"
    (frame,) = run(session, 1, {0: [PokePressed(1, AT)]})
    assert not session.scripted
    assert [poke.id for poke in frame.pokes] == [1]
    assert not any(frame.pokes for frame in run(session, 400, {0: [PokeReleased(1)]}))


def test_same_inputs_give_the_same_frames_also_from_the_log():
    skin = arm().skin
    inputs = {
        30: [PokePressed(1, skin.taxel_point(20))],
        60: [PokeMoved(1, skin.taxel_point(21))],
        80: [ControlChanged(ControlSettings(controller="hold_force"))],
        150: [PokeReleased(1)],
    }
    first = Session(arm())
    frames = run(first, 220, inputs)
    assert any(frame.regions for frame in frames)
    assert all(map(same, frames, run(Session(arm()), 220, inputs)))
    logged: dict[int, list] = {}
    for tick, each in list(first.inputs)[1:]:
        logged.setdefault(tick - 1, []).append(each)
    assert all(map(same, frames, run(Session(arm(), scripted=False), 220, logged)))


def test_reset_repeats_the_run_with_the_current_settings():
    settings = ControlSettings(stiffness=12.0)
    session = Session(BAR)
    run(session, 20, {0: [ControlChanged(settings), PokePressed(1, AT)]})
    session.reset()
    assert (session.frame.tick, session.frame.pokes) == (0, ())
    assert session.inputs == [(0, ControlChanged(settings))]
    press = {0: [PokePressed(1, AT)]}
    assert same(run(session, 50, press)[-1], run(Session(BAR, settings=settings), 50, press)[-1])


@pytest.mark.parametrize("ignored", [PokeReleased(3), PokeMoved(3, AT)])
def test_moving_or_releasing_a_lifted_finger_has_no_effect(ignored):
    assert same(run(Session(BAR), 1, {0: [ignored]})[0], Session(BAR).tick())


def test_second_press_of_a_finger_starts_again_at_the_new_place():
    frame = run(Session(BAR), 41, {0: [PokePressed(1, AT)], 40: [PokePressed(1, OTHER)]})[-1]
    assert [poke.at for poke in frame.pokes] == [OTHER]
    assert frame.pokes[0].force < 0.1


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("rejected", "error", "words"),
    [
        (PokePressed(1, SurfacePoint(7, 0, (1.0, 0.0, 0.0))), SimulationError, "not on the skin"),
        (PokePressed(1, AT, Finger(stiffness=1e9)), SimulationError, "too stiff"),
        (ControlChanged(ControlSettings(force_goal=-1.0)), SceneError, "force_goal"),
        (ControlChanged(ControlSettings(starts=True)), SceneError, "control"),
        (ControlChanged(ControlSettings(stiffness=math.nan)), SceneError, "control"),
        *(
            (EffectsChanged(replace(BAR.scene.effects, timestep=step)), SimulationError, "whole number of time steps")
            for step in (0.003, 0.01, 0.0, -0.001, 1e-6, math.nan, math.inf)
        ),
    ],
)
def test_rejected_input_leaves_the_session_unchanged(rejected, error, words):
    session = Session(BAR)
    other = Session(BAR)
    run(session, 1)
    run(other, 1)
    session.submit(rejected)
    with pytest.raises(error, match=words):
        session.tick()
    assert all(map(same, run(session, 5), run(other, 5)))
    assert session.inputs == other.inputs, "a rejected input is not logged"
    assert (session.effects, session.settings) == (other.effects, other.settings)
    assert session.failure is None


def test_controller_setting_must_be_a_number():
    with pytest.raises(SceneError, match="control.force_goal"):
        ControlSettings(force_goal=True)


@pytest.mark.long
def test_limits_of_the_controller_are_part_of_the_frame():
    session = Session(BAR, settings=ControlSettings(controller="hold_force", force_goal=0.0))
    frames = run(session, 1500, {0: [PokePressed(1, BAR.skin.taxel_point(0), Finger(speed=0.1))]})
    assert any(frame.why_limited for frame in frames)


@pytest.mark.parametrize("controller", ["impedance", "hold_force"])
def test_robot_without_joints_can_be_touched(controller):
    session = Session(prepared_bar(hinged=False), settings=ControlSettings(controller=controller))
    frame = run(session, 100, {0: [PokePressed(1, AT)]})[-1]
    assert frame.posture.shape == (0,)
    assert frame.regions[0].force == pytest.approx(frame.pokes[0].force, rel=1e-9)


def test_session_of_robot_and_map_is_pressed_released_and_watched():
    session = Session.of(BAR.robot, BAR.map, settings=ControlSettings(controller="hold_force"))
    assert (session.settings.controller, session.scripted) == ("hold_force", False)
    assert session.prepared.skin is BAR.map.skin
    seen = []
    session.press(AT, force=1.5)
    with session.watched(lambda frame: seen.append(frame.tick)):
        frame = session.run_for(1.0)
    assert frame.time == pytest.approx(1.0)
    assert seen == list(range(1, 201))
    assert [poke.force for poke in frame.pokes] == [1.5]
    assert sum(region.force for region in frame.regions) == pytest.approx(1.5)
    session.release()
    assert not session.tick().pokes
    assert len(seen) == 200
    for seconds in (math.nan, math.inf, -0.1):
        with pytest.raises(SimulationError, match="duration is out of range"):
            session.run_for(seconds)
    with pytest.raises(SimulationError, match=r"shorter than a tick \(found: 0.0013 s\).*0.005 s"):
        session.run_for(0.0013)
    assert session.frame.tick == 201


def test_frame_owns_its_arrays():
    none = np.zeros(0)
    pressures = np.zeros(3)
    frame = Frame(1, 0.005, none, none, pressures, (), (), JointCommand(none, none, none, none))
    pressures[0] = 1
    assert frame.pressures[0] == 0
    assert not frame.posture.flags.writeable


RAW = np.where(np.arange(60) == 7, np.nan, np.arange(60.0))
SENT = MeasuredValues(RAW, "counts", 12.5, 3, ReadingUnits.COUNTS)


def test_values_of_a_real_skin_are_restored_from_their_encoding():
    frame = Session(BAR).frame
    assert (frame.units, decode_frame(encode_frame(frame), BAR).measured) == (ReadingUnits.CALIBRATED, None)
    back = decode_frame(encode_frame(replace(frame, measured=SENT)), BAR)
    assert back.units is ReadingUnits.COUNTS
    assert np.array_equal(back.measured.raw, RAW, equal_nan=True)
    assert (back.measured.unit, back.measured.sent, back.measured.sequence) == ("counts", 12.5, 3)
    assert not back.measured.raw.flags.writeable


@pytest.mark.parametrize("raw", [RAW[:9], np.zeros(0), np.full(60, np.inf)])
def test_encoded_values_that_do_not_fit_the_skin_are_rejected(raw):
    data = encode_frame(replace(Session(BAR).frame, measured=replace(SENT, raw=raw)))
    with pytest.raises(RecordingError, match="raw value"):
        decode_frame(data, BAR)


def diverging() -> Session:
    """Return a session that diverges when the finger touches, and run it until then.

    Explicit damping of such stiff, strongly damped joints diverges within one control tick, before a monitor of the
    speed can stop it.
    """
    prepared = prepared_bar(tick=0.2, overrides={"integrator": "euler", "timestep": 0.02})
    session = Session(prepared, settings=ControlSettings(stiffness=40.0, damping_ratio=3.0))
    with pytest.raises(SimulationError, match="diverged") as caught:
        run(session, 400, {5: [PokePressed(1, AT, Finger(stiffness=10.0))]})
    assert session.failure is not None
    assert session.failure.problem == str(caught.value)
    return session


def test_diverged_session_keeps_the_inputs_of_the_failure_until_a_reset():
    session = diverging()
    failure = session.failure
    assert failure.frame is session.frame
    assert failure.tick == session.frame.tick + 1
    assert np.isfinite(failure.frame.posture).all()
    assert [type(each).__name__ for _, each in failure.inputs] == ["ControlChanged", "PokePressed"]
    with pytest.raises(SimulationError, match="diverged"):
        session.tick()
    assert session.frame.tick == failure.tick - 1
    again = diverging().failure
    assert (again.tick, again.problem) == (failure.tick, failure.problem)
    session.reset()
    assert session.failure is None
    assert session.tick().tick == 1


def test_map_of_another_robot_is_rejected_with_its_link_and_the_links_of_the_robot():
    with pytest.raises(SkinError, match=f"does not have.*{BAR.skin.patches[0].link}.*: .*upper_arm, "):
        Session.of(load_robot("arm"), BAR.map)
