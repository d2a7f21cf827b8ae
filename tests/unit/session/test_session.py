"""A session tick by tick: scripted, deterministic, and told of its sensor and its substeps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SceneError, SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.scene.effects import Effects
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.session import Session, skin_readings, substeps
from tactile_maps.stimuli.stimulus_kinds import Poke, Stroke
from tactile_maps.stimuli.stimulus_player import FIRST_SCRIPTED_FINGER
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Sampling, Saturation, SensorEffects
from tests.support.touch import arm, prepared_bar


def test_a_tick_is_so_many_steps():
    assert [substeps(0.005, step) for step in (0.005, 0.001, 0.0005)] == [1, 5, 10]


@pytest.mark.parametrize("step", [0.003, 0.01, 0.0, -0.001, 1e-6, float("nan"), float("inf")])
def test_what_is_no_part_of_a_tick_is_refused(step):
    with pytest.raises(SimulationError, match="whole number"):
        substeps(0.005, step)


def told(**sensor):
    return skin_readings(Effects(sensor=SensorEffects(**sensor)), 0.005)


def test_rate_delay_and_end_come_from_the_effects():
    assert told() == SensorTiming(0.005, 0.0, math.inf)
    assert told(sampling=Sampling(20.0, 0.1)) == SensorTiming(0.05, 0.1, math.inf)
    assert told(sampling=Sampling(1000.0, 0.0)).period == 0.005, "no more often than a tick"
    assert told(saturation=Saturation(1e5)) == SensorTiming(0.005, 0.0, 1e5)


def test_a_mean_over_the_sample_time_is_half_of_that_time_older():
    slow = Effects(sensor=SensorEffects(sampling=Sampling(20.0, 0.1)), time_averaging=True)
    assert skin_readings(slow, 0.005) == SensorTiming(0.05, pytest.approx(0.125), averaged=True)
    assert skin_readings(Effects(time_averaging=True), 0.005) == SensorTiming(0.005, averaged=True)


BAR = prepared_bar(stimuli=(Stroke(hold=0.1),))
AT = BAR.skin.taxel_point(30)
THERE = BAR.skin.taxel_point(31)


def quiet(prepared=BAR) -> Session:
    return Session(prepared, scripted=False)


def same(one, other) -> bool:
    """Whether two frames are equal, bit for bit, but for the milliseconds they took."""
    arrays = [(getattr(one, n), getattr(other, n)) for n in ("posture", "velocity", "pressures", "objects")]
    arrays += [
        (getattr(one.command, n), getattr(other.command, n)) for n in ("posture", "stiffness", "damping", "torque")
    ]
    arrays += [(a.link_position, b.link_position) for a, b in zip(one.regions, other.regions, strict=True)]
    arrays += [(a.map_point, b.map_point) for a, b in zip(one.regions, other.regions, strict=True)]
    values = [[(r.id, r.force, r.at) for r in f.regions] + [(p.id, p.force, p.at) for p in f.pokes] + [f.time, f.tick]
              for f in (one, other)]  # fmt: skip
    return all(np.array_equal(a, b) for a, b in arrays) and values[0] == values[1]


def test_a_poke_is_felt_placed_and_released():
    session = Session(BAR, scripted=False, settings=ControlSettings(stiffness=40.0))
    session.submit(PokePressed(1, AT))
    assert session.frame.pokes == (), "at the next tick, not now"
    for _ in range(60):
        frame = session.tick()
    (poke,), (region,) = frame.pokes, frame.regions
    assert poke.force > 1
    assert frame.pressures @ BAR.skin.areas == pytest.approx(poke.force, rel=1e-12)
    assert region.force == pytest.approx(poke.force, rel=1e-9)
    assert np.linalg.norm(region.link_position - BAR.skin.position(AT)) < 0.012
    session.submit(PokeReleased(1))
    frame = session.tick()
    assert not frame.pressures.any()
    assert frame.regions == frame.pokes == ()


@pytest.mark.parametrize("averaging", [False, True])
def test_mean_readings_are_older_than_readings_of_an_instant(averaging):
    session = Session(BAR, effects=replace(BAR.scene.effects, time_averaging=averaging), scripted=False)
    session.submit(PokePressed(1, AT))
    while not (frame := session.tick()).regions:
        pass
    assert frame.regions[0].force_parts.get("sampling", 0.0) == pytest.approx(1.2 * averaging * frame.regions[0].force)


def test_sum_of_depths_is_a_force_of_unknown_accuracy():
    session = Session(BAR, effects=replace(BAR.scene.effects, skin="depth"), scripted=False)
    session.submit(PokePressed(1, AT, Finger(radius=0.05, speed=0.1)))
    while not (frame := session.tick()).regions:
        pass
    assert frame.regions[0].force_error == math.inf
    assert frame.regions[0].force_parts["contact_model"] == math.inf


def test_the_scripted_hand_plays_until_a_person_presses():
    session = Session(BAR)
    for _ in range(40):
        frame = session.tick()
    assert session.scripted
    assert [poke.id for poke in frame.pokes] == [FIRST_SCRIPTED_FINGER]
    session.submit(PokeReleased(5))
    session.submit(ControlChanged(ControlSettings(stiffness=9.0)))
    session.tick()
    assert session.scripted, "only a press is a touch"
    session.submit(PokePressed(1, AT))
    frame = session.tick()
    assert not session.scripted
    assert [poke.id for poke in frame.pokes] == [1]
    session.submit(PokeReleased(1))
    for _ in range(400):
        assert session.tick().pokes == ()


def test_all_scripted_fingers_lift_when_a_person_presses():
    session = Session(prepared_bar(stimuli=(Poke(at=(0.2, 0.25)), Poke(at=(0.8, 0.25), begin=0.0))))
    for _ in range(20):
        frame = session.tick()
    assert len(frame.pokes) > 1
    session.submit(PokePressed(1, AT))
    assert [poke.id for poke in session.tick().pokes] == [1]
    assert all(len(session.tick().pokes) == 1 for _ in range(400))


def test_same_inputs_same_frames_and_the_inputs_are_enough_to_repeat_it():
    acts = {30: [PokePressed(1, arm().skin.taxel_point(20))], 60: [PokeMoved(1, arm().skin.taxel_point(21))],
            80: [ControlChanged(ControlSettings(controller="hold_force"))], 150: [PokeReleased(1)]}  # fmt: skip

    def run(session):
        frames = []
        for tick in range(220):
            for act in acts.get(tick, []):
                session.submit(act)
            frames.append(session.tick())
        return frames

    first_session = Session(arm())
    first = run(first_session)
    second = run(Session(arm()))
    assert all(map(same, first, second))
    assert any(frame.regions for frame in first)
    replay = Session(arm(), scripted=False)
    waiting = list(first_session.inputs)[1:]
    for frame in first:
        while waiting and waiting[0][0] == frame.tick:
            replay.submit(waiting.pop(0)[1])
        assert same(replay.tick(), frame)
    assert not waiting


def test_reset_repeats_the_run_with_the_settings_in_force():
    session = quiet()
    session.submit(ControlChanged(ControlSettings(stiffness=12.0)))
    session.submit(PokePressed(1, AT))
    for _ in range(20):
        session.tick()
    session.reset()
    assert (session.frame.tick, session.frame.pokes) == (0, ())
    assert session.inputs == [(0, ControlChanged(ControlSettings(stiffness=12.0)))]
    fresh = Session(BAR, scripted=False, settings=ControlSettings(stiffness=12.0))
    for run in (session, fresh):
        run.submit(PokePressed(1, AT))
        for _ in range(50):
            run.tick()
    assert same(session.frame, fresh.frame)


@pytest.mark.parametrize("act", [PokeReleased(3), PokeMoved(3, AT)])
def test_acts_of_a_finger_that_is_not_down_do_nothing(act):
    session = quiet()
    untouched = quiet()
    session.submit(act)
    assert same(session.tick(), untouched.tick())


def test_pressing_twice_starts_afresh():
    session = quiet()
    session.submit(PokePressed(1, AT))
    for _ in range(40):
        session.tick()
    session.submit(PokePressed(1, THERE))
    frame = session.tick()
    assert [poke.at for poke in frame.pokes] == [THERE]
    assert frame.pokes[0].force < 0.1


@pytest.mark.parametrize(("act", "error", "words"), [
    (PokePressed(1, SurfacePoint(7, 0, (1.0, 0.0, 0.0))), SimulationError, "no such place"),
    (PokePressed(1, AT, Finger(stiffness=1e9)), SimulationError, "too stiff"),
    (ControlChanged(ControlSettings(force_goal=-1.0)), SceneError, "force_goal"),
    (EffectsChanged(replace(BAR.scene.effects, timestep=0.003)), SimulationError, "whole number of time steps"),
    (EffectsChanged(replace(BAR.scene.effects, timestep=float("nan"))), SimulationError, "whole number"),
])  # fmt: skip
def test_a_refused_input_leaves_the_session_as_it_was(act, error, words):
    session = quiet()
    other = quiet()
    for run in (session, other):
        run.tick()
    session.submit(act)
    with pytest.raises(error, match=words):
        session.tick()
    assert session.frame.tick == 1
    for _ in range(5):
        assert same(session.tick(), other.tick())
    assert session.inputs == other.inputs, "what had no effect is not recorded"
    assert session.effects == other.effects
    assert session.failure is None, "it did not stop by itself"


def test_why_limited_reaches_the_frame():
    prepared = prepared_bar()
    session = Session(prepared, scripted=False, settings=ControlSettings(controller="hold_force", force_goal=0.0))
    session.submit(PokePressed(1, prepared.skin.taxel_point(0), Finger(speed=0.1)))
    words = {word for _ in range(1500) for word in session.tick().why_limited}
    assert words


def test_a_robot_without_joints_runs_under_both_laws():
    for controller in ("impedance", "hold_force"):
        prepared = prepared_bar(hinged=False)
        session = Session(prepared, scripted=False, settings=ControlSettings(controller=controller))
        session.submit(PokePressed(1, AT))
        for _ in range(100):
            frame = session.tick()
        assert frame.posture.shape == (0,)
        assert frame.regions[0].force == pytest.approx(frame.pokes[0].force, rel=1e-9)


def test_a_scene_may_set_the_controller():
    assert quiet(replace(BAR, scene=replace(BAR.scene, control={"force_goal": 5.0}))).settings.force_goal == 5.0
    with pytest.raises(SceneError, match=r"control\.magic: there is no such key"):
        quiet(replace(BAR, scene=replace(BAR.scene, control={"magic": 1.0})))


def test_a_press_grows_to_its_force_and_ends_when_it_is_released():
    session = Session(BAR, scripted=False, settings=ControlSettings(controller="hold_force"))
    session.press(AT, force=1.5)
    frame = session.run_for(1.0)
    assert [poke.force for poke in frame.pokes] == [1.5]
    assert sum(region.force for region in frame.regions) == pytest.approx(1.5)
    session.release()
    assert not session.tick().pokes


def test_a_session_runs_for_all_of_its_seconds():
    session = quiet()
    assert session.run_for(1.0).time == pytest.approx(1.0)
    assert session.frame.tick == 200


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), -0.1])
def test_seconds_that_are_none_are_refused(seconds):
    session = quiet()
    with pytest.raises(SimulationError, match="duration is out of range"):
        session.run_for(seconds)
    assert session.tick().tick == 1


def test_a_watcher_is_told_every_tick_until_its_block_ends():
    session = quiet()
    seen = []
    with session.watched(lambda frame: seen.append(frame.tick)):
        session.run_for(0.025)
    session.tick()
    assert seen == [1, 2, 3, 4, 5]


def test_a_session_of_a_robot_and_a_map_is_alone_in_the_world():
    session = Session.of(BAR.robot, BAR.map, settings=ControlSettings(controller="hold_force"))
    assert session.settings.controller == "hold_force"
    assert not session.scripted
    assert session.prepared.skin is BAR.map.skin
    assert not session.run_for(0.05).regions


@pytest.mark.parametrize("name", ["force_goal", "max_force", "integral_time"])
def test_a_setting_that_is_no_number_cannot_be_made(name):
    with pytest.raises(SceneError, match=f"control.{name}"):
        ControlSettings(**{name: True})


@pytest.mark.parametrize("settings", [ControlSettings(starts=True), ControlSettings(stiffness=math.nan)])
def test_a_setting_out_of_range_is_refused_and_the_last_ones_stay(settings):
    session = quiet()
    session.submit(ControlChanged(settings))
    with pytest.raises(SceneError, match="control"):
        session.tick()
    assert session.settings == ControlSettings()
    assert session.tick().tick == 1
    assert session.inputs == [(0, ControlChanged(ControlSettings()))]
